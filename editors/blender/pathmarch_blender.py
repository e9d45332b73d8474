# SPDX-License-Identifier: MIT OR Apache-2.0
"""Add-on of Blender that opens scenes of pathmarch and renders them with the program.

A scene is shown as a mesh of its objects with its cameras. The render engine "pathmarch" renders the scene file itself, not
the mesh: with Blender's camera, so that a view can be chosen here, or with a camera of the file. Blender's own objects,
materials and lights are not rendered.

pathmarch has y up and Blender z: (x, y, z) there is (x, -z, y) here.
"""

import json
import math
import os
import queue
import re
import shutil
import subprocess
import sys
import tempfile
import threading
from array import array

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty
from bpy_extras.io_utils import ImportHelper
from mathutils import Matrix, Quaternion

bl_info = {
    "name": "pathmarch",
    "description": "Opens scenes of signed distance fields and renders them with pathmarch",
    "author": "The pathmarch authors",
    "version": (0, 1, 0),
    "blender": (3, 4, 0),
    "location": "File > Import > pathmarch scene; Render properties",
    "category": "Render",
}

#: Samples of the picture that is shown while the whole one is rendered.
PREVIEW_SAMPLES = 1
#: Seconds between two looks at whether the user cancelled.
POLL_SECONDS = 0.1


class Failed(Exception):
    """Failure of the program, with the reason that it gave."""


# The program


def program(context):
    """Command of pathmarch: that of the preferences, or the one on the path.

    Raises `Failed` if there is none.
    """
    addon = context.preferences.addons.get(__name__)
    chosen = bpy.path.abspath(addon.preferences.program) if addon else "pathmarch"
    found = shutil.which(chosen)
    if found is None:
        raise Failed(
            f'There is no program "{chosen}". Install pathmarch, and give its path in Edit > Preferences > Add-ons > pathmarch.'
        )
    return found


def reason(text):
    """What the program reported, without its colours and the lines that only inform."""
    text = re.sub(r"\x1b\[[0-9;]*m", "", text)
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith("note:")]
    return "\n".join(lines[-40:]) or "The program ended without a reason."


def run(command, folder, text, is_cancelled, on_line=lambda line: None):
    """Runs the program in a folder with `text` on its standard input, and returns what it reported on standard error.

    Each line of its standard output goes to `on_line`. Returns `None` if the user cancelled. Raises `Failed`.
    """
    flags = {"creationflags": subprocess.CREATE_NO_WINDOW} if os.name == "nt" else {}
    process = subprocess.Popen(
        command,
        cwd=folder,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        errors="replace",
        env={**os.environ, "NO_COLOR": "1"},
        **flags,
    )
    lines, reported = queue.Queue(), []

    def feed():
        # A program that refuses its arguments closes its input early.
        try:
            process.stdin.write(text)
            process.stdin.close()
        except OSError:
            pass

    threads = [
        threading.Thread(target=feed, daemon=True),
        threading.Thread(target=lambda: [lines.put(line) for line in process.stdout], daemon=True),
        threading.Thread(target=lambda: reported.append(process.stderr.read()), daemon=True),
    ]
    for thread in threads:
        thread.start()
    try:
        while process.poll() is None:
            if is_cancelled():
                return None
            try:
                on_line(lines.get(timeout=POLL_SECONDS))
            except queue.Empty:
                pass
    finally:
        if process.poll() is None:
            process.kill()
        process.wait()
        for thread in threads:
            thread.join()
    if process.returncode != 0:
        raise Failed(reason("".join(reported)))
    return "".join(reported)


# Cameras


def number(value):
    return f"{value:.9f}"


def vector(v):
    """Vector of Blender as numbers of a scene file."""
    return " ".join(number(value) for value in (v[0], v[2], -v[1]))


def camera_node(name, camera, depsgraph, width, height):
    """Node of the scene language for a camera of Blender, and remarks on what the language lacks.

    Raises `Failed` for cameras that are not perspective.
    """
    data = camera.data
    if data.type != "PERSP":
        raise Failed(f'The camera "{camera.name}" is not perspective; pathmarch has perspective cameras only.')
    projection = camera.calc_matrix_camera(depsgraph, x=width, y=height)
    fov = math.degrees(2 * math.atan(1 / projection[1][1]))
    world = camera.matrix_world
    position, forward, up = world.translation, -world.col[2].xyz.normalized(), world.col[1].xyz.normalized()
    lens = ""
    if data.dof.use_dof:
        distance = data.dof.focus_distance
        if data.dof.focus_object:
            distance = (data.dof.focus_object.matrix_world.translation - position).dot(forward)
        # The lens is in millimetres.
        radius = data.lens / 1000 / (2 * data.dof.aperture_fstop)
        lens = f"; lens radius={number(radius)} focus={number(max(distance, 1e-3))}"
    node = (
        f'camera "{name}" {{ position {vector(position)}; target {vector(position + forward)}; up {vector(up)}; '
        f"fov {number(fov)}{lens} }}"
    )
    shifted = abs(projection[0][2]) > 1e-6 or abs(projection[1][2]) > 1e-6
    return node, ["The shift of the camera is left out."] if shifted else []


def unused_name(name, text):
    while f'"{name}"' in text:
        name += "'"
    return name


# Import

#: Rotation from y up to z up.
Z_UP = Matrix.Rotation(math.radians(90), 4, "X")
#: Custom property of an imported mesh: path of its scene file.
MESH_MARK = "pathmarch_scene"
#: Custom property of an imported camera: its name in the scene file.
CAMERA_MARK = "pathmarch_camera"


class ExportedScene:
    """What `pathmarch export` wrote to a `.glb` file: one mesh with normals and colours, and cameras.

    Blender's own reader of glTF needs NumPy in a version that not every system has beside it.
    """

    def __init__(self, path):
        with open(path, "rb") as file:
            content = file.read()
        length = int.from_bytes(content[12:16], "little")
        self.description = json.loads(content[20 : 20 + length])
        self.data = memoryview(content)[28 + length :]

    def _numbers(self, accessor, kind):
        view = self.description["bufferViews"][self.description["accessors"][accessor]["bufferView"]]
        numbers = array(kind)
        numbers.frombytes(self.data[view["byteOffset"] : view["byteOffset"] + view["byteLength"]])
        if sys.byteorder == "big":
            numbers.byteswap()
        return numbers

    def _vectors(self, accessor):
        """Vectors, turned to z up, one after another."""
        turned = self._numbers(accessor, "f")
        y = turned[1::3]
        turned[1::3] = array("f", (-z for z in turned[2::3]))
        turned[2::3] = y
        return turned

    def mesh(self, name):
        """New mesh of Blender."""
        part = self.description["meshes"][0]["primitives"][0]
        attributes = part["attributes"]
        positions, normals = self._vectors(attributes["POSITION"]), self._vectors(attributes["NORMAL"])
        corners = self._numbers(part["indices"], "I")
        mesh = bpy.data.meshes.new(name)
        mesh.vertices.add(len(positions) // 3)
        mesh.vertices.foreach_set("co", positions)
        mesh.loops.add(len(corners))
        mesh.loops.foreach_set("vertex_index", corners)
        mesh.polygons.add(len(corners) // 3)
        mesh.polygons.foreach_set("loop_start", range(0, len(corners), 3))
        if bpy.app.version < (3, 6):
            mesh.polygons.foreach_set("loop_total", [3] * (len(corners) // 3))
        mesh.polygons.foreach_set("use_smooth", [True] * (len(corners) // 3))
        mesh.update(calc_edges=True)
        if bpy.app.version < (4, 1):
            mesh.use_auto_smooth = True
        mesh.normals_split_custom_set_from_vertices(list(zip(normals[0::3], normals[1::3], normals[2::3])))
        colours = self._numbers(attributes["COLOR_0"], "f")
        rgba = array("f", [1.0]) * (len(colours) // 3 * 4)
        for channel in range(3):
            rgba[channel::4] = colours[channel::3]
        mesh.color_attributes.new("Colour", "FLOAT_COLOR", "POINT").data.foreach_set("color", rgba)
        mesh.materials.append(colour_material())
        return mesh

    def cameras(self):
        """Names, vertical fields of view in radians, and matrices."""
        for node in self.description["nodes"]:
            if "camera" in node:
                x, y, z, w = node["rotation"]
                place = Matrix.Translation(node["translation"]) @ Quaternion((w, x, y, z)).to_matrix().to_4x4()
                lens = self.description["cameras"][node["camera"]]["perspective"]
                yield node["name"], lens["yfov"], Z_UP @ place


def colour_material():
    """Material that shows the colours of the vertices in the viewport."""
    name = "pathmarch colours"
    material = bpy.data.materials.get(name)
    if material is None:
        material = bpy.data.materials.new(name)
        material.use_nodes = True
        nodes = material.node_tree.nodes
        shader = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
        attribute = nodes.new("ShaderNodeVertexColor")
        attribute.layer_name = "Colour"
        material.node_tree.links.new(attribute.outputs["Color"], shader.inputs["Base Color"])
    return material


def load(context, settings):
    """Replaces the mesh in the settings' collection by that of the scene file, and adds the cameras that are not there yet.

    Returns what the program reported. Raises `Failed`; nothing has changed then.
    """
    path = scene_file(settings)
    with tempfile.TemporaryDirectory(prefix="pathmarch-") as folder:
        exported = os.path.join(folder, "scene.glb")
        command = [program(context), "export", os.path.basename(path), "-o", exported]
        command += ["--resolution", str(settings.resolution)]
        if settings.clip > 0:
            far = number(settings.clip)
            command += ["--bounds", f"-{far} -{far} -{far} {far} {far} {far}"]
        else:
            command += ["--skip-infinite"]
        if settings.allow_files:
            command += ["--allow-files"]
        reported = run(command, os.path.dirname(path), "", lambda: False)
        exported = ExportedScene(exported)

    name = os.path.splitext(os.path.basename(path))[0]
    if settings.collection is None:
        settings.collection = bpy.data.collections.new(name)
        context.scene.collection.children.link(settings.collection)
    collection = settings.collection
    for old in [thing for thing in collection.objects if MESH_MARK in thing]:
        mesh = old.data
        bpy.data.objects.remove(old)
        if mesh.users == 0:
            bpy.data.meshes.remove(mesh)
    thing = bpy.data.objects.new(name, exported.mesh(name))
    thing[MESH_MARK] = path
    collection.objects.link(thing)
    known = {thing.get(CAMERA_MARK) for thing in collection.objects}
    added = []
    for camera_name, fov, matrix in exported.cameras():
        if camera_name in known:
            continue
        camera = bpy.data.cameras.new(camera_name)
        # The field of view of a scene is the vertical one, whatever the size of the picture.
        camera.sensor_fit = "VERTICAL"
        camera.angle_y = fov
        thing = bpy.data.objects.new(camera_name, camera)
        thing.matrix_world = matrix
        thing[CAMERA_MARK] = camera_name
        collection.objects.link(thing)
        added.append(thing)
    # A new collection has none of its cameras; after that, the user chooses.
    if added and known == {None}:
        context.scene.camera = added[0]
    return reported


def scene_file(settings):
    """Path of the scene file. Raises `Failed` if there is none."""
    path = bpy.path.abspath(settings.file)
    if not path:
        raise Failed("No scene file is chosen. Open one by File > Import > pathmarch scene.")
    if not os.path.isfile(path):
        raise Failed(f"{path}: there is no such file.")
    return os.path.normpath(path)


class PATHMARCH_OT_import(bpy.types.Operator, ImportHelper):
    """Open a scene of pathmarch: its objects as a mesh, its cameras, and pathmarch as the render engine"""

    bl_idname = "import_scene.pathmarch"
    bl_label = "Open pathmarch scene"
    bl_options = {"REGISTER", "UNDO"}

    filename_ext = ".kdl"
    filter_glob: StringProperty(default="*.kdl", options={"HIDDEN"})
    resolution: IntProperty(
        name="Resolution", description="Cells of the mesh along its longest side", default=128, min=1, soft_max=512
    )
    clip: FloatProperty(
        name="Clip",
        description="Half the side of a box to which objects are clipped; 0 leaves infinite objects out",
        default=0,
        min=0,
        unit="LENGTH",
    )

    def execute(self, context):
        settings = context.scene.pathmarch
        settings.file, settings.resolution, settings.clip = self.filepath, self.resolution, self.clip
        settings.collection = None
        try:
            reported = load(context, settings)
        except Failed as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        context.scene.render.engine = PathmarchEngine.bl_idname
        for line in reported.splitlines():
            if line.startswith("note:"):
                self.report({"INFO"}, line.removeprefix("note: "))
        return {"FINISHED"}


class PATHMARCH_OT_reload(bpy.types.Operator):
    """Read the scene file again and replace its mesh; cameras stay where they are"""

    bl_idname = "scene.pathmarch_reload"
    bl_label = "Reload"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return bool(context.scene.pathmarch.file)

    def execute(self, context):
        try:
            load(context, context.scene.pathmarch)
        except Failed as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


# Rendering


class PathmarchEngine(bpy.types.RenderEngine):
    """Render engine that runs pathmarch."""

    bl_idname = "PATHMARCH"
    bl_label = "pathmarch"
    bl_use_preview = False
    bl_use_eevee_viewport = True

    def render(self, depsgraph):
        try:
            self._render(depsgraph)
        except Failed as error:
            # The picture stays empty; Blender shows the reason in the status bar.
            self.error_set(str(error))
            self.report({"ERROR"}, str(error))

    def _render(self, depsgraph):
        scene = depsgraph.scene
        settings = scene.pathmarch
        path = scene_file(settings)
        share = scene.render.resolution_percentage / 100
        width, height = max(1, int(scene.render.resolution_x * share)), max(1, int(scene.render.resolution_y * share))
        with open(path, encoding="utf-8") as file:
            text = file.read()
        command = [program(bpy.context), "render", "-", "--size", f"{width}x{height}", "--json"]
        command += ["--backend", settings.backend.lower(), "--seed", str(settings.seed)]
        remarks = ["The render region is left out."] if scene.render.use_border else []
        if settings.view == "BLENDER":
            name = unused_name("Blender", text)
            camera = scene.camera.evaluated_get(depsgraph)
            node, more = camera_node(name, camera, depsgraph, width, height)
            text += f"\n{node}\n"
            remarks += more
            command += ["--camera", name]
        elif settings.camera:
            command += ["--camera", settings.camera]
        fps = scene.render.fps / scene.render.fps_base
        command += ["--time", number((scene.frame_current_final - scene.frame_start) / fps)]
        if settings.denoise:
            command += ["--denoise"]
        if settings.allow_files:
            command += ["--allow-files"]
        for remark in remarks:
            self.report({"WARNING"}, remark)

        with tempfile.TemporaryDirectory(prefix="pathmarch-") as folder:
            picture = os.path.join(folder, "picture.exr")
            command += ["-o", picture]
            passes = [PREVIEW_SAMPLES, settings.samples] if settings.samples > 8 * PREVIEW_SAMPLES else [settings.samples]
            for samples in passes:
                self.update_stats("", "pathmarch: starting")
                arguments = [*command, "--samples", str(samples)] if samples else command
                if run(arguments, os.path.dirname(path), text, self.test_break, self._show_progress) is None:
                    return
                result = self.begin_result(0, 0, width, height, layer=depsgraph.view_layer_eval.name)
                result.layers[0].load_from_file(picture)
                self.end_result(result)

    def _show_progress(self, line):
        try:
            event = json.loads(line)
        except ValueError:
            return
        if event.get("event") == "progress" and event.get("of"):
            self.update_progress(event["samples"] / event["of"])
            self.update_stats("", f"pathmarch: {event['samples']:.0f} of {event['of']} samples")


# Settings


class PathmarchSettings(bpy.types.PropertyGroup):
    """Settings of a Blender scene."""

    file: StringProperty(name="Scene file", description="File that is rendered", subtype="FILE_PATH")
    collection: PointerProperty(type=bpy.types.Collection)
    resolution: IntProperty(name="Mesh resolution", default=128, min=1, soft_max=512)
    clip: FloatProperty(name="Clip", default=0, min=0, unit="LENGTH")
    samples: IntProperty(
        name="Samples", description="Paths for each pixel; 0: as many as the file says", default=64, min=0, max=1_000_000
    )
    seed: IntProperty(name="Seed", description="Random seed", default=0, min=0)
    denoise: BoolProperty(name="Denoise", description="Filter the noise out of the picture", default=False)
    view: EnumProperty(
        name="Camera",
        items=[
            ("BLENDER", "Blender's", "The active camera of this Blender scene"),
            ("FILE", "The file's", "A camera of the scene file"),
        ],
    )
    camera: StringProperty(name="Name", description="Camera of the scene file; empty: its first")
    backend: EnumProperty(
        name="Device",
        items=[
            ("AUTO", "Automatic", "The GPU if there is one"),
            ("GPU", "GPU", "The GPU only"),
            ("CPU", "CPU", "The CPU only"),
        ],
    )
    allow_files: BoolProperty(
        name="Files elsewhere", description="Allow the scene to read files outside its folder", default=False
    )


class PathmarchPreferences(bpy.types.AddonPreferences):
    """Preferences of the add-on."""

    bl_idname = __name__

    program: StringProperty(
        name="Program", description="Path of pathmarch, or its name", default="pathmarch", subtype="FILE_PATH"
    )

    def draw(self, context):
        self.layout.prop(self, "program")
        try:
            program(context)
        except Failed as error:
            self.layout.label(text=str(error), icon="ERROR")


class PATHMARCH_PT_settings(bpy.types.Panel):
    """Panel of the settings, in the render properties."""

    bl_label = "pathmarch"
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"

    @classmethod
    def poll(cls, context):
        return context.engine == PathmarchEngine.bl_idname

    def draw(self, context):
        settings, layout = context.scene.pathmarch, self.layout
        layout.use_property_split = True
        row = layout.row(align=True)
        row.prop(settings, "file")
        row.operator(PATHMARCH_OT_reload.bl_idname, text="", icon="FILE_REFRESH")
        layout.prop(settings, "view", expand=True)
        if settings.view == "FILE":
            layout.prop(settings, "camera")
        for name in ("samples", "seed", "denoise", "backend", "allow_files"):
            layout.prop(settings, name)
        layout.prop(settings, "resolution")
        layout.prop(settings, "clip")


CLASSES = (
    PathmarchPreferences,
    PathmarchSettings,
    PATHMARCH_OT_import,
    PATHMARCH_OT_reload,
    PathmarchEngine,
    PATHMARCH_PT_settings,
)


def shared_panels():
    """Panels of Blender that every engine needs: size, frames, output, colour management, cameras."""
    prefixes = ("RENDER_PT_format", "RENDER_PT_frame", "RENDER_PT_output", "RENDER_PT_color", "DATA_PT_")
    for panel in bpy.types.Panel.__subclasses__():
        if "BLENDER_RENDER" in getattr(panel, "COMPAT_ENGINES", ()) and panel.__name__.startswith(prefixes):
            yield panel


def menu_entry(menu, context):
    menu.layout.operator(PATHMARCH_OT_import.bl_idname, text="pathmarch scene (.kdl)")


def register():
    for cls in CLASSES:
        bpy.utils.register_class(cls)
    bpy.types.Scene.pathmarch = PointerProperty(type=PathmarchSettings)
    bpy.types.TOPBAR_MT_file_import.append(menu_entry)
    for panel in shared_panels():
        panel.COMPAT_ENGINES.add(PathmarchEngine.bl_idname)


def unregister():
    for panel in shared_panels():
        panel.COMPAT_ENGINES.discard(PathmarchEngine.bl_idname)
    bpy.types.TOPBAR_MT_file_import.remove(menu_entry)
    del bpy.types.Scene.pathmarch
    for cls in reversed(CLASSES):
        bpy.utils.unregister_class(cls)


if __name__ == "__main__":
    register()
