"""pbrt-v4's adapter: writes the scene as pbrt's text and runs its program, once for every picture.

    WOODCOCK_PBRT=PROGRAM PYTHON pbrt_side.py FOLDER

Films are taken from pbrt's own colours back to the bands of pbrt_scene.py by what pbrt itself answers to light in each
of them. Where media are grey the wavelengths are fixed, one or more in each band: nothing is left of their noise. Where
they are not, pbrt's weights need them drawn.
"""

from __future__ import annotations

import os
import re
import shutil
import struct
import subprocess
import zlib
from pathlib import Path

import numpy as np
from pbrt_scene import DEPTH, Bands, Spectra, film, grey, written
from protocol import Image, Job, Render, Skip, serve

THREADS = 2
#: Light of one colour and nothing else, seen by even steps of wavelengths; pbrt wants a shape, which stands behind.
PLAIN = """{film}
PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
Sampler "stratified" "integer xsamples" 32 "integer ysamples" 32
Integrator "volpath"
Camera "perspective"
WorldBegin
LightSource "infinite" {light}
Translate 0 0 -9
Shape "sphere"
"""


class Pbrt:
    """The program, and the scene's folder in which it runs."""

    def __init__(self, program: str, folder: Path, fixed: bool) -> None:
        self._program, self._folder = program, folder
        self._flags = ["--nthreads", str(THREADS), *(["--disable-wavelength-jitter"] if fixed else [])]

    def picture(self, text: Path, *flags: str) -> tuple[Image, float, str]:
        """What it renders, the seconds that this took alone, and what it said."""
        image = self._folder / "pbrt.exr"
        command = [self._program, *self._flags, *flags, "--outfile", str(image), str(text)]
        done = subprocess.run(command, cwd=self._folder, capture_output=True, text=True, check=False)
        if done.returncode:
            said = (done.stderr + done.stdout).strip() or f"ended with {done.returncode}"
            raise RuntimeError(f"pbrt: {said.splitlines()[-1]}")
        return *read_exr(image), done.stdout

    def answer(self, light: str) -> tuple[Image, str]:
        """To an environment: the film's (3,), and what pbrt said."""
        text = self._folder / "plain.pbrt"
        text.write_text(PLAIN.format(film=film(16, 16), light=light))
        image, _, said = self.picture(text)
        return image.mean(axis=(0, 1), dtype=float), said


def calibrated(pbrt: Pbrt) -> tuple[Bands, Image]:
    """The bands' shares of luminance; and the matrix from film colours to what is in the bands.

    Every light is brought to a luminance of 1, so the answer to all bands at once is that to each, times its share.
    """
    plain = Bands(np.ones(3))
    columns = np.stack([pbrt.answer(plain.value("L", band))[0] for band in np.eye(3)], axis=1)
    shares = np.linalg.solve(columns, pbrt.answer(plain.value("L", np.ones(3)))[0])
    return Bands(shares), np.linalg.inv(columns * shares)


def make(job: Job) -> tuple[dict[str, str], Render]:
    program = shutil.which(os.environ.get("WOODCOCK_PBRT", ""))
    if program is None:
        raise Skip("not installed: WOODCOCK_PBRT names no program")
    volume = job.scene["volumes"][0]
    glows = volume["emission"] is not None
    fixed = grey(volume) and not glows
    pbrt = Pbrt(program, job.folder, fixed)
    white, said = pbrt.answer(Spectra().light("L", np.ones(3)))
    colours, to_rgb = (Spectra(), np.diag(1 / white)) if glows else calibrated(pbrt)
    text = job.folder / "scene.pbrt"
    text.write_text(written(job, colours))

    def render(samples: int, seed: int) -> tuple[Image, float]:
        image, seconds, _ = pbrt.picture(text, "--quiet", "--spp", str(samples), "--seed", str(seed))
        return image @ to_rgb.T, seconds

    settings = [f"volpath, independent sampler, {THREADS} threads, {DEPTH} scatterings at most"]
    settings.append("its own spectra for colours" if glows else "colours as spectra of three bands")
    settings.append("fixed wavelengths" if fixed else "drawn wavelengths")
    if volume["kind"] == "grid":
        settings.append("majorants of 16³ cells")
    if glows:
        settings.append("its product of two grids fitted to the emission")
    version = re.search(r"pbrt version (.*)", said)
    described = {"name": "pbrt-v4 volpath", "version": version[1] if version else "4", "settings": "; ".join(settings)}
    return described, render


def read_exr(path: Path) -> tuple[Image, float]:
    """(height, width, 3) float32 and the seconds that rendering took, of an EXR as pbrt writes them: scan lines of
    floats, packed by ZIP or not at all. Raises ValueError."""
    data, header, start = path.read_bytes(), {}, 8
    while data[start]:
        end = data.index(0, data.index(0, start) + 1)
        name = data[start : data.index(0, start)].decode()
        (length,) = struct.unpack_from("<i", data, end + 1)
        header[name] = data[end + 5 : end + 5 + length]
        start = end + 5 + length
    floats = b"".join(name + struct.pack("<xiiii", 2, 0, 1, 1) for name in (b"B", b"G", b"R")) + b"\0"
    lines = {0: 1, 2: 1, 3: 16}.get(header["compression"][0])
    if lines is None or header["channels"] != floats:
        raise ValueError(f"{path.name} is no picture of three floats a pixel, packed by ZIP")
    left, top, right, bottom = struct.unpack("<4i", header["dataWindow"])
    image = np.empty((bottom + 1 - top, right + 1 - left, 3), np.float32)
    for offset in struct.unpack_from(f"<{-(-len(image) // lines)}Q", data, start + 1):
        y, size = struct.unpack_from("<ii", data, offset)
        rows = image[y - top : y - top + lines]
        block = np.frombuffer(data, np.uint8, size, offset + 8)
        if size < rows.nbytes:  # differences of bytes, those at even places first
            steps = np.frombuffer(zlib.decompress(block), np.uint8).astype(np.int64)
            steps[1:] -= 128
            block = np.empty(rows.nbytes, np.uint8)
            block[::2], block[1::2] = np.split(np.cumsum(steps).astype(np.uint8), [(rows.nbytes + 1) // 2])
        rows[:] = block.view("<f4").reshape(len(rows), 3, -1)[:, ::-1].transpose(0, 2, 1)
    return image, struct.unpack("<f", header["renderTimeSeconds"])[0]


if __name__ == "__main__":
    serve(make)
