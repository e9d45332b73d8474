#!/usr/bin/env python3
"""Writes environment.exr beside this file: a photographer's studio as an equirectangular picture of 256 by 128 texels.

    python3 scenes/make_environment.py

Directions are those of `sky "FILE"`: the middle of the picture is +z, a quarter from the left edge is +x, row 0 is up.
Radiance in W/(m² sr), half floats, ZIP compression. The standard library is all it takes.
"""

import math
import pathlib
import struct
import zlib

WIDTH, HEIGHT = 256, 128
ROWS_IN_CHUNK = 16  # of OpenEXR's ZIP compression

# Softboxes: azimuth (degrees from +z towards -x as the picture is seen, so that +x is -90), elevation, half width and
# half height in degrees, radiance.
SOFTBOXES = [
    (-62, 38, 22, 17, (15.0, 12.6, 9.6)),  # warm key, upper right
    (78, 18, 9, 34, (3.2, 5.0, 8.4)),  # cool strip, left
    (168, 30, 40, 5, (7.0, 6.6, 6.4)),  # long rim light, behind
    (10, 84, 30, 6, (4.0, 4.2, 4.6)),  # overhead
]


def direction(azimuth, elevation):
    """Unit vector of angles in degrees."""
    a, e = math.radians(azimuth), math.radians(elevation)
    return (-math.sin(a) * math.cos(e), math.sin(e), math.cos(a) * math.cos(e))


def mix(a, b, t):
    return tuple(x + (y - x) * t for x, y in zip(a, b))


def smoothstep(low, high, x):
    t = min(max((x - low) / (high - low), 0.0), 1.0)
    return t * t * (3.0 - 2.0 * t)


def backdrop(y):
    """The room without its lights; y is the upward component of the direction."""
    if y < 0.0:
        return mix((0.12, 0.1, 0.1), (0.02, 0.02, 0.025), min(-y * 2.0, 1.0))
    return mix((0.16, 0.13, 0.13), (0.02, 0.03, 0.06), smoothstep(0.0, 0.6, y))


def radiance(d):
    """Radiance from a unit direction."""
    colour = backdrop(d[1])
    for azimuth, elevation, half_width, half_height, light in SOFTBOXES:
        forwards = direction(azimuth, elevation)
        right = direction(azimuth - 90, 0)
        up = direction(azimuth, elevation + 90)
        depth, x, y = (sum(p * q for p, q in zip(d, axis)) for axis in (forwards, right, up))
        if depth <= 0.0:
            continue
        # Plane of the softbox at distance 1; its edges fade over a tenth of its size.
        x = abs(x / depth) / math.tan(math.radians(half_width))
        y = abs(y / depth) / math.tan(math.radians(half_height))
        share = (1.0 - smoothstep(0.92, 1.02, x)) * (1.0 - smoothstep(0.92, 1.02, y))
        centre = 1.0 - 0.35 * min(x * x + y * y, 1.0)
        colour = mix(colour, tuple(v * centre for v in light), share)
    return colour


def texel(column, row):
    """Mean of four by four points of a texel."""
    total = (0.0, 0.0, 0.0)
    for k in range(16):
        u = (column + (k % 4 + 0.5) / 4) / WIDTH
        v = (row + (k // 4 + 0.5) / 4) / HEIGHT
        turn, polar = 2 * math.pi * u, math.pi * v
        d = (math.sin(turn) * math.sin(polar), math.cos(polar), -math.cos(turn) * math.sin(polar))
        total = tuple(a + b / 16 for a, b in zip(total, radiance(d)))
    return total


def zip_chunk(data):
    """OpenEXR's ZIP: even bytes then odd ones, differences, deflate."""
    split = data[0::2] + data[1::2]
    delta = bytes([split[0]] + [(b - a + 384) & 255 for a, b in zip(split, split[1:])])
    packed = zlib.compress(delta, 9)
    return packed if len(packed) < len(data) else data


def attribute(name, kind, value):
    return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value


def exr(rows):
    """The bytes of a scan line OpenEXR file of half floats; `rows` holds triples."""
    channels = b"".join(name + b"\0" + struct.pack("<iB3xii", 1, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    window = struct.pack("<4i", 0, 0, WIDTH - 1, HEIGHT - 1)
    header = struct.pack("<II", 20000630, 2)
    header += attribute("channels", "chlist", channels)
    header += attribute("compression", "compression", b"\x03")
    header += attribute("dataWindow", "box2i", window)
    header += attribute("displayWindow", "box2i", window)
    header += attribute("lineOrder", "lineOrder", b"\0")
    header += attribute("pixelAspectRatio", "float", struct.pack("<f", 1.0))
    header += attribute("screenWindowCenter", "v2f", struct.pack("<2f", 0.0, 0.0))
    header += attribute("screenWindowWidth", "float", struct.pack("<f", 1.0)) + b"\0"
    chunks = []
    for first in range(0, HEIGHT, ROWS_IN_CHUNK):
        data = b"".join(
            struct.pack(f"<{WIDTH}e", *(colour[channel] for colour in row))
            for row in rows[first : first + ROWS_IN_CHUNK]
            for channel in (2, 1, 0)
        )
        packed = zip_chunk(data)
        chunks.append(struct.pack("<ii", first, len(packed)) + packed)
    offset = len(header) + 8 * len(chunks)
    table = b""
    for chunk in chunks:
        table += struct.pack("<Q", offset)
        offset += len(chunk)
    return header + table + b"".join(chunks)


if __name__ == "__main__":
    picture = [[texel(column, row) for column in range(WIDTH)] for row in range(HEIGHT)]
    target = pathlib.Path(__file__).with_name("environment.exr")
    target.write_bytes(exr(picture))
    print(f"wrote {target}, {target.stat().st_size} bytes")
