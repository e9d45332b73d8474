#!/usr/bin/env python3
"""Tests of the web page in a headless Chromium. scripts/web.sh must have built it, and cargo the program.

Needs Chromium with its driver, and the Python package selenium.
"""

import functools
import http.server
import json
import pathlib
import shutil
import subprocess
import tempfile
import threading
import time
import unittest

from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By

ROOT = pathlib.Path(__file__).resolve().parent.parent
PAGE = ROOT / "target" / "web"
PROGRAM = ROOT / "target" / "release" / "pathmarch"

# Small, so that all samples are done soon; every kind of light and a custom field.
SCENE = """pathmarch 1
camera "main" { position 0 1.2 4; target 0 0.5 0; fov 35 }
render { size 96 54; samples 8; bounces 3 }
sky 0.3 0.4 0.6
sun { direction 1 1 0.5; irradiance 2; angle 3 }
param "radius" 0.5 min=0.1 max=0.9 doc="Radius of the ball."
field "wobble" { lipschitz 2; bounds 1; wgsl "fn distance(p: vec3f) -> f32 { return length(p) - 0.4 - 0.05 * sin(9.0 * p.x); }" }
material "clay" { diffuse 0.7 0.3 0.1 }
material "gold" { metal 0.9 0.7 0.3; roughness 0.3 }
object "ball" material="clay" { sphere "radius" { at -0.6 0.5 0 } }
object "odd" material="gold" { wobble { at 0.7 0.5 0 } }
object "floor" material="clay" { plane }
"""


class Quiet(http.server.SimpleHTTPRequestHandler):
    def log_message(self, *_):
        pass


def serve():
    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(Quiet, directory=PAGE))
    threading.Thread(target=server.serve_forever, daemon=True).start()
    return server


class Page(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = serve()
        cls.address = f"http://127.0.0.1:{cls.server.server_port}/"
        cls.downloads = pathlib.Path(tempfile.mkdtemp())
        options = webdriver.ChromeOptions()
        for argument in (
            "--headless=new",
            "--no-sandbox",
            "--disable-dev-shm-usage",
            "--window-size=1200,800",
            # A GPU in software, as no other is there.
            "--enable-unsafe-webgpu",
            "--use-webgpu-adapter=swiftshader",
        ):
            options.add_argument(argument)
        options.add_experimental_option("prefs", {"download.default_directory": str(cls.downloads), "profile.default_content_setting_values.automatic_downloads": 1})
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        options.binary_location = shutil.which("chromium") or shutil.which("google-chrome")
        cls.browser = webdriver.Chrome(options, webdriver.ChromeService(shutil.which("chromedriver")))
        cls.browser.set_script_timeout(300)

    @classmethod
    def tearDownClass(cls):
        cls.browser.quit()
        cls.server.shutdown()
        shutil.rmtree(cls.downloads, ignore_errors=True)

    def tearDown(self):
        severe = [entry["message"] for entry in self.browser.get_log("browser") if entry["level"] == "SEVERE"]
        self.assertEqual(severe, [])

    def open(self, fragment=""):
        self.browser.get("about:blank")
        self.browser.get(self.address + fragment)

    def script(self, code, *arguments):
        return self.browser.execute_script(code, *arguments)

    def find(self, selector):
        return self.browser.find_element(By.CSS_SELECTOR, selector)

    def until(self, what, seconds=300):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            result = what()
            if result:
                return result
            time.sleep(0.05)
        self.fail(f"nothing after {seconds} s; the page says: {self.status()}")

    def status(self):
        return self.script("return document.querySelector('#status').textContent + ' ' + document.querySelector('#message').textContent")

    def samples(self):
        return int(self.script("return document.body.dataset.samples ?? 0") or 0)

    def type(self, text):
        """Replaces the text as a person would by pasting."""
        self.script(
            "const area = document.querySelector('#area'); area.focus(); area.select(); document.execCommand('insertText', false, arguments[0])",
            text,
        )

    def open_scene(self, text):
        self.open("#gallery=ten-lines")
        self.until(lambda: self.samples() > 0)
        self.type(text)

    def text(self):
        return self.script("return document.querySelector('#area').value")

    def mistakes(self):
        return self.script("return [...document.querySelectorAll('#mistakes li')].map((item) => item.textContent)")

    def pixels(self):
        """Sum of the codes of the preview, which every motion changes."""
        return self.script(
            "const c = document.querySelector('#preview'); const d = c.getContext('2d').getImageData(0, 0, c.width, c.height).data;"
            "let s = 0; for (let k = 0; k < d.length; k++) s += d[k] * (1 + (k % 97)); return s"
        )

    def download(self, button, name):
        path = self.downloads / name
        path.unlink(missing_ok=True)
        self.script("document.querySelector(arguments[0]).click()", button)
        self.until(path.exists)
        return path

    def choose(self, selector, value):
        self.script(
            "const box = document.querySelector(arguments[0]); box.value = arguments[1]; box.dispatchEvent(new Event('change'))",
            selector,
            value,
        )

    def test_a_picture_equals_that_of_the_program(self):
        for backend in ("cpu", "gpu"):
            with self.subTest(backend):
                self.compare_with_program(backend)

    def compare_with_program(self, backend):
        self.open_scene(SCENE)
        self.choose("#backend", backend)
        self.choose("#size", "scene")
        self.until(lambda: "96×54 · done" in self.status() and backend.upper() in self.status(), 120)
        self.assertNotIn("GPU:", self.status())
        page = self.download("#exr", "ten-lines.exr")
        with tempfile.TemporaryDirectory() as folder:
            scene, native = pathlib.Path(folder, "scene.kdl"), pathlib.Path(folder, "native.exr")
            scene.write_text(SCENE)
            render = [PROGRAM, "render", scene, "-o", native, "--backend", "cpu", "--splitting", "1"]
            subprocess.run(render, check=True, capture_output=True)
            compare = subprocess.run([PROGRAM, "compare", page, native, "--json"], check=True, capture_output=True)
        # Other rounding makes a few paths go another way.
        self.assertLess(json.loads(compare.stdout)["relmse"], 1e-4 if backend == "cpu" else 1e-3)
        self.assertGreater(self.download("#png", "ten-lines.png").stat().st_size, 1000)

    def test_mistakes_are_listed_and_underlined_while_the_last_picture_stays(self):
        self.open_scene(SCENE.replace("sphere", "spere").replace("angle", "angel"))
        found = self.until(lambda: len(self.mistakes()) == 2 and self.mistakes())
        self.assertIn("Did you mean `sphere`?", " ".join(found))
        marked = self.script("return [...document.querySelectorAll('#underlines .wrong')].map((mark) => mark.textContent)")
        self.assertEqual(sorted(marked), ["angel", "spere"])
        self.type(SCENE)
        self.until(lambda: not self.mistakes() and self.samples() > 0)

    def test_a_slider_changes_the_text_and_undo_restores_it(self):
        self.open_scene(SCENE)
        self.until(lambda: self.samples() > 0 and self.text() == SCENE)
        self.find("[data-panel=controls]").click()
        slider = self.until(lambda: self.browser.find_elements(By.CSS_SELECTOR, "#controls details[open] input[type=range]"))[0]
        self.script("arguments[0].value = 0.8; arguments[0].dispatchEvent(new Event('input'))", slider)
        self.until(lambda: '"radius" 0.8' in self.text())
        self.find("#undo").click()
        self.until(lambda: self.text() == SCENE)

    def test_a_drag_orbits_and_the_view_can_be_written(self):
        self.open_scene(SCENE)
        self.until(lambda: self.samples() > 0 and self.text() == SCENE)
        before = self.pixels()
        drag = ActionChains(self.browser).move_to_element(self.find("#viewport"))
        drag.click_and_hold().move_by_offset(150, 0).release().perform()
        self.until(lambda: self.pixels() != before)
        self.find("#write-view").click()
        self.until(lambda: self.text() != SCENE)
        self.assertNotIn("position 0 1.2 4", self.text())

    def test_a_link_opens_the_same_scene(self):
        self.open_scene(SCENE)
        self.until(lambda: self.samples() > 0 and self.text() == SCENE)
        self.find("#share").click()
        link = self.until(lambda: "#scene=" in self.browser.current_url and self.browser.current_url)
        self.open(link.removeprefix(self.address))
        self.until(lambda: self.text() == SCENE and self.samples() > 0)
        self.open(link.removeprefix(self.address)[:40])
        self.until(lambda: "damaged" in self.status() or self.text() != SCENE)

    def test_a_lost_gpu_leaves_the_work_to_the_cpu(self):
        self.open_scene(SCENE)
        self.choose("#backend", "gpu")
        self.until(lambda: "GPU (" in self.status() and self.samples() > 0)
        page = self.browser.current_window_handle
        self.browser.switch_to.new_window("tab")
        crashed = self.browser.current_window_handle
        self.browser.get("chrome://gpucrash")
        self.browser.switch_to.window(page)
        self.type(SCENE.replace("0.7 0.3 0.1", "0.1 0.7 0.3"))
        self.until(lambda: "done" in self.status())
        self.browser.switch_to.window(crashed)
        self.browser.close()
        self.browser.switch_to.window(page)
        self.browser.get_log("browser")

    def test_a_hidden_page_rests(self):
        self.open("#gallery=cornell")
        self.until(lambda: self.samples() > 0)
        self.script("Object.defineProperty(document, 'hidden', { value: true, configurable: true })")
        time.sleep(3)
        before = self.samples()
        time.sleep(3)
        self.assertEqual(self.samples(), before)
        self.script("delete document.hidden; document.dispatchEvent(new Event('visibilitychange'))")
        self.until(lambda: self.samples() > before)

    def test_a_huge_picture_is_limited(self):
        self.open_scene(SCENE.replace("size 96 54", "size 16384 16384"))
        self.choose("#size", "scene")
        self.until(lambda: "2880×2880" in self.status())

    def test_scenes_with_files_are_rendered(self):
        for name in ("environment", "statue"):
            self.open(f"#gallery={name}")
            self.until(lambda: self.samples() > 0)
            self.assertEqual(self.mistakes(), [])

    def test_the_text_survives_a_reload(self):
        edited = SCENE.replace("0.7 0.3 0.1", "0.1 0.3 0.7")
        self.open_scene(edited)
        self.until(lambda: self.samples() > 0 and self.text() == edited)
        self.open()
        self.until(lambda: self.text() == edited)

    def test_a_text_that_breaks_the_module_leaves_the_page_alive(self):
        deep = "(" * 200_000 + "1.0" + ")" * 200_000
        self.open_scene(SCENE.replace("0.05", deep))
        self.until(lambda: self.mistakes() or "cannot be read" in self.status())
        self.type(SCENE)
        self.until(lambda: self.samples() > 0 and not self.mistakes())
        # The console reports the end of the instance.
        self.browser.get_log("browser")

    def test_the_first_picture_is_soon(self):
        self.open("#gallery=ten-lines")
        began = time.monotonic()
        self.until(lambda: self.script("return document.querySelector('#preview').width") != 300)
        print(f"first picture {time.monotonic() - began:.2f} s after load", flush=True)

    def test_a_phone_shows_picture_and_text(self):
        self.browser.set_window_size(390, 844)
        try:
            self.open("#gallery=ten-lines")
            self.until(lambda: self.samples() > 0)
            wide = self.script("return document.documentElement.scrollWidth - window.innerWidth")
            self.assertLessEqual(wide, 0)
            self.assertGreater(self.find("#area").size["height"], 150)
        finally:
            self.browser.set_window_size(1200, 800)


if __name__ == "__main__":
    unittest.main(verbosity=2)
