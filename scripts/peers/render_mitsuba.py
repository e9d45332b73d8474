"""Renders a scene that `pathmarch-measure` wrote as JSON with Mitsuba 3 (LLVM), timed.

  python render_mitsuba.py SCENE.json DIRECTORY --size 640 360 --samples 64 --seeds 1 2 3

Writes DIRECTORY/mitsuba-SEED.exr for each seed and prints a line of JSON for it: samples, and the seconds of a render with its
kernel compiled; the scene and its BVH are built before. The kernel is compiled by a picture that is not timed. Needs
LLVM 16 or newer on recent processors: Debian's libllvm19, or another by DRJIT_LIBLLVM_PATH.
"""
import argparse
import glob
import json
import os
import re
import time

if "DRJIT_LIBLLVM_PATH" not in os.environ:
    version = lambda path: float((re.findall(r"\d+(?:\.\d+)?", os.path.basename(path)) or ["0"])[0])
    found = [path for path in glob.glob("/usr/lib/*/libLLVM*.so*") if version(path) >= 16]
    if found:
        os.environ["DRJIT_LIBLLVM_PATH"] = max(found, key=version)

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb")

# Samples of a pass, so that the states of its paths fit into memory.
MOST = 32_000_000


def rgb(value):
    return {"type": "rgb", "value": [float(channel) for channel in value]}


def bsdf(material):
    kind = material["kind"]
    if kind == "diffuse":
        return {"type": "twosided", "inner": {"type": "diffuse", "reflectance": rgb(material["colour"])}}
    if kind == "metal":
        colour, roughness = material["colour"], material["roughness"]
        if material["edge"] == [1, 1, 1] and colour != [1, 1, 1]:
            # Its metal is GGX with Schlick's approximation, with 1 at grazing incidence.
            return {"type": "principled", "base_color": rgb(colour), "metallic": 1.0, "roughness": roughness}
        if material["edge"] not in (colour, [1, 1, 1]):
            raise SystemExit(f"the edge colour of {material['name']} has no counterpart")
        if roughness == 0:
            return {"type": "conductor", "material": "none", "specular_reflectance": rgb(colour)}
        return {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": roughness ** 2,
                "specular_reflectance": rgb(colour)}
    if kind == "glass":
        return {"type": "dielectric", "int_ior": material["ior"], "ext_ior": 1.0, "specular_transmittance": rgb(material["colour"])}
    return {"type": "diffuse", "reflectance": rgb([0, 0, 0])}


def radiance(material):
    value = material["radiance"] if material["kind"] == "emit" else material.get("emission", [0])
    return value if max(value) > 0 else None


def mesh(part, directory, transform, material):
    """A mesh of arrays, in the space of the world."""
    read = lambda name, kind: np.fromfile(os.path.join(directory, part[name]), dtype=kind)
    matrix = np.array(part["matrix"])
    positions = read("positions", "<f4").reshape(-1, 3) @ matrix[:3, :3].T + matrix[:3, 3]
    triangles = read("triangles", "<u4")
    properties = mi.Properties()
    properties["mesh_bsdf"] = mi.load_dict(material["bsdf"])
    if "emitter" in material:
        properties["mesh_emitter"] = mi.load_dict(material["emitter"])
    properties["face_normals"] = "normals" not in part and "colours" not in part
    made = mi.Mesh(part["object"], len(positions), len(triangles) // 3, has_vertex_normals="normals" in part or "colours" in part, props=properties)
    parameters = mi.traverse(made)
    parameters["vertex_positions"] = positions.astype("f4").ravel()
    parameters["faces"] = triangles
    if "normals" in part:
        normals = read("normals", "<f4").reshape(-1, 3) @ np.linalg.inv(matrix[:3, :3])
        parameters["vertex_normals"] = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype("f4").ravel()
    parameters.update()
    if "colours" in part:
        made.recompute_vertex_normals()
    return made


def prism(part, transform, material):
    side, length = part["params"]
    radius = side / np.sqrt(3)
    corners = [(radius * np.sin(turn), radius * np.cos(turn)) for turn in 2 * np.pi / 3 * np.arange(3)]
    positions = np.array([(x, y, z) for z in (-length / 2, length / 2) for x, y in corners])
    faces = [(0, 1, 2), (5, 4, 3), (0, 3, 4), (0, 4, 1), (1, 4, 5), (1, 5, 2), (2, 5, 3), (2, 3, 0)]
    properties = mi.Properties()
    properties["mesh_bsdf"] = mi.load_dict(material["bsdf"])
    properties["face_normals"] = True
    properties["flip_normals"] = part["inside_out"]
    made = mi.Mesh(part["object"], 6, 8, props=properties)
    matrix = np.array(part["matrix"])
    parameters = mi.traverse(made)
    parameters["vertex_positions"] = (positions @ matrix[:3, :3].T + matrix[:3, 3]).astype("f4").ravel()
    parameters["faces"] = np.array(faces, "u4").ravel()
    parameters.update()
    return made


def shape(part, materials, directory):
    transform = mi.ScalarTransform4f(part["matrix"])
    described = materials[part["material"]]
    material = {"bsdf": bsdf(described)}
    if radiance(described):
        material["emitter"] = {"type": "area", "radiance": rgb(radiance(described))}
    kind = part["shape"]
    if kind == "mesh":
        return mesh(part, directory, transform, material)
    if kind == "prism":
        return prism(part, transform, material)
    if kind == "sphere":
        made = {"type": "sphere", "to_world": transform @ mi.ScalarTransform4f().scale(part["params"][0])}
    elif kind == "box":
        made = {"type": "cube", "to_world": transform @ mi.ScalarTransform4f().scale([edge / 2 for edge in part["params"]])}
    else:
        x, z = part["params"] if kind == "rect" else (1000, 1000)
        flat = mi.ScalarTransform4f().rotate([1, 0, 0], -90).scale([x / 2, z / 2, 1])
        made = {"type": "rectangle", "to_world": transform @ flat}
    if part["inside_out"]:
        made["flip_normals"] = True
    return {**made, **material}


def build(scene, directory, size, passes):
    camera = scene["camera"]
    described = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": scene["bounces"] + 2, **({"samples_per_pass": passes} if passes else {})},
        "sensor": {
            "type": "perspective", "fov": camera["fov"], "fov_axis": "y", "near_clip": 1e-3, "far_clip": 1e4,
            "to_world": mi.ScalarTransform4f().look_at(camera["position"], camera["target"], camera["up"]),
            "film": {"type": "hdrfilm", "width": size[0], "height": size[1], "pixel_format": "rgb",
                     "component_format": "float32", "rfilter": {"type": "box"}},
            "sampler": {"type": "independent"},
        },
    }
    for index, part in enumerate(scene["parts"]):
        described[f"part_{index}"] = shape(part, scene["materials"], directory)
    for index, point in enumerate(scene["points"]):
        described[f"point_{index}"] = {"type": "point", "position": point["position"], "intensity": rgb(point["intensity"])}
    if any(scene["sky"]):
        described["sky"] = {"type": "constant", "radiance": rgb(scene["sky"])}
    try:
        return mi.load_dict(described)
    except RuntimeError:
        # It joins meshes of one material, and fails where one of them is inside out.
        return mi.load_dict(described, optimize=False)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("scene")
    parser.add_argument("directory")
    parser.add_argument("--size", type=int, nargs=2, default=(640, 360))
    parser.add_argument("--samples", type=int, default=64)
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    arguments = parser.parse_args()
    with open(arguments.scene) as file:
        scene = json.load(file)
    passes = arguments.samples
    while passes * arguments.size[0] * arguments.size[1] > MOST and passes % 2 == 0:
        passes //= 2
    is_split = passes < arguments.samples
    built = build(scene, os.path.dirname(os.path.abspath(arguments.scene)), arguments.size, passes if is_split else None)
    os.makedirs(arguments.directory, exist_ok=True)
    np.array(mi.render(built, spp=passes, seed=0))
    for seed in arguments.seeds:
        began = time.perf_counter()
        picture = np.array(mi.render(built, spp=arguments.samples, seed=seed))
        seconds = time.perf_counter() - began
        path = os.path.join(os.path.abspath(arguments.directory), f"mitsuba-{seed}.exr")
        mi.Bitmap(picture[:, :, :3]).write(path)
        print("RESULT " + json.dumps({"samples": arguments.samples, "seconds": seconds, "picture": path}), flush=True)


main()
