"""Renders the scenes of cycles_scenes.json, closed rooms of scenes/benchmarks, with Cycles on the CPU, timed.

  blender -b --factory-startup --python render_cycles.py -- OUT.exr SCENE --spp 128 ...
  python render_cycles.py OUT.exr SCENE --spp 16 --oidn ...      (with the bpy module)

Prints one JSON line with the wall time of bpy.ops.render.render() alone (scene
sync, BVH build, sampling, denoising; not Blender's start, not file writing).
Analytic spheres become smooth-shaded meshes; y up becomes z up: (x, y, z) -> (x, -z, y).
"""
import argparse
import json
import math
import os
import resource
import sys
import time

import bpy
from mathutils import Matrix, Vector

HERE = os.path.dirname(os.path.abspath(__file__))


def zup(p):
    return Vector((p[0], -p[2], p[1]))


def nodes_of(m):
    m.use_nodes = True
    m.node_tree.nodes.clear()
    return m.node_tree.nodes, m.node_tree.links


def surface(name, kind, **inputs):
    """Material with a single shader node."""
    m = bpy.data.materials.new(name)
    nodes, links = nodes_of(m)
    out, shader = nodes.new("ShaderNodeOutputMaterial"), nodes.new(kind)
    links.new(shader.outputs[0], out.inputs["Surface"])
    for key, value in inputs.items():
        if key == "distribution":
            shader.distribution = value
        else:
            shader.inputs[key].default_value = value
    return m


def material(name, m):
    kind = m["type"]
    if kind == "diffuse":
        return surface(name, "ShaderNodeBsdfDiffuse", Color=(*m["albedo"], 1), Roughness=0.0)
    if kind == "ggx_metal":  # Cycles squares Roughness to get alpha
        return surface(name, "ShaderNodeBsdfGlossy", Color=(*m["reflectance"], 1), Roughness=m["roughness"], distribution="GGX")
    if kind == "mirror":
        return surface(name, "ShaderNodeBsdfGlossy", Color=(*m["reflectance"], 1), Roughness=0.0, distribution="GGX")
    if kind == "glass":
        return surface(name, "ShaderNodeBsdfGlass", Color=(1, 1, 1, 1), Roughness=0.0, IOR=m["ior"], distribution="GGX")
    raise ValueError(kind)


def emitter(name, radiance, one_sided):
    peak = max(radiance)
    m = surface(name, "ShaderNodeEmission", Color=(*[c / peak for c in radiance], 1), Strength=peak)
    if one_sided:  # strength 0 seen from behind
        nodes, links = m.node_tree.nodes, m.node_tree.links
        geo, scale = nodes.new("ShaderNodeNewGeometry"), nodes.new("ShaderNodeMath")
        scale.operation = "MULTIPLY_ADD"
        scale.inputs[1].default_value, scale.inputs[2].default_value = -peak, peak
        links.new(geo.outputs["Backfacing"], scale.inputs[0])
        links.new(scale.outputs[0], next(n for n in nodes if n.type == "EMISSION").inputs["Strength"])
    return m


def mesh(name, verts, faces, mat, smooth=False):
    me = bpy.data.meshes.new(name)
    me.from_pydata([tuple(v) for v in verts], [], faces)
    me.polygons.foreach_set("use_smooth", [smooth] * len(me.polygons))
    me.materials.append(mat)
    me.update()
    bpy.context.collection.objects.link(bpy.data.objects.new(name, me))


def sphere_mesh(c, r, nu, nv):
    verts = [zup(c) + Vector((0, 0, r))]
    for j in range(1, nv):
        t = math.pi * j / nv
        verts += [zup(c) + r * Vector((math.sin(t) * math.cos(2 * math.pi * i / nu), math.sin(t) * math.sin(2 * math.pi * i / nu), math.cos(t)))
                  for i in range(nu)]
    verts.append(zup(c) - Vector((0, 0, r)))
    last = len(verts) - 1
    faces = [(0, 1 + i, 1 + (i + 1) % nu) for i in range(nu)]
    for j in range(nv - 2):
        a, b = 1 + j * nu, 1 + (j + 1) * nu
        faces += [(a + i, b + i, b + (i + 1) % nu, a + (i + 1) % nu) for i in range(nu)]
    a = 1 + (nv - 2) * nu
    faces += [(a + i, last, a + (i + 1) % nu) for i in range(nu)]
    return verts, faces


def box_mesh(centre, half, turn=0.0):
    rot = Matrix.Rotation(math.radians(turn), 3, "Z")
    hx, hy, hz = half[0], half[2], half[1]
    verts = [zup(centre) + rot @ Vector((x * hx, y * hy, z * hz)) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    return verts, [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def add_point_light(name, position, intensity, radius):
    """Blender watts: a point light of energy W has intensity W/(4 pi) per steradian."""
    light = bpy.data.lights.new(name, "POINT")
    peak = max(intensity)
    light.energy, light.color, light.shadow_soft_size = 4 * math.pi * peak, [c / peak for c in intensity], radius
    ob = bpy.data.objects.new(name, light)
    ob.location = zup(position)
    bpy.context.collection.objects.link(ob)


def build(s, lamp_spheres):
    mats = {n: material(n, m) for n, m in s["materials"].items()}
    for o in s["objects"]:
        name, kind = o["name"], o["shape"]
        lit = "emission" in o
        if lit and kind == "sphere" and lamp_spheres:
            add_point_light(name, o["center"], [math.pi * o["radius"] ** 2 * c for c in o["emission"]], o["radius"])
            continue
        mat = emitter(name, o["emission"], kind == "rectangle") if lit else mats[o["material"]]
        if kind == "sphere":
            nu = 128 if lit else 512
            mesh(name, *sphere_mesh(o["center"], o["radius"], nu, nu // 2), mat, smooth=True)
        elif kind == "box":
            mesh(name, *box_mesh(o["center"], o["half_size"], o["rotate_y_deg"]), mat)
        elif kind == "room":
            lo, hi = o["min"], o["max"]
            mesh(name, *box_mesh([(a + b) / 2 for a, b in zip(lo, hi)], [(b - a) / 2 for a, b in zip(lo, hi)]), mat)
        else:
            c, u, v = ((o["point"], [500, 0, 0], [0, 0, -500]) if kind == "plane" else (o["center"], o["edge_u"], o["edge_v"]))
            corner = [zup([c[k] + a * u[k] + b * v[k] for k in range(3)]) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
            mesh(name, corner, [(0, 1, 2, 3)], mat)
    for k, p in enumerate(s["point_lights"]):
        add_point_light(f"point {k}", p["position"], p["intensity"], 0)

    world = bpy.data.worlds.new("sky")
    nodes, links = nodes_of(world)
    out, bg = nodes.new("ShaderNodeOutputWorld"), nodes.new("ShaderNodeBackground")
    bg.inputs["Color"].default_value, bg.inputs["Strength"].default_value = (*s["background"], 1), 1
    links.new(bg.outputs[0], out.inputs["Surface"])
    bpy.context.scene.world = world

    cam = s["camera"]
    data = bpy.data.cameras.new("camera")
    data.sensor_fit, data.angle = "VERTICAL", math.radians(cam["vfov_deg"])
    data.clip_start, data.clip_end = 1e-3, 1e4
    ob = bpy.data.objects.new("camera", data)
    back = (zup(cam["position"]) - zup(cam["target"])).normalized()
    right = zup(cam["up"]).cross(back).normalized()
    ob.matrix_world = Matrix.Translation(zup(cam["position"])) @ Matrix((right, back.cross(right), back)).transposed().to_4x4()
    bpy.context.collection.objects.link(ob)
    bpy.context.scene.camera = ob


def settings(s, a):
    sc = bpy.context.scene
    sc.render.engine = "CYCLES"
    sc.render.resolution_x, sc.render.resolution_y, sc.render.resolution_percentage = a.size[0], a.size[1], 100
    sc.render.film_transparent = False
    sc.render.use_compositing = sc.render.use_sequencer = False
    if a.threads:
        sc.render.threads_mode, sc.render.threads = "FIXED", a.threads
    c = sc.cycles
    c.device, c.feature_set = "CPU", "SUPPORTED"
    c.samples, c.seed, c.use_adaptive_sampling = a.spp, a.seed, False
    c.pixel_filter_type = "BOX"
    c.max_bounces = c.glossy_bounces = c.transmission_bounces = s["cycles_max_bounces"]
    c.diffuse_bounces = s["cycles_max_bounces"] if a.diffuse_bounces is None else a.diffuse_bounces
    c.transparent_max_bounces = 8
    c.sample_clamp_direct = c.sample_clamp_indirect = 0  # unbiased: no clamping,
    c.blur_glossy, c.light_sampling_threshold = 0, 0     # no glossy blurring, no light cut-off
    c.caustics_reflective = c.caustics_refractive = True
    if hasattr(c, "use_light_tree"):
        c.use_light_tree = not a.no_light_tree
    c.use_denoising = a.oidn
    if a.oidn:
        c.denoiser, c.denoising_input_passes = "OPENIMAGEDENOISE", "RGB_ALBEDO_NORMAL"
    i = sc.render.image_settings
    i.file_format, i.color_mode, i.color_depth, i.exr_codec = "OPEN_EXR", "RGB", "32", "ZIP"


def cpu_seconds():
    """User + system time of this process; cpu/wall near the core count shows the machine was ours."""
    u = resource.getrusage(resource.RUSAGE_SELF)
    return u.ru_utime + u.ru_stime


def main():
    argv = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    ap = argparse.ArgumentParser()
    ap.add_argument("out")
    ap.add_argument("scene")
    ap.add_argument("--spp", type=int, default=128)
    ap.add_argument("--size", type=int, nargs=2, default=(1280, 720))
    ap.add_argument("--seed", type=int, default=0)
    ap.add_argument("--threads", type=int, default=0)
    ap.add_argument("--diffuse-bounces", type=int, help="default: as the scene says")
    ap.add_argument("--oidn", action="store_true")
    ap.add_argument("--no-light-tree", action="store_true", help="Blender 3.5 and later; 3.4 has none")
    ap.add_argument("--lamp-spheres", action="store_true",
                    help="emissive spheres become Cycles point lights with a radius (not camera-visible) instead of meshes")
    a = ap.parse_args(argv)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    with open(os.path.join(HERE, "cycles_scenes.json")) as f:
        s = next(x for x in json.load(f)["scenes"] if x["name"] == a.scene)
    build(s, a.lamp_spheres)
    settings(s, a)
    t0, c0 = time.perf_counter(), cpu_seconds()
    bpy.ops.render.render()
    seconds, cpu = time.perf_counter() - t0, cpu_seconds() - c0
    bpy.data.images["Render Result"].save_render(os.path.abspath(a.out))
    print("RESULT " + json.dumps({"renderer": "cycles " + bpy.app.version_string, "scene": a.scene, "spp": a.spp, "size": list(a.size),
                                  "oidn": a.oidn, "diffuse_bounces": bpy.context.scene.cycles.diffuse_bounces,
                                  "max_bounces": s["cycles_max_bounces"], "lamp_spheres": a.lamp_spheres,
                                  "light_tree": getattr(bpy.context.scene.cycles, "use_light_tree", False),
                                  "seed": a.seed, "seconds": round(seconds, 3), "cpu_seconds": round(cpu, 3)}), flush=True)


main()
