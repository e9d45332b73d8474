#!/usr/bin/env python3
"""Compares pictures of a triangle mesh with Mitsuba 3: relMSE beyond the noise of both, and means.

Usage: scripts/mitsuba_meshes.py PATHMARCH [SAMPLES]    needs: pip install mitsuba numpy

Both render the cow `spot.obj` on a slab, with two seeds each. Half of the difference between seeds is the noise of a
picture, so that the difference between programs beyond the noise of both is systematic.
"""

import subprocess
import sys
import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np

mi.set_variant("llvm_ad_rgb", "scalar_rgb")
SIZE = (160, 120)
MODELS = Path(__file__).resolve().parent.parent / "crates/pathmarch-mesh/tests/data"
SPOT = MODELS / "spot.obj"
SKY = 'sky 0.5 0.6 0.8\nobject "lamp" material="lamp" { rect 1 1 { rotate 180 0 0; at 0 3 1 } }'
# Name: material of the scene, material of Mitsuba, lights, bounces.
CASES = {
    "diffuse": ("diffuse 0.7 0.5 0.3", {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.7, 0.5, 0.3]}}, SKY, 4),
    "rough metal": ("metal 1; roughness 0.5", {"type": "roughconductor", "material": "none", "alpha": 0.25, "distribution": "ggx"}, SKY, 4),
    "glass": ("glass 1; ior 1.5", {"type": "dielectric", "int_ior": 1.5, "ext_ior": 1.0}, "sky 0.5 0.6 0.8", 12),
    "textured": ('diffuse { picture "PICTURE" uv=#true }', "texture", SKY, 4),
    "environment": ("diffuse 0.7 0.5 0.3", {"type": "diffuse", "reflectance": {"type": "rgb", "value": [0.7, 0.5, 0.3]}}, 'sky "ENVIRONMENT"', 4),
}


def environment(path):
    """A map of a bright window and coloured bands, as EXR."""
    # Programs place texels differently at the poles, by half a row.
    height, width = 512, 1024
    v, u = np.mgrid[0:height, 0:width] / np.array([height, width]).reshape(2, 1, 1)
    pixels = np.stack([0.3 + 0.3 * u, 0.4 + 0.2 * v, 0.8 - 0.5 * v], axis=2)
    pixels[96:160, 160:288] = [20, 18, 15]
    mi.Bitmap(pixels.astype(np.float32)).write(str(path))


def texture(path):
    """A picture of coloured squares, as PNG."""
    y, x = np.mgrid[0:256, 0:256]
    pixels = np.stack([x, y, 255 * ((x // 32 + y // 32) % 2)], axis=2).astype(np.uint8)
    mi.Bitmap(pixels).write(str(path))


def ours(program, folder, material, lights, bounces, samples, seed):
    scene = folder / "scene.kdl"
    scene.write_text(
        "pathmarch 1\ncamera { position 1.6 1.4 -2.6; target 0 0.1 0; fov 40 }\n"
        f'material "m" {{ {material} }}\nmaterial "grey" {{ diffuse 0.5 }}\nmaterial "lamp" {{ emit 9 }}\n{lights}\n'
        f'object "cow" material="m" {{ mesh "{SPOT}" }}\n'
        'object "slab" material="grey" { box 6 0.2 6 { at 0 -0.85 0 } }\n'
    )
    output = folder / "ours.exr"
    command = [program, "render", scene, "-o", output, "--size", f"{SIZE[0]}x{SIZE[1]}", "--samples", str(samples)]
    command += ["--bounces", str(bounces), "--seed", str(seed), "--backend", "cpu", "--allow-files"]
    subprocess.run(command, check=True, capture_output=True)
    return np.array(mi.Bitmap(str(output)).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False))


def theirs(folder, material, lights, bounces, samples, seed):
    transform = mi.ScalarTransform4f()
    if material == "texture":
        picture = {"type": "bitmap", "filename": str(folder / "picture.png"), "filter_type": "bilinear"}
        material = {"type": "diffuse", "reflectance": picture}
    scene = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": bounces + 2, "rr_depth": 100},
        "sensor": {
            "type": "perspective", "fov": 40, "fov_axis": "y",
            "to_world": transform.look_at(origin=[1.6, 1.4, -2.6], target=[0, 0.1, 0], up=[0, 1, 0]),
            "film": {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1], "rfilter": {"type": "box"}},
            "sampler": {"type": "independent", "sample_count": samples},
        },
        "cow": {"type": "obj", "filename": str(SPOT), "face_normals": True, "bsdf": material},
        "slab": {
            "type": "cube", "to_world": transform.translate([0, -0.85, 0]).scale([3, 0.1, 3]),
            "bsdf": {"type": "diffuse", "reflectance": {"type": "rgb", "value": 0.5}},
        },
    }
    if "ENVIRONMENT" in lights or "env.exr" in lights:
        scene["sky"] = {"type": "envmap", "filename": str(folder / "env.exr")}
    else:
        scene["sky"] = {"type": "constant", "radiance": {"type": "rgb", "value": [0.5, 0.6, 0.8]}}
    if "lamp" in lights:
        scene["lamp"] = {
            "type": "rectangle",
            "to_world": transform.translate([0, 3, 1]).rotate([1, 0, 0], 90).scale([0.5, 0.5, 0.5]),
            "emitter": {"type": "area", "radiance": {"type": "rgb", "value": 9}},
        }
    return np.array(mi.render(mi.load_dict(scene), seed=seed))[:, :, :3]


def relmse(a, b):
    return float(np.mean((a - b) ** 2 / (b**2 + 1e-2)))


def main():
    program = sys.argv[1]
    samples = int(sys.argv[2]) if len(sys.argv) > 2 else 512
    print("| Scene | relMSE | noise of both | beyond | means, ours / Mitsuba |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        environment(folder / "env.exr")
        texture(folder / "picture.png")
        for case, (material, bsdf, lights, bounces) in CASES.items():
            material = material.replace("PICTURE", "picture.png")
            lights = lights.replace("ENVIRONMENT", "env.exr")
            a = [ours(program, folder, material, lights, bounces, samples, seed) for seed in (1, 2)]
            b = [theirs(folder, bsdf, lights, bounces, samples, seed) for seed in (1, 2)]
            # The mean of two pictures has a quarter of the variance of their difference.
            reference = 0.5 * (b[0] + b[1])
            noise = sum(float(np.mean((p[0] - p[1]) ** 2 / (4 * (reference**2 + 1e-2)))) for p in (a, b))
            error = relmse(0.5 * (a[0] + a[1]), reference)
            ratio = np.mean(a) / np.mean(b)
            print(f"| {case} | {error:.2e} | {noise:.2e} | {error - noise:+.1e} | {ratio:.5f} |", flush=True)


if __name__ == "__main__":
    main()
