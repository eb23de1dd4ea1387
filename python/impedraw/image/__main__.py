"""The command ``impedraw image``, and ``--image`` and ``--trace`` of draw, plan and place."""

from __future__ import annotations

import argparse
import os
import pathlib
import resource
import subprocess
import sys
import time

import numpy as np

from . import ink, tones, trace
from .picture import Refused, read_tone, render_svg

MOST_MEMORY = 2_000_000_000  # [bytes] of data
LONGEST = 2400  # the sides of a scan that is traced [pixels]
LONGEST_PAGE = 4096  # of an SVG
PICTURE_SIZE = 180.0  # the longer side of a picture, which has no size of its own [mm]


class Progress:
    """A line on a terminal once two seconds have passed."""

    def __init__(self, what: str) -> None:
        self.what, self.start, self.shown = what, time.monotonic(), False

    def __call__(self, share: float) -> None:
        if sys.stderr.isatty() and time.monotonic() - self.start > 2:
            print(f"\r{self.what} {100 * min(share, 1):3.0f} %\033[K", end="", file=sys.stderr, flush=True)
            self.shown = True

    def close(self) -> None:
        if self.shown:
            print("\r\033[K", end="", file=sys.stderr, flush=True)


def rows_of(strokes: list[tuple[np.ndarray, np.ndarray | None]]) -> str:
    widths = any(w is not None for _, w in strokes)
    rows = ["x,y,stroke,width" if widths else "x,y,stroke"]
    for index, (points, width) in enumerate(strokes):
        if widths:
            rows += [f"{x:.4f},{y:.4f},{index},{w:.4f}" for (x, y), w in zip(points.tolist(), width.tolist())]
        else:
            rows += [f"{x:.4f},{y:.4f},{index}" for x, y in points.tolist()]
    return "\n".join(rows) + "\n"


def traced(picture, size: float, rendered: bool, progress: Progress) -> tuple[list, str]:
    """Centre lines [mm] of a page of that size, and a sentence about them."""
    progress(0.1)
    if rendered:
        drawing = trace.ink_on_white(read_tone(picture, 2 * LONGEST_PAGE))  # as it is rendered, which is about LONGEST_PAGE
    else:
        tone = read_tone(picture, LONGEST)
        drawing = trace.ink_of(tone, 3 if max(tone.shape) <= 1600 else 2)
    mm = size / max(drawing.shape)
    strokes = [(points * mm, widths * mm) for points, widths in trace.centre_lines(drawing)]
    if not strokes:
        raise Refused("has nothing to trace: its tone is even")
    return strokes, f"{len(strokes)} centre lines"


def drawn(options: argparse.Namespace, progress: Progress) -> tuple[list, str]:
    """Strokes [mm], and a sentence about them."""
    svg = options.picture.suffix.lower() in (".svg", ".svgz")
    picture, size = render_svg(options.picture, LONGEST_PAGE) if svg else (options.picture, PICTURE_SIZE)
    size = options.size or size
    if options.style == "trace":
        return traced(picture, size, svg, progress)
    # Four pixels to the pen's width would be more than it can show; fewer than 256 would be too coarse.
    per_mm = 1.6 / options.pen
    longest = int(np.clip(per_mm * size, 256, 1400))
    tone = read_tone(picture, longest)
    mm = size / max(tone.shape)
    if tone.max() <= tones.FAINTEST:
        raise Refused("has nothing to draw: it is white")
    if max(tone.shape) < longest:  # a small picture: lines are finer than its pixels
        from scipy.ndimage import zoom

        tone = np.clip(zoom(tone, longest / max(tone.shape), order=1, grid_mode=True, mode="nearest"), 0, 1)
        mm = size / max(tone.shape)
    lines = tones.strokes_of(tone, options.style, options.pen / mm, options.points, options.angle, options.seed, progress)
    if not lines:
        raise Refused(f"has nothing to draw as {options.style} at {size:g} mm with a pen of {options.pen:g} mm")
    likeness = ink.correlation(tone, ink.coverage(lines, tone.shape, options.pen / mm))
    return [(line * mm, None) for line in lines], f"{options.style}, {len(lines)} lines, tone correlates {likeness:.3f} with the picture's"


def add_styles(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--style", choices=[*tones.STYLES, "trace"], default="stipple", help="how lines show tone; trace: the centre lines of a drawing")
    parser.add_argument("--size", type=float, help=f"the longer side of the page [mm] (default: an SVG's own, {PICTURE_SIZE:g} of a picture)")
    parser.add_argument("--pen", type=float, default=0.5, help="width of the line [mm]")
    parser.add_argument("--points", type=int, default=5000, help="of stipple")
    parser.add_argument("--angle", type=float, default=45.0, help="of hatch and cross-hatch [degrees]")


def as_strokes(words: list[str]) -> list[str]:
    """The arguments of draw, plan or place with the lines of ``--image F`` as their ``--svg``: runs/pictures/F-STYLE.csv. ``--svg F --trace``
    stands for ``--image F --style trace``."""
    parser = argparse.ArgumentParser(prog=f"impedraw {words[0]}", add_help=False, allow_abbrev=False)
    traced = "--trace" in words
    parser.add_argument("--image", *(["--svg"] if traced else []), type=pathlib.Path)
    parser.add_argument("--trace", dest="style", action="store_const", const="trace", default=argparse.SUPPRESS)
    add_styles(parser)
    options, others = parser.parse_known_args(words[1:])
    if options.image is None:
        parser.error("--trace needs --svg F.svg or --image F")
    lines = pathlib.Path("runs/pictures") / f"{options.image.stem}-{options.style}.csv"
    lines.parent.mkdir(parents=True, exist_ok=True)
    styles = [f"--{name}={value}" for name in ("style", "size", "pen", "points", "angle") if (value := getattr(options, name)) is not None]
    # A process of its own: its limit of memory is not the drawing's.
    if code := subprocess.run([sys.executable, "-P", "-m", "impedraw.image", str(options.image), *styles, "--out", str(lines)]).returncode:
        sys.exit(code)
    return [words[0], *others, "--svg", str(lines)]


def main(arguments: list[str] | None = None) -> int:
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words[:1] == ["--then"]:
        os.execv(words[1], [words[1], *as_strokes(words[2:])])
    parser = argparse.ArgumentParser(prog="impedraw image", description="Makes strokes of a picture: a file that draw, plan, place and inspect take as --svg.")
    parser.add_argument("picture", type=pathlib.Path, help="a PNG, JPEG or SVG")
    add_styles(parser)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=pathlib.Path, required=True, help="the file of strokes, .csv")
    options = parser.parse_args(words[1:] if words[:1] == ["image"] else words)
    name, progress = str(options.picture), Progress("lines of the picture")
    resource.setrlimit(resource.RLIMIT_DATA, (MOST_MEMORY, MOST_MEMORY))
    try:
        for what, value, least, most in (("size", options.size, 1, 10000), ("pen", options.pen, 0.01, 100), ("points", options.points, 3, 100000)):
            if value is not None and not least <= value <= most:
                raise Refused(f"--{what} is {value:g}; valid are {least:g} to {most:g}")
        if not options.picture.exists():
            raise Refused("does not exist")
        strokes, said = drawn(options, progress)
        options.out.write_text(rows_of(strokes))
    except Refused as error:
        progress.close()
        print(f"{name}: {error}", file=sys.stderr)
        return 2
    except MemoryError:
        progress.close()
        print(f"{name}: needs more than 2 GB of memory", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"{error.filename or name}: {error.strerror}", file=sys.stderr)
        return 2
    progress.close()
    print(f"{name}: {said}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
