"""Times the thesis's published program: python render_thesis.py pathTracer.fs FRAMES --size 1280 720 --rounds 9

pathTracer.fs is shaders/pathTracer.fs of github.com/Arukiap/Path-marcher, which is read and not kept here. It runs in an
OpenGL context without a window (PyPI's moderngl over EGL; Mesa's llvmpipe where there is no GPU). FRAMES is JSON, a list
of {"scene": "a" to "g", "position", "target", "fov": degrees, "hits"}. The scenes are laid out after the thesis's
figures, because the published files do not contain them. Two edits only make the shader faster: the scene is constant,
and the loop over its objects is unrolled; the syntax is adapted to a core profile.

Prints a line of JSON for each frame: the median milliseconds of a frame of one sample, and the name of the device.
"""
import argparse
import json
import math
import re
import statistics
import time

import moderngl
import numpy as np

WHITE, GREY = (1, 1, 1), (.5, .5, .5)


def sphere(centre, radius, colour, emission=0, kind=0):
    return (centre, 2 * radius, 0, colour, emission, kind)


def cube(centre, half, colour, emission=0, kind=0):
    return (centre, half, 1, colour, emission, kind)


def floor(y, half, colour, z=0):
    return ((0, y, z), half, 2, colour, 0, 0)


def wall(centre, half, colour):
    return (centre, half, 7, colour, 0, 0)


ROOM = [floor(0, 3.2, WHITE, z=1), floor(3, 3.2, WHITE, z=1), wall((0, 1.5, -2.1), 3.2, WHITE),
        cube((-6, 1.5, 1), 3, WHITE), cube((6, 1.5, 1), 3, WHITE),
        wall((0, -2.7, 4), 3.2, WHITE), wall((0, 5.1, 4), 3.2, WHITE), cube((0, 1.2, 4), .7, WHITE)]
LIGHT = (5, 10, 40)
SCENES = {  # objects, position of the light
    "a": ([sphere((0, 1, 0), 1, WHITE), floor(0, 6, WHITE)], LIGHT),
    "b": (ROOM + [sphere((-.45, .75, -.6), .75, (.8, .8, 0), .5, 1)], LIGHT),
    "c": ([((0, .5, 0), 1, 4, WHITE, 0, 2), floor(0, 6, WHITE)], (-6, 9, 5)),
    "d": ([floor(0, 3.2, GREY), wall((0, -1.1, -3.1), 3.1, GREY), wall((0, -1.1, 3.1), 3.1, GREY), cube((-6, -1, 0), 3, GREY),
           cube((6, -1, 0), 3, GREY), sphere((-1.9, .8, -.2), .8, (1, .1, .1)), sphere((1.2, .4, -2), .4, (.1, .1, .1), 0, 1)],
          (12, 20, 6)),
    "e": ([cube((0, 2, 0), 2, GREY, .3, 1), sphere((-.9, .6, -.6), .6, (1, 0, 0), 2), sphere((.5, .5, .1), .5, (0, 0, 1), 2),
           sphere((.05, .35, -1.25), .35, (0, 1, 0), 2)], LIGHT),
    "f": ([((0, 0, 0), 1, 6, GREY, 0, 0)], LIGHT),
    "g": ([sphere((-1.2, .5, 0), .5, (1, 0, 0), .3, 1), sphere((0, .5, 0), .5, (0, 1, 0), .3, 1),
           sphere((1.2, .5, 0), .5, (0, 0, 1), .3, 1), floor(0, 4, WHITE), wall((0, 0, -1.5), 4, WHITE)], LIGHT),
}
VERTEX = """#version 410 core
layout(location = 0) in vec2 position;
layout(location = 2) out vec2 texCoords;
uniform vec2 resolution;
uniform vec3 cameraPosition, cameraFront, cameraUp;
uniform float fov, time;
out vec2 v_resolution;
out vec3 v_cameraPosition;
out mat3 v_cameraMatrix;
out float v_fov;
out float v_time;
out float v_hasCameraChanged;
void main() {
    gl_Position = vec4(position, 0, 1);
    v_cameraMatrix = mat3(cross(cameraFront, cameraUp), cameraUp, cameraFront);
    v_resolution = resolution;
    v_cameraPosition = cameraPosition;
    v_fov = fov;
    v_time = time;
    v_hasCameraChanged = 1.0;
    texCoords = position * 0.5 + 0.5;
}"""


def vec3(v):
    return "vec3(%s)" % ",".join("%.6f" % x for x in v)


def fragment(text, objects, light, hits):
    literals = ["Object(%s,%.6f,%d,%s,%.6f,%d,%d)" % (vec3(centre), size, kind, vec3(colour), emission, surface, index)
                for index, (centre, size, kind, colour, emission, surface) in enumerate(objects)]
    text = re.sub(r"in vec4 gl_FragCoord;", "", text)
    text = re.sub(r"\bvarying\b", "in", text)
    text = text.replace("gl_FragColor", "outColour").replace("uniform sampler2D blueNoise;", "out vec4 outColour;\nuniform sampler2D blueNoise;")
    text = re.sub(r"const int sceneObjectNumber = \d+;", f"const int sceneObjectNumber = {len(literals)};", text)
    text = re.sub(r"Scene globalScene = Scene\(.*?\)\);",
                  "const Scene globalScene = Scene(Object[sceneObjectNumber](%s));" % ",".join(literals), text, flags=re.S)
    text = re.sub(r"vec3 lightSource = vec3\([^)]*\);", f"vec3 lightSource = {vec3(light)};", text)
    text = re.sub(r"MAX_MARCH_DEPTH = 4", f"MAX_MARCH_DEPTH = {hits}", text)
    nearest = "if (minimumCollision.distance > c.distance) minimumCollision = c;"
    unrolled = "".join("{ SceneCollision c = getObjectDistanceAsCollision(ray, %s); %s }\n" % (literal, nearest) for literal in literals)
    text, count = re.subn(r"for\(int i = 0; i < globalScene\.sceneObjects\.length\(\); i\+\+\)\{.*?\n\t\}\n",
                          lambda match: unrolled, text, flags=re.S)
    assert count == 1, "this is not the published shader"
    return text


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("shader")
    parser.add_argument("frames", type=json.loads)
    parser.add_argument("--size", type=int, nargs=2, default=(1280, 720))
    parser.add_argument("--rounds", type=int, default=9)
    arguments = parser.parse_args()
    width, height = arguments.size
    context = moderngl.create_standalone_context(backend="egl", require=410)
    target, before = context.texture((width, height), 4), context.texture((width, height), 4)
    framebuffer = context.framebuffer([target])
    quad = context.buffer(np.array([-1, -1, 1, -1, -1, 1, 1, 1], "f4").tobytes())
    with open(arguments.shader, encoding="utf-8", errors="replace") as file:
        source = file.read()
    for frame in arguments.frames:
        objects, light = SCENES[frame["scene"]]
        program = context.program(vertex_shader=VERTEX, fragment_shader=fragment(source, objects, light, frame["hits"]))
        position, target_point = np.array(frame["position"]), np.array(frame["target"])
        front = (target_point - position) / np.linalg.norm(target_point - position)
        right = np.cross(front, [0, 1, 0])
        right /= np.linalg.norm(right)
        # The program takes twice the tangent of half its angle for the whole height.
        angle = math.degrees(2 * math.atan(2 * math.tan(math.radians(frame["fov"]) / 2)))
        values = {"resolution": (width, height), "cameraPosition": tuple(position), "cameraFront": tuple(front),
                  "cameraUp": tuple(np.cross(right, front)), "fov": angle}
        for name, value in values.items():
            if name in program:
                program[name] = value
        vertices = context.vertex_array(program, [(quad, "2f", "position")])
        framebuffer.use()
        before.use(0)
        times = []
        for index in range(arguments.rounds + 1):
            if "time" in program:
                program["time"] = 1.0 + index
            began = time.perf_counter()
            vertices.render(moderngl.TRIANGLE_STRIP)
            context.finish()
            times.append((time.perf_counter() - began) * 1000)
        print("RESULT " + json.dumps({"milliseconds": statistics.median(times[1:]), "device": context.info["GL_RENDERER"]}), flush=True)


main()
