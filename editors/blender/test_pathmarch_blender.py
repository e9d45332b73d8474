# SPDX-License-Identifier: MIT OR Apache-2.0
"""Tests of the add-on, inside Blender: `blender -b --factory-startup --python-exit-code 1 --python THIS -- PROGRAM`.

`scripts/test_blender.sh` runs them in Blender, and in the module `bpy` of PyPI.
"""

import math
import os
import subprocess
import sys
import tempfile
import unittest

import bpy
from mathutils import Vector

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import pathmarch_blender as addon  # noqa: E402

PROGRAM = os.path.abspath(sys.argv[-1])

SCENE = """pathmarch 1
camera "near" { position 1.5 1 3; target 0 0.4 0; fov 35 }
camera "above" { position 0 5 0; target 0 0 0; up 0 0 -1; fov 30 }
render { size 160 90; samples 16; bounces 3 }
sky 0.6 0.7 0.9
sun { direction -1 2 1; irradiance 3 3 3; angle 4 }
material "red" { diffuse 0.7 0.1 0.1 }
object "block" material="red" { box 0.6 0.8 1 { at 0.5 0.4 0 } }
object "ball" { sphere 0.4 { at -0.5 0.4 0.2 } }
object "floor" { plane }
"""


class AddonTest(unittest.TestCase):
    def setUp(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        addon.register()
        self.addCleanup(addon.unregister)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.path = os.path.join(self.folder, "scene with spaces.kdl")
        self.write(SCENE)
        # An add-on that was not installed has no preferences: the program is found on the path.
        os.environ["PATH"] = os.path.dirname(PROGRAM) + os.pathsep + os.environ["PATH"]

    def write(self, text):
        with open(self.path, "w", encoding="utf-8") as file:
            file.write(text)

    def open_scene(self, **options):
        self.assertEqual(bpy.ops.import_scene.pathmarch(filepath=self.path, resolution=32, **options), {"FINISHED"})
        scene = bpy.context.scene
        scene.render.resolution_x, scene.render.resolution_y = 160, 90
        scene.pathmarch.samples = 16
        scene.pathmarch.backend = "CPU"
        return scene

    def rendered(self, name="blender.exr"):
        """File of the picture that Blender shows."""
        bpy.ops.render.render()
        path = os.path.join(self.folder, name)
        image = bpy.context.scene.render.image_settings
        image.file_format, image.color_depth = "OPEN_EXR", "32"
        bpy.data.images["Render Result"].save_render(path)
        return path

    def expected(self, *options):
        """File of the picture of the program alone."""
        path = os.path.join(self.folder, "expected.exr")
        command = [PROGRAM, "render", self.path, "--backend", "cpu", "--samples", "16", *options, "-o", path]
        subprocess.run(command, check=True, capture_output=True)
        return path

    def assert_same(self, a, b, limit=1e-3):
        command = [PROGRAM, "compare", a, b, "--max-relmse", str(limit)]
        result = subprocess.run(command, capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)

    def assert_fails(self, words, action):
        with self.assertRaises(RuntimeError) as caught:
            action()
        for word in words:
            self.assertIn(word, str(caught.exception))

    def test_a_scene_is_opened_with_z_up(self):
        scene = self.open_scene()
        self.assertEqual(scene.render.engine, "PATHMARCH")
        things = list(scene.pathmarch.collection.objects)
        mesh = next(thing for thing in things if thing.type == "MESH")
        corners = [mesh.matrix_world @ vertex.co for vertex in mesh.data.vertices]
        for axis, (low, high) in enumerate([(-0.9, 0.8), (-0.6, 0.5), (0.0, 0.8)]):
            self.assertAlmostEqual(min(corner[axis] for corner in corners), low, delta=0.02)
            self.assertAlmostEqual(max(corner[axis] for corner in corners), high, delta=0.02)
        self.assertEqual(len(mesh.data.color_attributes), 1)
        cameras = {thing[addon.CAMERA_MARK]: thing for thing in things if thing.type == "CAMERA"}
        self.assertEqual(set(cameras), {"near", "above"})
        self.assertIs(scene.camera, cameras["near"])
        position = cameras["near"].matrix_world.translation
        self.assertLess((position - Vector((1.5, -3, 1))).length, 1e-5)
        self.assertAlmostEqual(math.degrees(cameras["near"].data.angle_y), 35, delta=1e-3)

    def test_the_view_of_blender_is_that_of_the_program(self):
        scene = self.open_scene()
        self.assert_same(self.rendered(), self.expected())
        scene.camera = next(thing for thing in scene.objects if thing.get(addon.CAMERA_MARK) == "above")
        self.assert_same(self.rendered(), self.expected("--camera", "above"))
        scene.pathmarch.view, scene.pathmarch.camera = "FILE", "near"
        scene.pathmarch.seed = 5
        self.assert_same(self.rendered(), self.expected("--seed", "5"), limit=1e-12)
        scene.render.resolution_percentage = 50
        scene.pathmarch.samples = 0
        self.assert_same(self.rendered(), self.expected("--seed", "5", "--size", "80x45"), limit=1e-12)

    def test_a_lens_is_passed_on(self):
        scene = self.open_scene()
        dof = scene.camera.data.dof
        dof.use_dof, dof.focus_distance, dof.aperture_fstop = True, 3.0, 0.5
        node, remarks = addon.camera_node("c", scene.camera, bpy.context.evaluated_depsgraph_get(), 160, 90)
        radius = scene.camera.data.lens / 1000 / 1.0
        self.assertIn(f"lens radius={radius:.9f} focus=3.000000000", node)
        self.assertEqual(remarks, [])
        scene.camera.data.shift_x = 0.1
        _, remarks = addon.camera_node("c", scene.camera, bpy.context.evaluated_depsgraph_get(), 160, 90)
        self.assertEqual(len(remarks), 1)

    def test_frames_have_their_time(self):
        self.write(SCENE.replace("at -0.5 0.4 0.2", 'at "t-0.5" 0.4 0.2'))
        scene = self.open_scene()
        scene.pathmarch.view = "FILE"
        scene.frame_set(13)
        self.assertEqual((scene.frame_start, scene.render.fps), (1, 24))
        self.assert_same(self.rendered(), self.expected("--time", "0.5"), limit=1e-12)

    def test_a_changed_file_is_reloaded_and_cameras_stay(self):
        scene = self.open_scene()
        scene.camera.location.x = 9
        self.write(SCENE.replace("at 0.5 0.4 0", "at 2.5 0.4 0").replace('"above"', '"other"'))
        self.assertEqual(bpy.ops.scene.pathmarch_reload(), {"FINISHED"})
        things = list(scene.pathmarch.collection.objects)
        meshes = [thing for thing in things if thing.type == "MESH"]
        self.assertEqual(len(meshes), 1)
        self.assertAlmostEqual(max(vertex.co.x for vertex in meshes[0].data.vertices), 2.8, delta=0.02)
        names = sorted(thing[addon.CAMERA_MARK] for thing in things if thing.type == "CAMERA")
        self.assertEqual(names, ["above", "near", "other"])
        self.assertEqual(scene.camera.location.x, 9)

    def test_infinite_objects_are_clipped(self):
        scene = self.open_scene(clip=2.0)
        mesh = next(thing for thing in scene.objects if thing.type == "MESH")
        self.assertAlmostEqual(max(vertex.co.x for vertex in mesh.data.vertices), 2, delta=0.01)

    def test_failures_say_why(self):
        scene = self.open_scene()
        scene.camera.data.type = "ORTHO"
        self.assert_fails(["not perspective"], bpy.ops.render.render)
        scene.pathmarch.view, scene.pathmarch.camera = "FILE", "nera"
        self.assert_fails(["nera", "near"], bpy.ops.render.render)
        self.write(SCENE.replace("sphere 0.4", "spere 0.4"))
        self.assert_fails(["spere", "Did you mean `sphere`?"], bpy.ops.render.render)
        self.assert_fails(["spere"], bpy.ops.scene.pathmarch_reload)
        os.remove(self.path)
        self.assert_fails(["there is no such file"], bpy.ops.render.render)
        self.assert_fails(["no such file"], lambda: bpy.ops.import_scene.pathmarch(filepath=self.path))
        os.environ["PATH"] = self.folder
        self.write(SCENE)
        self.assert_fails(["Install pathmarch"], bpy.ops.scene.pathmarch_reload)

    def test_a_cancelled_program_is_stopped(self):
        command = [PROGRAM, "render", "-", "--samples", "100000", "--json", "-o", os.path.join(self.folder, "a.exr")]
        lines = []
        self.assertIsNone(addon.run(command, self.folder, SCENE, lambda: len(lines) > 2, lines.append))
        self.assertNotIn("a.exr", os.listdir(self.folder))


if __name__ == "__main__":
    names = sys.argv[sys.argv.index("--") + 1 : -1] if "--" in sys.argv else []
    suite = unittest.defaultTestLoader.loadTestsFromTestCase(AddonTest)
    if names:
        suite = unittest.TestSuite(AddonTest(name) for name in names)
    result = unittest.TextTestRunner(stream=sys.stdout, verbosity=2).run(suite)
    sys.exit(not result.wasSuccessful())
