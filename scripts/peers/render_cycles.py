"""Renders a scene that `pathmarch-measure` wrote as JSON with Cycles on the CPU, timed.

  python render_cycles.py SCENE.json DIRECTORY --size 640 360 --samples 1 2 4 128      (with PyPI's bpy)
  blender -b --factory-startup --python render_cycles.py -- SCENE.json DIRECTORY ...

Writes DIRECTORY/SAMPLES.exr for each sample count and prints a line of JSON for it: samples, the seconds of
bpy.ops.render.render() alone (scene, BVH, sampling and denoising, without Blender's start and the writing of files), and
the megabytes by which the first render raised the resident memory at most (null where Linux does not report them).
Closed-form solids become meshes, round ones with smooth normals. y up becomes z up: (x, y, z) -> (x, -z, y).
"""
import argparse
import json
import math
import os
import sys
import time

import bpy
import numpy as np
from mathutils import Matrix, Vector

Z_UP = Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))
SPHERE_SEGMENTS = 512
# Each triangle that emits is a light to choose from.
EMITTING_SPHERE_SEGMENTS = 64


def nodes_of(owner):
    owner.use_nodes = True
    owner.node_tree.nodes.clear()
    return owner.node_tree.nodes, owner.node_tree.links


def emission(made, radiance):
    """Emission on the front of a surface only."""
    nodes, links = made.node_tree.nodes, made.node_tree.links
    peak = max(radiance)
    shader = nodes.new("ShaderNodeEmission")
    shader.inputs["Color"].default_value = (*[channel / peak for channel in radiance], 1)
    strength = nodes.new("ShaderNodeMath")
    strength.operation, strength.inputs[0].default_value = "MULTIPLY_ADD", -peak
    strength.inputs[2].default_value = peak
    links.new(nodes.new("ShaderNodeNewGeometry").outputs["Backfacing"], strength.inputs[1])
    links.new(strength.outputs[0], shader.inputs["Strength"])
    if hasattr(made.cycles, "emission_sampling"):
        made.cycles.emission_sampling = "FRONT"
    return shader


def material(described):
    """Material with one shader; linear colours."""
    made = bpy.data.materials.new(described["name"])
    nodes, links = nodes_of(made)
    kind = described["kind"]
    if kind == "diffuse":
        shader = nodes.new("ShaderNodeBsdfDiffuse")
        shader.inputs["Color"].default_value = (*described["colour"], 1)
        shader.inputs["Roughness"].default_value = 0
        if described.get("vertex_colours"):
            colours = nodes.new("ShaderNodeVertexColor")
            colours.layer_name = "colour"
            links.new(colours.outputs["Color"], shader.inputs["Color"])
    elif kind == "metal" and described["edge"] == [1, 1, 1] and hasattr(bpy.types, "ShaderNodeBsdfMetallic"):
        # The F82 model with a white tint is Schlick's, with 1 at grazing incidence.
        shader = nodes.new("ShaderNodeBsdfMetallic")
        shader.fresnel_type, shader.distribution = "F82", "GGX"
        shader.inputs["Base Color"].default_value = (*described["colour"], 1)
        shader.inputs["Edge Tint"].default_value = (1, 1, 1, 1)
        shader.inputs["Roughness"].default_value = described["roughness"]
    elif kind == "metal":
        shader = nodes.new("ShaderNodeBsdfAnisotropic" if hasattr(bpy.types, "ShaderNodeBsdfAnisotropic") else "ShaderNodeBsdfGlossy")
        shader.distribution = "GGX"
        shader.inputs["Color"].default_value = (*described["colour"], 1)
        shader.inputs["Roughness"].default_value = described["roughness"]
    elif kind == "glass":
        shader = nodes.new("ShaderNodeBsdfGlass")
        shader.distribution = "GGX"
        shader.inputs["Color"].default_value = (*described["colour"], 1)
        shader.inputs["Roughness"].default_value = 0
        shader.inputs["IOR"].default_value = described["ior"]
    else:
        shader = emission(made, described["radiance"])
    if max(described.get("emission", [0])) > 0:
        both = nodes.new("ShaderNodeAddShader")
        links.new(shader.outputs[0], both.inputs[0])
        links.new(emission(made, described["emission"]).outputs[0], both.inputs[1])
        shader = both
    links.new(shader.outputs[0], nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return made


def sphere(radius, columns=SPHERE_SEGMENTS):
    rows = columns // 2
    vertices = [(0, radius, 0)]
    for row in range(1, rows):
        polar = math.pi * row / rows
        for column in range(columns):
            turn = 2 * math.pi * column / columns
            vertices.append((radius * math.sin(polar) * math.cos(turn), radius * math.cos(polar), radius * math.sin(polar) * math.sin(turn)))
    vertices.append((0, -radius, 0))
    last = len(vertices) - 1
    faces = [(0, 1 + (k + 1) % columns, 1 + k) for k in range(columns)]
    for row in range(rows - 2):
        a, b = 1 + row * columns, 1 + (row + 1) * columns
        faces += [(a + k, a + (k + 1) % columns, b + (k + 1) % columns, b + k) for k in range(columns)]
    a = 1 + (rows - 2) * columns
    faces += [(a + k, a + (k + 1) % columns, last) for k in range(columns)]
    return vertices, faces


def box(x, y, z):
    vertices = [(sx * x / 2, sy * y / 2, sz * z / 2) for sz in (-1, 1) for sy in (-1, 1) for sx in (-1, 1)]
    return vertices, [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def prism(side, length):
    """Equilateral section of this side, along z, with a corner up and the centroid at the origin."""
    circumradius = side / math.sqrt(3)
    corners = [(circumradius * math.sin(turn), circumradius * math.cos(turn)) for turn in (0, 2 * math.pi / 3, 4 * math.pi / 3)]
    vertices = [(x, y, z) for z in (-length / 2, length / 2) for x, y in corners]
    return vertices, [(0, 1, 2), (5, 4, 3), (0, 3, 4, 1), (1, 4, 5, 2), (2, 5, 3, 0)]


def rect(x, z):
    return [(-x / 2, 0, -z / 2), (x / 2, 0, -z / 2), (x / 2, 0, z / 2), (-x / 2, 0, z / 2)], [(3, 2, 1, 0)]


def plane():
    """Infinite elsewhere."""
    return rect(1000, 1000)


SHAPES = {"sphere": sphere, "box": box, "prism": prism, "rect": rect, "plane": plane}


def add_part(part, materials, directory, emits=False):
    data = bpy.data.meshes.new(part["object"])
    if part["shape"] == "mesh":
        read = lambda name, kind: np.fromfile(os.path.join(directory, part[name]), dtype=kind)
        positions, triangles = read("positions", "<f4"), read("triangles", "<u4")
        data.vertices.add(len(positions) // 3)
        data.vertices.foreach_set("co", positions)
        data.loops.add(len(triangles))
        data.loops.foreach_set("vertex_index", triangles.astype("i4"))
        data.polygons.add(len(triangles) // 3)
        data.polygons.foreach_set("loop_start", np.arange(0, len(triangles), 3, dtype="i4"))
        if "colours" in part:
            colours = read("colours", "<f4").reshape(-1, 3)
            layer = data.color_attributes.new("colour", "FLOAT_COLOR", "POINT")
            layer.data.foreach_set("color", np.concatenate([colours, np.ones((len(colours), 1), "f4")], axis=1).ravel())
        data.update(calc_edges=True)
        data.validate()
        if "normals" in part:
            data.normals_split_custom_set_from_vertices(read("normals", "<f4").reshape(-1, 3))
    else:
        coarser = [EMITTING_SPHERE_SEGMENTS] if part["shape"] == "sphere" and emits else []
        vertices, faces = SHAPES[part["shape"]](*part["params"], *coarser)
        data.from_pydata(vertices, [], [tuple(reversed(face)) for face in faces] if part["inside_out"] else faces)
    # Meshes made of fields have colours, and are as smooth as the field; others without normals are facetted.
    is_smooth = part["shape"] == "sphere" or "colours" in part or "normals" in part
    data.polygons.foreach_set("use_smooth", [is_smooth] * len(data.polygons))
    data.materials.append(materials[part["material"]])
    data.update()
    added = bpy.data.objects.new(part["object"], data)
    added.matrix_world = Z_UP @ Matrix(part["matrix"])
    bpy.context.collection.objects.link(added)


def is_lamp(part, material):
    """True for what Cycles has as a light with a size, which it samples better and faster than triangles that emit."""
    scale = Matrix(part["matrix"]).to_scale()
    is_uniform = max(scale) - min(scale) < 1e-5 * max(scale)
    return material["kind"] == "emit" and part["shape"] in ("sphere", "rect") and not part["inside_out"] and is_uniform


def add_lamp(part, radiance):
    """Sphere light or one-sided rectangle of this radiance."""
    peak, scale = max(radiance), Matrix(part["matrix"]).to_scale()[0]
    is_sphere = part["shape"] == "sphere"
    data = bpy.data.lights.new(part["object"], "POINT" if is_sphere else "AREA")
    matrix = Z_UP @ Matrix(part["matrix"])
    if is_sphere:
        data.shadow_soft_size = part["params"][0] * scale
        data.energy = 4 * math.pi**2 * data.shadow_soft_size**2 * peak
        if hasattr(data, "use_soft_falloff"):
            data.use_soft_falloff = False
    else:
        data.shape, (data.size, data.size_y) = "RECTANGLE", part["params"]
        data.energy = math.pi * data.size * data.size_y * scale**2 * peak
        # It emits along -z; our rectangles along y.
        matrix = matrix @ Matrix(((1, 0, 0, 0), (0, 0, -1, 0), (0, 1, 0, 0), (0, 0, 0, 1)))
    data.color = [channel / peak for channel in radiance]
    added = bpy.data.objects.new(part["object"], data)
    added.matrix_world = matrix
    # The camera does not see the lights of new scenes.
    added.visible_camera = True
    bpy.context.collection.objects.link(added)


def core(part):
    """Black body within a lamp: lights of Cycles let the light of others through."""
    matrix, params = Matrix(part["matrix"]), part["params"]
    if part["shape"] == "sphere":
        return {**part, "params": [0.998 * params[0]]}
    behind = Matrix.Translation((0, -1e-3 * min(params), 0))
    return {**part, "matrix": [list(row) for row in matrix @ behind]}


def add_point(position, intensity):
    """Light without size: a lamp of W watts has an intensity of W / 4 pi in each direction."""
    peak = max(intensity)
    data = bpy.data.lights.new("point", "POINT")
    data.energy, data.color, data.shadow_soft_size = 4 * math.pi * peak, [channel / peak for channel in intensity], 0
    added = bpy.data.objects.new("point", data)
    added.location = Z_UP @ Vector(position)
    bpy.context.collection.objects.link(added)


def build(scene, directory):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    black = {"name": "black", "kind": "diffuse", "colour": (0, 0, 0)}
    materials = [material(described) for described in [*scene["materials"], black]]
    for part in scene["parts"]:
        described = scene["materials"][part["material"]]
        if is_lamp(part, described):
            add_lamp(part, described["radiance"])
            add_part({**core(part), "material": len(materials) - 1}, materials, directory)
        else:
            add_part(part, materials, directory, emits=max(described.get("emission", [0])) > 0)
    for point in scene["points"]:
        add_point(point["position"], point["intensity"])
    world = bpy.data.worlds.new("sky")
    nodes, links = nodes_of(world)
    background = nodes.new("ShaderNodeBackground")
    background.inputs["Color"].default_value = (*scene["sky"], 1)
    links.new(background.outputs[0], nodes.new("ShaderNodeOutputWorld").inputs["Surface"])
    bpy.context.scene.world = world

    described = scene["camera"]
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "VERTICAL", math.radians(described["fov"])
    data.clip_start, data.clip_end = 1e-3, 1e4
    camera = bpy.data.objects.new("camera", data)
    position, target, up = (Z_UP @ Vector(described[key]) for key in ("position", "target", "up"))
    back = (position - target).normalized()
    right = up.cross(back).normalized()
    camera.matrix_world = Matrix.Translation(position) @ Matrix((right, back.cross(right), back)).transposed().to_4x4()
    bpy.context.collection.objects.link(camera)
    bpy.context.scene.camera = camera


def configure(bounces, size, threads, denoise):
    """Path tracing without bias: no clamping, no denoiser, no adaptive sampling, every caustic."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = *size, 100
    scene.render.use_compositing = scene.render.use_sequencer = False
    if threads:
        scene.render.threads_mode, scene.render.threads = "FIXED", threads
    cycles = scene.cycles
    cycles.device, cycles.feature_set = "CPU", "SUPPORTED"
    cycles.use_adaptive_sampling, cycles.pixel_filter_type = False, "BOX"
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = bounces
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0
    cycles.blur_glossy = cycles.light_sampling_threshold = 0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.use_denoising = denoise
    if denoise:
        cycles.denoiser, cycles.denoising_input_passes = "OPENIMAGEDENOISE", "RGB_ALBEDO_NORMAL"
    image = scene.render.image_settings
    image.file_format, image.color_mode, image.color_depth, image.exr_codec = "OPEN_EXR", "RGB", "32", "ZIP"


def resident(key):
    """VmRSS or VmHWM (the peak) of this process, MB; None where there is no /proc."""
    try:
        with open("/proc/self/status") as file:
            return next(int(line.split()[1]) / 1024 for line in file if line.startswith(key + ":"))
    except (OSError, StopIteration):
        return None


def first_render():
    """Renders once, which loads the kernels and is not timed. Returns by how many MB memory rose at most, or None."""
    try:
        with open("/proc/self/clear_refs", "w") as file:
            file.write("5")  # resets the peak
    except OSError:
        pass
    before = resident("VmRSS")
    bpy.ops.render.render()
    return None if before is None else resident("VmHWM") - before


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scene")
    parser.add_argument("directory")
    parser.add_argument("--size", type=int, nargs=2, default=(1280, 720))
    parser.add_argument("--samples", type=int, nargs="+", default=[128])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--oidn", action="store_true", help="denoise with Open Image Denoise")
    arguments = parser.parse_args(sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:])
    with open(arguments.scene) as file:
        scene = json.load(file)
    build(scene, os.path.dirname(os.path.abspath(arguments.scene)))
    configure(scene["bounces"], arguments.size, arguments.threads, arguments.oidn)
    os.makedirs(arguments.directory, exist_ok=True)
    cycles = bpy.context.scene.cycles
    cycles.samples, cycles.seed = 1, arguments.seed
    megabytes = first_render()
    for samples in arguments.samples:
        # Another seed each time, so that the pictures are independent.
        cycles.samples, cycles.seed = samples, arguments.seed + samples
        began = time.perf_counter()
        bpy.ops.render.render()
        seconds = time.perf_counter() - began
        path = os.path.join(os.path.abspath(arguments.directory), f"{samples}.exr")
        bpy.data.images["Render Result"].save_render(path)
        print("RESULT " + json.dumps({"samples": samples, "seconds": seconds, "megabytes": megabytes, "picture": path}), flush=True)


main()
