"""A program that answers to light in bands as pbrt-v4 does: film colours mix the bands, and lights are brought to a
luminance of 1 first. Rows grow brighter by the seed; seed 13 fails."""

import re
import struct
import sys
from pathlib import Path

#: Film colours of the bands red, green and blue in the columns; and what each has of the luminance.
FILM = ((90, 5, -3), (-9, 80, 4), (2, -7, 30))
LUMINANCE = (40, 60, 9)

flags, text = sys.argv[1:-1], Path(sys.argv[-1]).read_text()
given = dict(zip(flags, [*flags[1:], ""], strict=True))
assert given["--nthreads"] == "2"
assert "--disable-wavelength-jitter" in given
seed = int(given.get("--seed", 0))
if seed == 13:
    sys.exit("something\nError: out of luck")
if "--quiet" not in given:
    print("pbrt version 4 (built Jan  1 2026 at 12:00:00)\nCopyright")
width, height = (int(re.findall(rf'"integer {axis}resolution" (\d+)', text)[0]) for axis in "xy")
kind, numbers, scale = re.findall(r'"infinite" "(\w+) L" \[([^]]*)\](?: "float scale" (\S+))?', text)[0]
light = [float(number) for number in numbers.split()]
bands = [light[9], light[5], light[1]] if kind == "spectrum" else light
luminance = sum(weight * band for weight, band in zip(LUMINANCE, bands, strict=True))
color = [float(scale or 1) / luminance * sum(m * b for m, b in zip(row, bands, strict=True)) for row in FILM]


def attribute(name: str, kind: str, data: bytes) -> bytes:
    return f"{name}\0{kind}\0".encode() + struct.pack("<i", len(data)) + data


header = struct.pack("<ii", 20000630, 2)
floats = b"".join(name + struct.pack("<xiiii", 2, 0, 1, 1) for name in (b"B", b"G", b"R"))
header += attribute("channels", "chlist", floats + b"\0")
header += attribute("compression", "compression", b"\0")
header += attribute("dataWindow", "box2i", struct.pack("<4i", 0, 0, width - 1, height - 1))
header += attribute("renderTimeSeconds", "float", struct.pack("<f", int(given.get("--spp", 0)) / 64)) + b"\0"
rows = [[color[c] * (1 + y * seed) for c in (2, 1, 0) for _ in range(width)] for y in range(height)]
lines = [struct.pack(f"<ii{3 * width}f", y, 12 * width, *row) for y, row in enumerate(rows)]
starts = [len(header) + 8 * height + y * len(lines[0]) for y in range(height)]
Path(given["--outfile"]).write_bytes(header + struct.pack(f"<{height}Q", *starts) + b"".join(lines))
