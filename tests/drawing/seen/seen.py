"""What Chromium shows of an SVG against what is drawn of it: python seen.py FILE.svg...

The page's longer side is 240 mm. Chromium paints it at 0.15 mm a pixel. A visible line is where its picture changes
within three pixels: the edge of a stroke or of an area. The drawing counts as the strokes' middle lines with their
painted widths. Within 0.3 mm,
  false   share of the drawn length where the picture has no line, and no colour of the stroke's own
  bare    share of the drawn length where the picture is the paper's white
  missed  share of the picture's lines beside no drawn one, counting both edges of a stroke as half its width away
"""

import argparse
import dataclasses
import html
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image, ImageDraw
from scipy import ndimage

SIDE, PIXEL, NEAR = 240.0, 0.15, 0.3  # [mm]
CLEAR, FAINT = 40, 6  # change of a channel that must be drawn, and that may be, of 255
TALLEST = 8000  # pixels of a sheet
CHROMIUM = os.environ.get("CHROMIUM") or shutil.which("chromium")


@dataclasses.dataclass
class Seen:
    false: float
    bare: float
    missed: float
    drawn: float  # [mm]


def drawn_strokes(program, files):
    run = subprocess.run([program, *files], capture_output=True, text=True, check=True)
    for line in run.stderr.splitlines():
        print(line, file=sys.stderr)
    return [json.loads(line) for line in run.stdout.splitlines()]


def chromiums(files, pages, side=SIDE):
    """A picture of each file, as wide and high as its page [px], painted k times as large."""
    size = round(side / PIXEL)
    scales = [side / PIXEL / max(page) for page in pages]
    pictures = []
    while len(pictures) < len(files):
        some = range(len(pictures), min(len(pictures) + max(TALLEST // size, 1), len(files)))
        tiles = "".join(
            f'<div style="position:absolute;left:0;top:{size * row}px;width:{size}px;height:{size}px;overflow:hidden">'
            f'<img src="{html.escape(pathlib.Path(files[i]).resolve().as_uri())}" style="display:block;width:{pages[i][0]}px;'
            f'height:{pages[i][1]}px;transform-origin:0 0;transform:scale({scales[i]})"></div>'
            for row, i in enumerate(some)
        )
        with tempfile.TemporaryDirectory() as folder:
            sheet = pathlib.Path(folder, "sheet.html")
            sheet.write_text(f'<!doctype html><body style="margin:0;background:white">{tiles}')
            command = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--user-data-dir={folder}/user",
                       f"--window-size={size},{size * len(some)}", "--virtual-time-budget=20000", f"--screenshot={folder}/sheet.png", sheet.as_uri()]  # fmt: skip
            subprocess.run(command, capture_output=True, check=True, timeout=300)
            picture = np.asarray(Image.open(f"{folder}/sheet.png").convert("RGB"))
        for row, i in enumerate(some):
            width, height = (max(1, round(side * scales[i])) for side in pages[i])
            pictures.append(picture[size * row : size * row + height, :width])
    return pictures


def compare(picture, drawing, marked=None, side=SIDE):
    """Writes the picture with what is false in red and what is missed in blue to `marked`."""
    scale = side / PIXEL / max(drawing["page"])
    height, width = picture.shape[:2]
    change = np.zeros((height, width), int)
    for channel in range(3):
        plane = picture[:, :, channel]
        change = np.maximum(change, ndimage.maximum_filter(plane, 3).astype(int) - ndimage.minimum_filter(plane, 3))
    change[0] = change[-1] = change[:, 0] = change[:, -1] = 0
    faint, clear = change >= FAINT, change >= CLEAR
    paper = (picture >= 255 - FAINT).all(2)
    near = NEAR / PIXEL + 1
    to_line = ndimage.distance_transform_edt(~faint) if faint.any() else np.full(faint.shape, np.inf)
    to_colour = ndimage.distance_transform_edt(paper) if not paper.all() else np.full(faint.shape, np.inf)
    missing = clear.copy()
    sums, total = np.zeros(2), 0.0
    false_points = []
    by_width = {}
    for stroke in drawing["strokes"]:
        half = stroke["width"] * scale / 2
        points = np.array(stroke["points"]) * scale
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        along = np.concatenate([[0], np.cumsum(steps)])
        at = np.linspace(0, along[-1], max(2, int(2 * along[-1])))
        p = np.column_stack([np.interp(at, along, points[:, k]) for k in (0, 1)])
        pixel = np.floor(p).astype(int)
        rim = ((p >= -near) & (p <= np.array([width, height]) + near)).all(1)  # what lies on it is on the page
        pixel[rim] = pixel[rim].clip(0, (width - 1, height - 1))
        inside = (pixel >= 0).all(1) & (pixel < (width, height)).all(1)
        step = along[-1] / len(at)
        total += step * len(at)
        reach = np.full(len(p), np.inf), np.full(len(p), np.inf)
        for k, field in enumerate((to_line, to_colour)):
            reach[k][inside] = field[pixel[inside, 1], pixel[inside, 0]]
        border = ((p < near) | (p > np.array([width, height]) - near)).any(1)  # where the picture has no line
        false = (reach[0] > near + half) & ~(border & (reach[1] <= near))
        if not stroke["edge"]:
            own = np.array([stroke["colour"] >> shift & 255 for shift in (16, 8, 0)])
            same = np.zeros(len(p), bool)
            same[inside] = (np.abs(picture[pixel[inside, 1], pixel[inside, 0]].astype(int) - own) < CLEAR).all(1)
            false &= ~same
        sums += step * np.array([false.sum(), (reach[1] > near).sum()])
        false_points.append(p[false])
        key = 0 if half == 0 else int(np.ceil(4 * np.log2(max(half, 1))))
        by_width.setdefault((key, half > 0), []).append((half, points))
    for (_, wide), lines in by_width.items():
        ink = Image.new("1", (width, height))
        draw = ImageDraw.Draw(ink)
        for _, points in lines:
            on_rim = np.where(np.abs(points - (width, height)) < near, (width - 1, height - 1), points)
            flat = [tuple(p) for p in on_rim]
            draw.line(flat, fill=1) if len(flat) > 1 else draw.point(flat, fill=1)
        half = max(h for h, _ in lines)
        ink = np.asarray(ink)
        if ink.any():
            missing &= ndimage.distance_transform_edt(~ink) > near + (1.5 * half if wide else 0)
    if marked:
        shown = (255 - (255 - picture) // 3).astype(np.uint8).copy()
        shown[missing] = (0, 0, 255)
        for p in false_points:
            for dx in (-1, 0, 1):
                for dy in (-1, 0, 1):
                    x, y = np.clip(np.floor(p).astype(int) + (dx, dy), 0, (width - 1, height - 1)).T
                    shown[y, x] = (255, 0, 0)
        Image.fromarray(shown).save(marked)
    return Seen(*(sums / max(total, 1e-9)), missing.sum() / max(clear.sum(), 1), total * PIXEL)


def look(program, files, marked=None, side=SIDE):
    """Seen of each file; None where it is refused."""
    drawings = drawn_strokes(program, files)
    there = [i for i, drawing in enumerate(drawings) if drawing]
    pictures = chromiums([files[i] for i in there], [np.array(drawings[i]["page"]) * 96 / 25.4 for i in there], side)
    seen = [None] * len(files)
    for i, picture in zip(there, pictures):
        seen[i] = compare(picture, drawings[i], pathlib.Path(marked, pathlib.Path(files[i]).stem + ".png") if marked else None, side)
    return seen


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+")
    parser.add_argument("--program", default="build/release/tests/drawing/drawn_strokes")
    parser.add_argument("--marked", help="folder for pictures of what differs")
    parser.add_argument("--side", type=float, default=SIDE, help="longer side of the page [mm]: a smaller one is coarser")
    options = parser.parse_args()
    if options.marked:
        os.makedirs(options.marked, exist_ok=True)
    print(f"{'false':>8} {'bare':>8} {'missed':>8} {'mm':>8}")
    for first in range(0, len(options.files), 40):
        some = options.files[first : first + 40]
        for file, seen in zip(some, look(options.program, some, options.marked, options.side)):
            numbers = f"{seen.false:8.2%} {seen.bare:8.2%} {seen.missed:8.2%} {seen.drawn:8.0f}" if seen else f"{'refused':>35}"
            print(f"{numbers}  {file}", flush=True)


if __name__ == "__main__":
    main()
