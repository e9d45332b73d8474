#!/usr/bin/env python3
"""Makes the reference pictures of this folder with Mitsuba 3: for each scene NAME.exr (converged radiance) and NAME.kdl
(the same scene in pathmarch's language). Both come from one definition below, so they cannot drift apart.

    pip install mitsuba==3.9.1 numpy            # and libLLVM 19 (Debian: libllvm19); if Mitsuba finds an older one:
    export DRJIT_LIBLLVM_PATH=/usr/lib/x86_64-linux-gnu/libLLVM.so.19.1
    export MITSUBA_VARIANT=scalar_rgb           # instead, slower and without LLVM
    python3 references.py --list                # names and default samples
    python3 references.py mirror sun            # make these two
    python3 references.py --all                 # make all of them
    python3 references.py --all --kdl-only      # write the scene files and the environment map alone
    python3 references.py --samples 1024 --out /tmp/try --png mirror
    python3 references.py --measure             # what the choice of masking function changes

Prints for each picture the seconds it took and its own noise: the expected relMSE of the picture against the exact
answer, from the difference of two independent halves A and B, mean((A - B)² / 4 / (((A + B) / 2)² + 0.01)).

Conventions (those of `furnace_050` and `diffuse_sphere_plane`, made earlier): box pixel filter, independent sampler, no
Russian roulette, max_depth = bounces + 2, linear Rec. 709, half-float EXR; an emitter reflects nothing; plane =
rectangle of half size 500. Materials:

* `metal` is the plugin SchlickMetal below (GGX, height-correlated Smith, Schlick Fresnel), except in `rough_metal`
  where it is Mitsuba's own `roughconductor` (separable Smith), and in `principled`.
* `metal` of roughness 0 is `conductor` times a constant, `glass` is `dielectric` or `roughdielectric` (separable
  Smith), `principled` is `principled` (separable Smith). alpha = roughness² throughout.
* `absorb` is a homogeneous medium of zero albedo inside the shape, rendered by `volpath`.
* `fog` is the medium of the camera, a `medium` one inside a shape with the BSDF `null`, rendered by `volpath`.
* `caustics "traced"` is `ptracer`, which shows no surface that is seen over a mirror or through glass: none is in view.
* `priority` has no counterpart: Mitsuba's interfaces adjoin exactly and have the indices of both sides, ours overlap.
* `thin #true` is `thindielectric`.
* `sun` is a sphere 10 km away of radiance irradiance / (pi sin²(angle/2)) + sky: the sun adds to the sky it covers.
* A sky from a file is bilinear between texel centres ((i + 1/2)/width, (j + 1/2)/height), wraps around sideways and is
  clamped at the poles. Direction (x, y, z) has u = atan2(x, -z) / 2 pi (mod 1) and v = acos(y) / pi, v = 0 the top
  row: the left edge of the map is at -z, a quarter to the right is +x, the middle +z. `rotate` turns the sky about +y,
  right-handed: with rotate=90 the middle of the map is at +x.
"""

import argparse
import math
import os
import sys
import time

import mitsuba as mi
import numpy as np

mi.set_variant(os.environ.get("MITSUBA_VARIANT", "llvm_ad_rgb"))
import drjit as dr  # noqa: E402  (needs the variant)
from mitsuba import ScalarTransform4f as T  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
MAP = "environment_map.exr"


class SchlickMetal(mi.BSDF):
    """GGX reflection off a conductor, single scattering: D·G2·F / (4 cos cos), sampled by visible normals.
    G2 = 1/(1 + Λ(wi) + Λ(wo)), or G1(wi)·G1(wo) if `separable`; F = f0 + (edge - f0)(1 - cos)⁵."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.alpha = props["alpha"]
        self.f0 = props["f0"]
        self.edge = props["edge"]
        self.separable = props.get("separable", False)
        lobe = mi.BSDFFlags.GlossyReflection | mi.BSDFFlags.FrontSide
        self.m_components = [lobe]
        self.m_flags = lobe

    def facets(self):
        return mi.MicrofacetDistribution(mi.MicrofacetType.GGX, self.alpha, True)

    def fresnel(self, cosine):
        f0, edge = mi.Color3f(self.f0), mi.Color3f(self.edge)
        x = dr.clip(1 - cosine, 0, 1)
        return f0 + (edge - f0) * (x * x) * (x * x) * x

    def lam(self, v):
        """Smith's Λ for GGX."""
        return (dr.sqrt(1 + self.alpha**2 * mi.Frame3f.tan_theta_2(v)) - 1) / 2

    def shadowing(self, wi, wo):
        if self.separable:
            return 1 / ((1 + self.lam(wi)) * (1 + self.lam(wo)))
        return 1 / (1 + self.lam(wi) + self.lam(wo))

    def sample(self, ctx, si, sample1, sample2, active):
        m, _ = self.facets().sample(si.wi, sample2)
        bs = mi.BSDFSample3f()
        bs.wo = mi.reflect(si.wi, m)
        bs.eta = 1.0
        bs.sampled_component = mi.UInt32(0)
        bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
        value, bs.pdf = self.eval_pdf(ctx, si, bs.wo, active)
        active &= bs.pdf > 0
        return bs, dr.select(active, value / bs.pdf, 0)

    def eval_pdf(self, ctx, si, wo, active):
        wi = si.wi
        active &= (mi.Frame3f.cos_theta(wi) > 0) & (mi.Frame3f.cos_theta(wo) > 0)
        h = dr.normalize(wi + wo)
        facets = self.facets()
        value = facets.eval(h) * self.shadowing(wi, wo) / (4 * mi.Frame3f.cos_theta(wi))
        pdf = facets.pdf(wi, h) / (4 * dr.dot(wo, h))
        return (
            dr.select(active, self.fresnel(dr.dot(wi, h)) * value, 0),
            dr.select(active, pdf, 0),
        )

    def eval(self, ctx, si, wo, active):
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active):
        return self.eval_pdf(ctx, si, wo, active)[1]

    def to_string(self):
        return f"SchlickMetal[alpha={self.alpha}]"


mi.register_bsdf("schlickmetal", SchlickMetal)


# ---- numbers and colours -------------------------------------------------------------------------------------------


def num(x):
    text = f"{x:.6g}"
    return "0" if text == "-0" else text


def words(values):
    return " ".join(num(v) for v in values)


def triple(c):
    return (c, c, c) if isinstance(c, (int, float)) else tuple(c)


def rgb(c):
    return {"type": "rgb", "value": list(triple(c))}


def colour(c):
    return num(c) if isinstance(c, (int, float)) else words(c)


# ---- shapes: (text, Mitsuba) ---------------------------------------------------------------------------------------


def place(at, rotate):
    """rotate about the fixed x, then y, then z axis, then move."""
    t = T().translate(list(at))
    for axis, angle in (([0, 0, 1], rotate[2]), ([0, 1, 0], rotate[1]), ([1, 0, 0], rotate[0])):
        t = t @ T().rotate(axis, angle)
    return t


def placed(text, at, rotate):
    inside = [f"rotate {words(rotate)}"] if any(rotate) else []
    inside += [f"at {words(at)}"] if any(at) else []
    return text + (" { " + "; ".join(inside) + " }" if inside else "")


# Mitsuba's flat shapes lie in xy and face +z; pathmarch's lie in xz and face +y.
LAY_FLAT = T().rotate([1, 0, 0], -90)


def sphere(radius, at):
    return placed(f"sphere {num(radius)}", at, (0, 0, 0)), {"type": "sphere", "center": list(at), "radius": radius}


def box(size, at, rotate=(0, 0, 0)):
    half = T().scale([s / 2 for s in size])
    return placed(f"box {words(size)}", at, rotate), {"type": "cube", "to_world": place(at, rotate) @ half}


def rect(x, z, at, rotate=(0, 0, 0)):
    world = place(at, rotate) @ LAY_FLAT @ T().scale([x / 2, z / 2, 1])
    return placed(f"rect {words((x, z))}", at, rotate), {"type": "rectangle", "to_world": world}


def disc(radius, at, rotate=(0, 0, 0)):
    world = place(at, rotate) @ LAY_FLAT @ T().scale([radius, radius, 1])
    return placed(f"disc {num(radius)}", at, rotate), {"type": "disk", "to_world": world}


def shell(radius, inside, at):
    """A hollow ball. Mitsuba's is the outer surface; what fills it has the inner one."""
    balls = f"subtract {{ sphere {num(radius)}; sphere {num(inside)}; at {words(at)} }}"
    return balls, sphere(radius, at)[1]


def overlapping(radius, more, at):
    """A ball that fills a hollow one. Ours reaches into its wall, Mitsuba's touches it."""
    return sphere(radius + more, at)[0], sphere(radius, at)[1]


def plane():
    return "plane", {"type": "rectangle", "to_world": LAY_FLAT @ T().scale([500, 500, 1])}


# ---- materials: (text, what Mitsuba's shape gets) ------------------------------------------------------------------


def both_sides(bsdf):
    return {"bsdf": {"type": "twosided", "inner": bsdf}}


def diffuse(c):
    return f"diffuse {colour(c)}", both_sides({"type": "diffuse", "reflectance": rgb(c)})


def emit(c):
    black = both_sides({"type": "diffuse", "reflectance": rgb(0)})
    return f"emit {colour(c)}", {**black, "emitter": {"type": "area", "radiance": rgb(c)}}


def metal(f0, edge, roughness, own=False, separable=False):
    """`own`: Mitsuba's roughconductor, whose Fresnel factor is then constant."""
    text = f"metal {colour(f0)}; edge {colour(edge)}; roughness {num(roughness)}"
    if roughness == 0:
        assert f0 == edge
        return text, both_sides({"type": "conductor", "material": "none", "specular_reflectance": rgb(f0)})
    alpha = roughness**2
    if own:
        assert f0 == edge
        bsdf = {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": alpha}
        return text, {"bsdf": {**bsdf, "specular_reflectance": rgb(f0)}}
    bsdf = {"type": "schlickmetal", "alpha": alpha, "separable": separable}
    vectors = {"f0": mi.ScalarVector3f(triple(f0)), "edge": mi.ScalarVector3f(triple(edge))}
    return text, {"bsdf": {**bsdf, **vectors}}


def homogeneous(scatter, absorb, anisotropy):
    """Text and Mitsuba's medium. Mitsuba takes an extinction as a colour up to 1 times a scale."""
    scattering, absorption = np.array(triple(scatter)), np.array(triple(absorb))
    extinction = scattering + absorption
    scale = float(extinction.max())
    medium = {
        "type": "homogeneous",
        "albedo": rgb([float(c) for c in scattering / extinction]),
        "sigma_t": rgb([float(c) for c in extinction / scale]),
        "scale": scale,
        "phase": {"type": "hg", "g": anisotropy} if anisotropy else {"type": "isotropic"},
    }
    return f"absorb {colour(absorb)}; anisotropy {num(anisotropy)}", medium


def medium(scatter, absorb, anisotropy):
    text, inside = homogeneous(scatter, absorb, anisotropy)
    return f"medium {colour(scatter)}; {text}", {"bsdf": {"type": "null"}, "interior": inside}


def milky_glass(scatter, absorb, anisotropy, ior=1.5, roughness=0):
    text, parts = glass(ior, roughness)
    inside_text, parts["interior"] = homogeneous(scatter, absorb, anisotropy)
    return f"{text}; scatter {colour(scatter)}; {inside_text}", parts


def glass(ior=1.5, roughness=0, absorb=None):
    text = f"glass 1; ior {num(ior)}; roughness {num(roughness)}"
    bsdf = {"type": "dielectric", "int_ior": ior, "ext_ior": 1.0}
    if roughness > 0:
        bsdf.update(type="roughdielectric", distribution="ggx", alpha=roughness**2)
    parts = {"bsdf": bsdf}
    if absorb is not None:
        text += f"; absorb {colour(absorb)}"
        # Mitsuba takes an extinction as a colour up to 1 times a scale.
        scale = max(triple(absorb))
        sigma_t = rgb([c / scale for c in triple(absorb)])
        parts["interior"] = {"type": "homogeneous", "albedo": 0.0, "sigma_t": sigma_t, "scale": scale}
    return text, parts


def nested(priority, ior, outside=1.0, roughness=0, absorb=None):
    """Glass in something of another index: ours has a priority, Mitsuba's both indices."""
    text, parts = glass(ior, roughness, absorb)
    parts["bsdf"]["ext_ior"] = outside
    return f"{text}; priority {priority}", parts


def thin(c, ior):
    bsdf = {"type": "thindielectric", "int_ior": ior, "ext_ior": 1.0, "specular_transmittance": rgb(c)}
    return f"glass {colour(c)}; ior {num(ior)}; thin #true", {"bsdf": bsdf}


def principled_metal(c, roughness):
    bsdf = {"type": "principled", "base_color": rgb(c), "metallic": 1.0, "roughness": roughness}
    return f"principled {colour(c)}; metallic 1; roughness {num(roughness)}", {"bsdf": bsdf}


def principled_glass(roughness, ior):
    bsdf = {"type": "principled", "base_color": rgb(1), "spec_trans": 1.0, "roughness": roughness, "eta": ior}
    return f"principled 1; transmission 1; roughness {num(roughness)}; ior {num(ior)}", {"bsdf": bsdf}


# ---- a scene -------------------------------------------------------------------------------------------------------


class Scene:
    def __init__(self, note, samples, position=(0, 4, 7), target=(0, 0.7, 0), fov=26, bounces=6, size=(160, 120)):
        self.note, self.samples, self.bounces, self.size = note, samples, bounces, size
        self.position, self.target, self.fov, self.lens = position, target, fov, None
        self.lines, self.materials, self.parts, self.names = [], {}, {}, set()
        self.sky_radiance = (0, 0, 0)
        self.camera_medium, self.traced_caustics = None, False

    def comment(self, text):
        self.lines.append(f"// {text}")

    def sky(self, c):
        self.sky_radiance = triple(c)
        self.lines.append(f"sky {colour(c)}")
        self.parts["sky"] = {"type": "constant", "radiance": rgb(c)}

    def fog(self, scatter, absorb, anisotropy):
        text, self.camera_medium = homogeneous(scatter, absorb, anisotropy)
        self.lines.append(f"fog {{ scatter {colour(scatter)}; {text} }}")

    def point(self, at, intensity):
        self.lines.append(f"point {{ at {words(at)}; intensity {colour(intensity)} }}")
        self.parts["point"] = {"type": "point", "position": list(at), "intensity": rgb(intensity)}

    def sky_map(self, strength=1, rotate=0):
        properties = f" strength={num(strength)}" if strength != 1 else ""
        properties += f" rotate={num(rotate)}" if rotate else ""
        self.lines.append(f'sky "{MAP}"{properties}')
        bitmap = mi.Bitmap(fine_map(environment_map()))
        turn = T().rotate([0, 1, 0], rotate)
        self.parts["sky"] = {"type": "envmap", "bitmap": bitmap, "scale": float(strength), "to_world": turn}

    def sun(self, direction, irradiance, angle, distance=1e4):
        text = f"direction {words(direction)}; irradiance {colour(irradiance)}; angle {num(angle)}"
        self.lines.append(f"sun {{ {text} }}")
        sine = math.sin(math.radians(angle / 2))
        d = np.array(direction) / np.linalg.norm(direction)
        radiance = np.array(triple(irradiance)) / (math.pi * sine**2) + np.array(self.sky_radiance)
        ball = {"type": "sphere", "center": list(d * distance), "radius": distance * sine}
        self.parts["sun"] = {**ball, **emit([float(x) for x in radiance])[1]}

    def material(self, name, made):
        text, self.materials[name] = made
        self.lines.append(f'material "{name}" {{ {text} }}')

    def object(self, name, material, *shapes):
        assert name not in self.names, name
        self.names.add(name)
        texts = [text for text, _ in shapes]
        head = f'object "{name}" material="{material}" {{'
        if len(texts) == 1:
            self.lines.append(f"{head} {texts[0]} }}")
        else:
            self.lines += [head, *("    " + text for text in texts), "}"]
        for i, (_, shape) in enumerate(shapes):
            key = f"shape {name} {i}".replace(".", " ")
            self.parts[key] = {**shape, **self.materials[material]}

    def kdl(self):
        lens = f"; lens radius={num(self.lens[0])} focus={num(self.lens[1])}" if self.lens else ""
        view = f"position {words(self.position)}; target {words(self.target)}; up 0 1 0; fov {num(self.fov)}"
        written = "// Written by references.py, which renders the picture beside this file."
        head = ["pathmarch 1", f"// {self.note}", written]
        head.append(f'camera "main" {{ {view}{lens} }}')
        caustics = '; caustics "traced"' if self.traced_caustics else ""
        head.append(f"render {{ size {self.size[0]} {self.size[1]}; bounces {self.bounces}{caustics} }}")
        return "\n".join(head + self.lines) + "\n"

    def mitsuba(self):
        media = self.camera_medium or any("interior" in part for part in self.parts.values())
        camera = {
            "type": "thinlens" if self.lens else "perspective",
            "fov": self.fov,
            "fov_axis": "y",
            "to_world": T().look_at(origin=self.position, target=self.target, up=[0, 1, 0]),
            "film": {
                "type": "hdrfilm",
                "width": self.size[0],
                "height": self.size[1],
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
            "sampler": {"type": "independent"},
        }
        if self.camera_medium:
            camera["medium"] = self.camera_medium
        if self.lens:
            camera["aperture_radius"], camera["focus_distance"] = self.lens
        kind = "ptracer" if self.traced_caustics else "volpath" if media else "path"
        integrator = {"type": kind, "max_depth": self.bounces + 2, "rr_depth": 10000}
        return mi.load_dict({"type": "scene", "integrator": integrator, "sensor": camera, **self.parts})

    def render(self, samples, seed=0):
        """The mean picture, its own noise and how many samples it took."""
        scene = self.mitsuba()
        per_pass = min(256, max(1, samples // 2))
        passes = 2 * math.ceil(samples / per_pass / 2)
        halves = [0.0, 0.0]
        for i in range(passes):
            picture = mi.render(scene, spp=per_pass, seed=seed + i)
            halves[i % 2] = halves[i % 2] + np.array(picture, dtype=np.float64)
        a, b = (h / (passes // 2) for h in halves)
        mean = (a + b) / 2
        noise = np.mean((a - b) ** 2 / 4 / (mean**2 + 0.01))
        return mean, noise, passes * per_pass


# ---- the sky of `environment` --------------------------------------------------------------------------------------


def environment_map(width=128, height=64):
    """A ground, a sky brightening towards the horizon, a warm glow and a small sun of some texels in +x +z."""
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    theta, phi = v * np.pi, u * 2 * np.pi
    d = np.stack([np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)], axis=-1)
    y = d[..., 1:2]
    high, low, ground = np.array([0.25, 0.45, 0.9]), np.array([0.9, 0.85, 0.8]), np.array([0.2, 0.16, 0.12])
    sky = low + (high - low) * np.sqrt(np.clip(y, 0, 1))
    blend = np.clip(0.5 + 6 * y, 0, 1)
    towards = np.array([0.6, 0.55, 0.75]) / np.linalg.norm([0.6, 0.55, 0.75])
    cosine = np.clip(np.sum(d * towards, axis=-1, keepdims=True), -1, 1)
    sun = 60 * np.exp((cosine - 1) / 0.0035) * np.array([1.0, 0.85, 0.6])
    glow = 0.8 * np.exp((cosine - 1) / 0.2) * np.array([1.0, 0.7, 0.4])
    return (ground + (sky - ground) * blend + sun + glow).astype(np.float32)


def fine_map(texels):
    """Mitsuba puts its first and last rows on the poles, so that no row centre is where a picture's is. On this finer
    grid, which has a sample at every centre of the coarse one, its interpolation equals that between those centres."""
    height, width, _ = texels.shape
    fine_width, fine_height = 9 * width, 8 * height + 1
    x = (np.arange(fine_width) + 0.5) / fine_width * width - 0.5
    y = np.clip(np.arange(fine_height) / (fine_height - 1) * height - 0.5, 0, height - 1)
    x0, y0 = np.floor(x).astype(int), np.minimum(np.floor(y).astype(int), height - 2)
    fx, fy = (x - x0)[None, :, None], (y - y0)[:, None, None]
    left, right = texels[:, x0 % width], texels[:, (x0 + 1) % width]
    rows = left * (1 - fx) + right * fx
    return np.ascontiguousarray(rows[y0] * (1 - fy) + rows[y0 + 1] * fy, dtype=np.float32)


# ---- the scenes ----------------------------------------------------------------------------------------------------

GOLD = (1, 0.78, 0.34)


def rough_metal(edge=GOLD, **kind):
    what = "Schlick Fresnel towards white at the edge" if edge != GOLD else "the same colour at every angle"
    s = Scene(f"Metal balls of roughness 0.15, 0.4 and 0.8, {what}, under a square lamp and a dim sky.", 16384)
    s.sky((0.2, 0.22, 0.25))
    s.material("floor", diffuse(0.5))
    s.object("floor", "floor", plane())
    for x, roughness in ((-1.7, 0.15), (0, 0.4), (1.7, 0.8)):
        name = f"roughness {roughness}"
        s.material(name, metal(GOLD, edge, roughness, **kind))
        s.object(name, name, sphere(0.8, (x, 0.8, 0)))
    s.material("lamp", emit(8))
    s.object("lamp", "lamp", rect(2.5, 2.5, (-1, 5, 2), (180, 0, 0)))
    return s


def rough_metal_correlated():
    return rough_metal(edge=(1, 1, 1))


def room(s, width, height, depth, back, front):
    """Floor, ceiling, back, left and right; open towards +z."""
    middle = (back + front) / 2
    s.material("white", diffuse(0.7))
    s.material("red", diffuse((0.6, 0.1, 0.08)))
    s.material("green", diffuse((0.12, 0.45, 0.15)))
    s.object("floor", "white", rect(width, depth, (0, 0, middle)))
    s.object("ceiling", "white", rect(width, depth, (0, height, middle), (180, 0, 0)))
    s.object("back", "white", rect(width, height, (0, height / 2, back), (90, 0, 0)))
    s.object("left", "red", rect(height, depth, (-width / 2, height / 2, middle), (0, 0, -90)))
    s.object("right", "green", rect(height, depth, (width / 2, height / 2, middle), (0, 0, 90)))


def mirror():
    s = Scene(
        "Perfect mirrors in a diffuse room open at the front: a ball and a box.",
        16384, position=(0, 1, 3.9), target=(0, 1, 0), fov=39.3, bounces=8,
    )
    s.sky((0.15, 0.18, 0.25))
    room(s, 2, 2, 2, -1, 1)
    s.material("mirror", metal(0.9, 0.9, 0))
    s.object("ball", "mirror", sphere(0.38, (0.45, 0.4, 0.35)))
    s.object("box", "mirror", box((0.6, 1.2, 0.6), (-0.4, 0.62, -0.3), (0, 25, 0)))
    s.material("lamp", emit((6, 5.4, 4.5)))
    s.object("lamp", "lamp", rect(1.2, 1.2, (0, 1.98, 0), (180, 0, 0)))
    return s


def glass_scene(absorb, note, lamp=True, samples=8192):
    s = Scene(note, samples, bounces=8)
    s.sky((0.6, 0.65, 0.75))
    s.material("floor", diffuse((0.55, 0.5, 0.45)))
    s.material("blue", diffuse((0.1, 0.2, 0.5)))
    s.material("clear", glass())
    s.material("tinted", glass(absorb=absorb) if absorb is not None else glass())
    s.object("floor", "floor", plane())
    s.object("step", "blue", box((3.6, 0.4, 0.5), (0, 0.18, -1.6)))
    s.object("ball", "clear", sphere(0.85, (-1.1, 0.9, 0.2)))
    s.object("block", "tinted", box((1.1, 1.3, 1.1), (1.15, 0.7, 0.2), (0, 28, 0)))
    if lamp:
        s.material("lamp", emit((2.5, 2.4, 2.2)))
        s.object("lamp", "lamp", rect(5, 5, (-1, 6, 0), (180, 0, 0)))
    return s


def glass_clear():
    note = "Smooth glass, index 1.5: a ball and a block, under a sky and a large lamp."
    return glass_scene(None, note, samples=16384)


def glass_absorb():
    return glass_scene((0.3, 0.8, 1.6), "Smooth glass: a clear ball, a block that absorbs; a sky alone.", False)


def rough_glass():
    s = Scene("Rough glass balls, roughness 0.2 and 0.5, over slabs of two colours.", 8192, bounces=8)
    s.sky((0.6, 0.65, 0.75))
    s.material("floor", diffuse(0.6))
    s.material("red", diffuse((0.6, 0.12, 0.08)))
    s.material("blue", diffuse((0.08, 0.15, 0.5)))
    s.object("floor", "floor", plane())
    for i in range(6):
        for j in range(4):
            if (i + j) % 2 == 0:
                colour_name = "red" if j % 2 == 0 else "blue"
                s.object(f"slab {i} {j}", colour_name, box((0.7, 0.2, 0.7), (0.7 * i - 1.75, 0.08, 0.7 * j - 1.4)))
    for x, roughness in ((-1, 0.2), (1, 0.5)):
        name = f"roughness {roughness}"
        s.material(name, glass(roughness=roughness))
        s.object(name, name, sphere(0.8, (x, 1.05, 0.1)))
    s.material("lamp", emit((2.5, 2.4, 2.2)))
    s.object("lamp", "lamp", rect(5, 5, (-1, 6, 0), (180, 0, 0)))
    return s


def environment(strength=1, rotate=0, size=(160, 120)):
    turned = f", {num(strength)} times as bright and turned by {num(rotate)} degrees" if rotate else ""
    s = Scene(f"A diffuse, a rough metal and a mirror ball lit by {MAP}{turned}.", 8192, size=size)
    s.sky_map(strength, rotate)
    s.material("floor", diffuse(0.5))
    s.material("white", diffuse((0.7, 0.65, 0.6)))
    s.material("gold", metal(GOLD, (1, 1, 1), 0.3))
    s.material("mirror", metal(0.9, 0.9, 0))
    s.object("floor", "floor", plane())
    s.object("diffuse", "white", sphere(0.8, (-1.7, 0.8, 0)))
    s.object("rough", "gold", sphere(0.8, (0, 0.8, 0)))
    s.object("mirror", "mirror", sphere(0.8, (1.7, 0.8, 0)))
    return s


def environment_rotated():
    return environment(1.5, 90, (96, 72))


def sun():
    s = Scene("A sun five degrees wide and a dim sky on a diffuse and a rough metal ball.", 16384)
    s.sky((0.15, 0.2, 0.3))
    s.sun((0.6, 0.8, 0.5), (3, 2.8, 2.5), 5)
    s.material("floor", diffuse(0.5))
    s.material("white", diffuse((0.7, 0.6, 0.5)))
    s.material("gold", metal(GOLD, (1, 1, 1), 0.3))
    s.object("floor", "floor", plane())
    s.object("diffuse", "white", sphere(0.9, (-1.1, 0.9, 0)))
    s.object("rough", "gold", sphere(0.9, (1.1, 0.9, 0)))
    return s


def many_lights():
    note = "64 small lamps of different colours and sizes above boxes and a metal ball."
    s = Scene(note, 16384, position=(0, 4.5, 8), fov=35)
    s.sky(0.02)
    s.material("floor", diffuse(0.6))
    s.material("white", diffuse(0.7))
    s.material("metal", metal((0.9, 0.9, 0.9), (1, 1, 1), 0.5))
    s.object("floor", "floor", plane())
    s.object("left", "white", box((0.8, 0.8, 0.8), (-1.7, 0.38, 0.3), (0, 20, 0)))
    s.object("tall", "white", box((0.7, 1.5, 0.7), (0.1, 0.73, -1.2), (0, -15, 0)))
    s.object("right", "white", box((0.6, 0.4, 1.2), (1.8, 0.18, 0.4), (0, 40, 0)))
    s.object("ball", "metal", sphere(0.6, (0.1, 0.6, 0.9)))
    s.comment("Lamp i, 0 to 63: r = 3.2 sqrt((i + 1/2)/64), a = 137.508 i°, at (r cos a, 1.9 + 0.3 sin(i), r sin a),")
    s.comment("radius 0.05 + 0.01 (i mod 6), red green blue = (4 + 2 (i mod 5)) (0.55 + 0.45 cos(2.4 i + 0, 2.1, 4.2)),")
    s.comment("sin and cos of i in radians.")
    for i in range(64):
        r, a = 3.2 * math.sqrt((i + 0.5) / 64), math.radians(137.508 * i)
        at = (r * math.cos(a), 1.9 + 0.3 * math.sin(i), r * math.sin(a))
        power = 4 + 2 * (i % 5)
        c = [power * (0.55 + 0.45 * math.cos(2.4 * i + k)) for k in (0, 2.1, 4.2)]
        # The values as they are written in the file.
        at, c = [float(num(x)) for x in at], [float(num(x)) for x in c]
        s.material(f"lamp {i}", emit(c))
        s.object(f"lamp {i}", f"lamp {i}", sphere(round(0.05 + 0.01 * (i % 6), 6), at))
    return s


def principled():
    s = Scene("The principled material as a metal and as rough glass.", 8192, bounces=8)
    s.sky((0.6, 0.65, 0.75))
    s.material("floor", diffuse((0.55, 0.5, 0.45)))
    s.material("blue", diffuse((0.1, 0.2, 0.5)))
    s.material("gold", principled_metal(GOLD, 0.25))
    s.material("frosted", principled_glass(0.25, 1.5))
    s.object("floor", "floor", plane())
    s.object("step", "blue", box((3.6, 0.4, 0.5), (0, 0.18, -1.6)))
    s.object("metal", "gold", sphere(0.85, (-1.1, 0.85, 0.2)))
    s.object("glass", "frosted", sphere(0.85, (1.1, 0.9, 0.2)))
    s.material("lamp", emit((2.5, 2.4, 2.2)))
    s.object("lamp", "lamp", rect(5, 5, (-1, 6, 0), (180, 0, 0)))
    return s


def lens():
    s = Scene(
        "A thin lens focused on the middle one of three balls.", 8192, position=(0, 0.7, 3), target=(0, 0.7, 0), fov=40,
    )
    s.lens = (0.1, 3)
    s.sky((0.4, 0.5, 0.65))
    s.material("floor", diffuse((0.6, 0.58, 0.55)))
    s.material("red", diffuse((0.65, 0.12, 0.08)))
    s.material("green", diffuse((0.15, 0.5, 0.15)))
    s.material("blue", diffuse((0.1, 0.2, 0.6)))
    s.object("floor", "floor", plane())
    s.object("near", "red", sphere(0.25, (-0.32, 0.62, 1.4)))
    s.object("middle", "green", sphere(0.5, (0.1, 0.5, 0)))
    s.object("far", "blue", sphere(0.9, (2, 0.9, -4)))
    s.material("lamp", emit(8))
    s.object("lamp", "lamp", rect(2, 2, (-1.5, 4, 1), (180, 0, 0)))
    return s


def box_light():
    s = Scene(
        "A room lit by a box that emits on all its faces and a disc that emits on one.",
        16384, position=(0, 1, 3.9), target=(0, 1, 0), fov=39.3, bounces=8,
    )
    room(s, 2, 2, 2, -1, 1)
    s.object("block", "white", box((0.5, 0.7, 0.5), (0.45, 0.33, -0.3), (0, -20, 0)))
    s.material("glow", emit((3, 2.4, 1.5)))
    s.material("cold", emit((4, 5, 7)))
    s.object("lamp", "glow", box((0.35, 0.5, 0.25), (-0.35, 0.6, 0.1), (20, 30, 10)))
    s.object("spot", "cold", disc(0.3, (0.5, 1.7, 0.2), (150, 0, 25)))
    return s


def fog_point():
    note = "Fog of three coefficients that scatters forwards, a point light above a ball and a box."
    s = Scene(note, 8192, position=(0, 1.6, 6), target=(0, 1, 0), fov=36, bounces=6, size=(96, 72))
    s.fog((0.1, 0.14, 0.2), (0.02, 0.02, 0.03), 0.5)
    s.point((0.5, 3.4, 0.3), (12, 10, 8))
    s.material("floor", diffuse(0.5))
    s.material("white", diffuse((0.7, 0.6, 0.5)))
    s.object("floor", "floor", plane())
    s.object("ball", "white", sphere(0.6, (-0.9, 0.6, 0.4)))
    s.object("box", "white", box((0.7, 1.2, 0.7), (1.3, 0.58, -0.6), (0, 25, 0)))
    return s


def fog_area():
    note = "Fog that scatters alike in all directions, a square lamp and a small ball of light."
    s = Scene(note, 8192, position=(0, 1.6, 6), target=(0, 1, 0), fov=36, bounces=6, size=(96, 72))
    s.fog((0.25, 0.2, 0.15), 0.03, 0)
    s.material("floor", diffuse(0.5))
    s.material("white", diffuse((0.7, 0.6, 0.5)))
    s.material("lamp", emit(6))
    s.material("bulb", emit((60, 40, 20)))
    s.object("floor", "floor", plane())
    s.object("ball", "white", sphere(0.6, (-0.9, 0.6, 0.4)))
    s.object("box", "white", box((0.7, 1.2, 0.7), (1.3, 0.58, -0.6), (0, 25, 0)))
    s.object("lamp", "lamp", rect(1.2, 1.2, (-0.6, 2.6, 0), (180, 0, 0)))
    s.object("bulb", "bulb", sphere(0.08, (0.35, 0.9, 0.5)))
    return s


def caustic_point():
    note = "Caustics of a point light on a floor: a ball and a block of glass, and a mirror, all out of view."
    s = Scene(note, 65536, position=(0, 1.1, 2.2), target=(0, 0, 0), fov=40, bounces=6, size=(96, 72))
    s.traced_caustics = True
    s.point((0.2, 3.6, 0), (24, 22, 18))
    s.material("floor", diffuse((0.6, 0.55, 0.5)))
    s.material("clear", glass())
    s.material("mirror", metal(0.9, 0.9, 0))
    s.object("floor", "floor", plane())
    s.object("ball", "clear", sphere(0.4, (-0.5, 1.65, 0)))
    s.object("block", "clear", box((0.6, 0.5, 0.6), (0.8, 1.7, -0.1), (30, 40, 0)))
    s.object("mirror", "mirror", box((0.1, 1.2, 1.4), (1.9, 0.8, 1.2), (0, -20, 0)))
    return s


def subsurface():
    note = "Light that walks inside solids: a smooth and a rough ball that scatter and absorb."
    s = Scene(note, 8192, bounces=40, size=(96, 72))
    s.sky((0.6, 0.65, 0.75))
    s.material("floor", diffuse((0.55, 0.5, 0.45)))
    s.material("skin", milky_glass((5, 4, 3), (0.05, 0.3, 0.6), 0.3, ior=1.4))
    s.material("wax", milky_glass((3, 4, 5), (0.1, 0.05, 0.02), 0, ior=1.3, roughness=0.4))
    s.object("floor", "floor", plane())
    s.object("smooth", "skin", sphere(0.8, (-1, 0.85, 0.2)))
    s.object("rough", "wax", sphere(0.8, (1, 0.85, 0.2)))
    s.material("lamp", emit((2.5, 2.4, 2.2)))
    s.object("lamp", "lamp", rect(5, 5, (-1, 6, 0), (180, 0, 0)))
    return s


def smoke():
    note = "Media without surfaces around a ball and around a lamp, under a dim sky."
    s = Scene(note, 8192, bounces=10, size=(96, 72))
    s.sky((0.25, 0.3, 0.4))
    s.material("floor", diffuse((0.55, 0.5, 0.45)))
    s.material("white", diffuse(0.7))
    s.material("bulb", emit((30, 22, 14)))
    s.material("smoke", medium((1.2, 1.5, 1.8), (0.3, 0.2, 0.1), -0.3))
    s.object("floor", "floor", plane())
    s.object("ball", "white", sphere(0.4, (-1, 0.5, 0.2)))
    s.object("bulb", "bulb", sphere(0.1, (1, 0.9, 0.2)))
    s.object("left", "smoke", sphere(0.9, (-1, 0.95, 0.2)))
    s.object("right", "smoke", sphere(0.9, (1, 0.95, 0.2)))
    return s


def nested_glass():
    s = Scene("Water in a glass shell, a bubble of air in water, a frosted core in a ball of oil.", 4096, bounces=12)
    s.sky((0.6, 0.65, 0.75))
    s.material("floor", diffuse((0.55, 0.5, 0.45)))
    s.material("blue", diffuse((0.1, 0.2, 0.5)))
    s.material("shell", nested(2, 1.5))
    s.material("water", nested(1, 1.33, 1.5, absorb=(0.8, 0.3, 0.15)))
    s.material("pond", nested(0, 1.33))
    s.material("air", nested(1, 1.0, 1.33))
    s.material("oil", nested(-3, 1.47))
    s.material("core", nested(-1, 1.8, 1.47, roughness=0.4))
    s.object("floor", "floor", plane())
    s.object("step", "blue", box((3.6, 0.4, 0.5), (0, 0.18, -1.6)))
    s.object("shell", "shell", shell(0.75, 0.6, (-1.7, 0.77, 0.2)))
    s.object("water", "water", overlapping(0.6, 0.03, (-1.7, 0.77, 0.2)))
    s.object("pond", "pond", sphere(0.75, (0, 0.77, 0.4)))
    s.object("bubble", "air", sphere(0.4, (0.1, 0.85, 0.45)))
    s.object("oil", "oil", sphere(0.75, (1.7, 0.77, 0.2)))
    s.object("core", "core", sphere(0.45, (1.65, 0.7, 0.25)))
    s.material("lamp", emit((2.5, 2.4, 2.2)))
    s.object("lamp", "lamp", rect(5, 5, (-1, 6, 0), (180, 0, 0)))
    return s


def thin_glass():
    s = Scene("A soap bubble and two panes of thin glass, one of them tinted.", 4096, bounces=12)
    s.sky((0.6, 0.65, 0.75))
    s.material("floor", diffuse((0.55, 0.5, 0.45)))
    s.material("blue", diffuse((0.1, 0.2, 0.5)))
    s.material("film", thin(1, 1.33))
    s.material("pane", thin(1, 1.9))
    s.material("tinted", thin((0.9, 0.6, 0.3), 1.5))
    s.object("floor", "floor", plane())
    s.object("step", "blue", box((3.6, 0.4, 0.5), (0, 0.18, -1.6)))
    s.object("bubble", "film", sphere(0.75, (-1.5, 0.8, 0.2)))
    s.object("pane", "pane", rect(1.2, 1.4, (0.3, 0.75, 0.2), (90, -50, 0)))
    s.object("tinted", "tinted", rect(1.2, 1.4, (1.6, 0.75, 0.4), (90, 20, 0)))
    s.material("lamp", emit((2.5, 2.4, 2.2)))
    s.object("lamp", "lamp", rect(5, 5, (-1, 6, 0), (180, 0, 0)))
    return s


SCENES = {
    "rough_metal": lambda: rough_metal(own=True),
    "rough_metal_correlated": rough_metal_correlated,
    "mirror": mirror,
    "glass": glass_clear,
    "glass_absorb": glass_absorb,
    "rough_glass": rough_glass,
    "environment": environment,
    "environment_rotated": environment_rotated,
    "sun": sun,
    "many_lights": many_lights,
    "principled": principled,
    "lens": lens,
    "box_light": box_light,
    "caustic_point": caustic_point,
    "fog_point": fog_point,
    "fog_area": fog_area,
    "subsurface": subsurface,
    "smoke": smoke,
    "nested_glass": nested_glass,
    "thin_glass": thin_glass,
}


# ---- running -------------------------------------------------------------------------------------------------------


def relmse(a, b):
    return np.mean((a - b) ** 2 / (b**2 + 0.01))


def measure(samples):
    """rough_metal with Mitsuba's own roughconductor, and with the plugin in the same form and height-correlated."""
    own, noise, _ = rough_metal(own=True).render(samples)
    print(f"own noise of each {noise:.1e}")
    for label, kind, seed in (("plugin, separable", True, 10000), ("plugin, correlated", False, 20000)):
        picture, _, _ = rough_metal(separable=kind).render(samples, seed)
        change = picture.mean() / own.mean() - 1
        print(f"{label} against roughconductor: mean {100 * change:+.3f} %, relMSE {relmse(picture, own):.2e}")
        for i, name in enumerate(("0.15", "0.4", "0.8")):
            inside = disc_mask(rough_metal(), (1.7 * (i - 1), 0.8, 0), 0.8)
            change = picture[inside].mean() / own[inside].mean() - 1
            print(f"  ball of roughness {name}: mean {100 * change:+.3f} %")


def disc_mask(scene, centre, radius):
    """The pixels whose centre ray meets the sphere."""
    width, height = scene.size
    forward = np.array(scene.target, float) - scene.position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, (0, 1, 0))
    right /= np.linalg.norm(right)
    up = np.cross(right, forward)
    x, y = np.meshgrid((np.arange(width) + 0.5) / width * 2 - 1, 1 - (np.arange(height) + 0.5) / height * 2)
    tangent = math.tan(math.radians(scene.fov / 2))
    d = forward + tangent * (y[..., None] * up + x[..., None] * right * width / height)
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    to = np.array(centre, float) - scene.position
    along = d @ to
    return to @ to - along**2 < radius**2


def write_map(folder):
    bitmap = mi.Bitmap(environment_map())
    bitmap.write(os.path.join(folder, MAP))


def main():
    parser = argparse.ArgumentParser(description="Makes the reference pictures; the top of this file says more.")
    parser.add_argument("names", nargs="*", help="scenes to make")
    parser.add_argument("--all", action="store_true", help="make every scene")
    parser.add_argument("--list", action="store_true", help="list the scenes and stop")
    parser.add_argument("--samples", type=int, help="samples per pixel, instead of each scene's own number")
    parser.add_argument("--out", default=HERE, help="folder to write to (default: the script's)")
    parser.add_argument("--kdl-only", action="store_true", help="write the scene files, render nothing")
    parser.add_argument("--png", action="store_true", help="write NAME.png too, sRGB, to look at")
    parser.add_argument("--measure", action="store_true", help="compare the separable and the correlated Smith term")
    options = parser.parse_args()

    if options.list:
        for name, make in SCENES.items():
            scene = make()
            print(f"{name:24} {scene.samples:6} samples  {scene.note}")
        return
    if options.measure:
        measure(options.samples or 4096)
        return
    names = list(SCENES) if options.all else options.names
    unknown = [name for name in names if name not in SCENES]
    if unknown or not names:
        sys.exit(f"no such scene: {', '.join(unknown)}" if unknown else "name the scenes to make, or --all")

    for name in names:
        scene = SCENES[name]()
        path = os.path.join(options.out, name)
        if name.startswith("environment"):
            write_map(options.out)
        with open(path + ".kdl", "w", encoding="utf-8") as file:
            file.write(scene.kdl())
        if options.kdl_only:
            continue
        start = time.time()
        picture, noise, samples = scene.render(options.samples or scene.samples)
        bitmap = mi.Bitmap(picture.astype(np.float32))
        bitmap.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float16, srgb_gamma=False).write(path + ".exr")
        if options.png:
            bitmap.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.UInt8, srgb_gamma=True).write(path + ".png")
        mean = " ".join(f"{c:.4f}" for c in picture.mean(axis=(0, 1)))
        took = time.time() - start
        print(f"{name:24} {samples:6} samples {took:6.1f} s  own relMSE {noise:.1e}  mean {mean}", flush=True)


if __name__ == "__main__":
    main()
