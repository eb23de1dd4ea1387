"""Reads a PNG or JPEG as tone, 0 for the white paper and 1 for black, and renders an SVG as a PNG."""

from __future__ import annotations

import io
import pathlib
import subprocess
import sys
import warnings

import numpy as np
from PIL import Image, UnidentifiedImageError

MOST_PIXELS = 150e6  # 600 MB as Pillow holds them; with a copy, within 2 GB
# By EXIF's orientation, what turns the picture upright.
UPRIGHT = {2: Image.Transpose.FLIP_LEFT_RIGHT, 3: Image.Transpose.ROTATE_180, 4: Image.Transpose.FLIP_TOP_BOTTOM, 5: Image.Transpose.TRANSPOSE,
           6: Image.Transpose.ROTATE_270, 7: Image.Transpose.TRANSVERSE, 8: Image.Transpose.ROTATE_90}  # fmt: skip


class Refused(Exception):
    """What is wrong with the input, in one line."""


def _sixteen_bits(image: Image.Image, factor: int) -> Image.Image:
    """As eight bits, each pixel the mean of factor × factor; a transparent value is paper."""
    clear, rows = image.info.get("transparency"), []
    width, height = image.width // factor * factor, image.height // factor * factor
    for top in range(0, height, factor):
        strip = np.asarray(image.crop((0, top, width, top + factor))).astype(np.float32)
        if isinstance(clear, int):
            strip[strip == clear] = 65535
        rows.append(strip.reshape(factor, -1, factor).mean((0, 2)))
    return Image.fromarray(np.clip(np.array(rows) / 257 + 0.5, 0, 255).astype(np.uint8))


def _tone(image: Image.Image, longest: int) -> np.ndarray:
    if image.width * image.height > MOST_PIXELS:
        raise Refused(f"{image.width} × {image.height} pixels; at most {MOST_PIXELS / 1e6:.0f} million are read")
    orientation = image.getexif().get(0x0112, 1)
    image.draft(None, (2 * longest, 2 * longest))  # a JPEG is decoded at a half, a quarter or an eighth
    image.load()
    factor = max(1, max(image.size) // (2 * longest))
    if image.mode.startswith("I"):
        small = _sixteen_bits(image, min(factor, *image.size))
    else:
        if image.mode in ("1", "P", "PA") or "transparency" in image.info:
            image = image.convert("RGBA" if image.mode != "1" or "transparency" in image.info else "L")
        small = image.reduce(factor) if factor > 1 else image
    scale = min(1.0, longest / max(small.size))
    if scale < 1:
        small = small.resize([max(1, round(scale * side)) for side in small.size], Image.Resampling.BOX)
    if small.mode in ("LA", "La", "RGBa"):
        small = small.convert("LA" if small.mode != "RGBa" else "RGBA")
    if "A" in small.getbands():
        small = Image.alpha_composite(Image.new("RGBA", small.size, "white"), small.convert("RGBA"))
    if small.mode not in ("L", "RGB"):
        small = small.convert("RGB")
    if orientation in UPRIGHT:
        small = small.transpose(UPRIGHT[orientation])
    return 1 - np.asarray(small.convert("L"), np.float32) / 255


def read_tone(file, longest: int) -> np.ndarray:
    """Height × width of tone, EXIF's rotation applied, transparency on white. The longer side is reduced to ``longest`` pixels where it has
    more. Raises Refused."""
    Image.MAX_IMAGE_PIXELS = None  # ours counts
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            with Image.open(file, formats=("PNG", "JPEG")) as image:
                return _tone(image, longest)
        except UnidentifiedImageError:
            raise Refused("is neither an SVG nor a PNG or JPEG that can be read") from None
        except MemoryError:
            raise Refused("is too large for the memory of 2 GB") from None
        except Refused:
            raise
        except Exception as error:  # Pillow's decoders raise OSError, SyntaxError, ValueError, EOFError, zlib.error, struct.error …
            raise Refused(f"is broken or cut off: {str(error).splitlines()[0] if str(error) else type(error).__name__}") from None


LONGEST_RENDER = 60  # [s]
# In a process of its own, which can be stopped. A page has 96 pixels to the inch at zoom 1, and resvg drops parts of such a pixel at its edges.
# How many pixels a page has, a small rendering tells.
RENDER = """
import io, sys, resvg_py
from PIL import Image
folder = sys.argv[1].rpartition("/")[0] or "."
render = lambda zoom: resvg_py.svg_to_bytes(svg_path=sys.argv[1], resources_dir=folder, background="white", zoom=zoom, dpi=96)
size = lambda image: max(Image.open(io.BytesIO(image)).size)
try:
    page = 10 * size(render(0.1))
except ValueError:  # it has less than ten pixels, or there is another fault
    page = size(render(1))
zoom = float(sys.argv[2]) / page
image = render(zoom)
sys.stdout.buffer.write(b"%r\\n" % (size(image) / zoom) + image)
"""


def render_svg(file: pathlib.Path, longest: int) -> tuple[io.BytesIO, float]:
    """A PNG of the page, about ``longest`` pixels on the longer side, and that side [mm]. Raises Refused."""
    try:
        done = subprocess.run([sys.executable, "-P", "-c", RENDER, str(file), str(longest)], capture_output=True, timeout=LONGEST_RENDER)
    except subprocess.TimeoutExpired:
        raise Refused(f"takes more than {LONGEST_RENDER} s to render") from None
    if done.returncode:
        lines = done.stderr.decode(errors="replace").strip().splitlines()
        raise Refused(f"cannot be rendered: {lines[-1].partition(': ')[2] if lines else f'resvg ended with {done.returncode}'}")
    size, _, image = done.stdout.partition(b"\n")
    return io.BytesIO(image), float(size) * 25.4 / 96
