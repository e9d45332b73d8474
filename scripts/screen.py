"""A virtual display with a window of the program, driven by mouse and keyboard. Needs Xvfb and xdotool."""

import hashlib
import os
import pathlib
import subprocess
import time

# Header of the frame buffer file of Xvfb, before the pixels.
XWD_HEADER = 4096


class Screen:
    """Xvfb, and at most one window in it."""

    def __init__(self, directory, size="700x460"):
        self.directory = pathlib.Path(directory)
        self.size = size.split("x")
        self.buffer = self.directory / "Xvfb_screen0"
        read, write = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{size}x24", "-fbdir", str(self.directory), "-nolisten", "tcp", "-noreset"],
            pass_fds=[write],
            stderr=subprocess.DEVNULL,
        )
        os.close(write)
        with os.fdopen(read) as pipe:
            self.name = ":" + pipe.readline().strip()
        self.environment = {
            **os.environ,
            "DISPLAY": self.name,
            "PATHMARCH_HOME": str(self.directory / "home"),
        }
        self.environment.pop("WAYLAND_DISPLAY", None)
        self.program = None

    def start(self, *command, log=None):
        """Starts the program, and waits for its window, which fills the display."""
        self.program = subprocess.Popen(command, env=self.environment, stdout=subprocess.DEVNULL, stderr=log or subprocess.DEVNULL)
        while True:
            found = self.xdotool("search", "--onlyvisible", "--pid", str(self.program.pid), check=False).split()
            if found:
                break
            if self.program.poll() is not None:
                raise SystemExit(f"the program ended with {self.program.returncode} before it had a window")
            time.sleep(0.05)
        self.window = found[-1]
        self.xdotool("windowmove", self.window, "0", "0", "windowsize", self.window, *self.size, "windowfocus", self.window)
        return self.program

    def xdotool(self, *arguments, check=True):
        done = subprocess.run(["xdotool", *arguments], env=self.environment, capture_output=True, text=True)
        if check and done.returncode != 0 and self.program.poll() is None:
            raise SystemExit(f"xdotool {arguments}: {done.stderr}")
        return done.stdout

    def key(self, *keys):
        self.xdotool("key", "--delay", "30", *keys)

    def click(self, x, y, button=1):
        self.xdotool("mousemove", str(x), str(y), "click", str(button))

    def drag(self, start, end, button=1, steps=12):
        """Drags along a line, in a fifth of a second."""
        motion = ["mousemove", *map(str, start), "mousedown", str(button)]
        for step in range(1, steps + 1):
            x, y = (a + (b - a) * step // steps for a, b in zip(start, end))
            motion += ["sleep", "0.016", "mousemove", str(x), str(y)]
        self.xdotool(*motion, "mouseup", str(button))

    def title(self):
        return self.xdotool("getwindowname", self.window, check=False).strip()

    def picture(self):
        """Hash of the pixels of the display."""
        return hashlib.sha1(self.buffer.read_bytes()[XWD_HEADER:]).hexdigest()

    def stop(self):
        for process in (self.program, self.server):
            if process and process.poll() is None:
                process.terminate()
                process.wait()
