"""Makes the pictures in docs/images from runs of the program. `./impedraw figures --pictures` calls it."""

import pathlib
import subprocess
from collections.abc import Callable

import numpy as np
from matplotlib.figure import Figure
from PIL import Image, PngImagePlugin

import quotes

# Runs in figures.py whose ink_top.png is shown, and the width of the picture [px].
COPIES = {
    "gallery-wall": 560,
    "gallery-island": 560,
    "gallery-cylinder": 560,
    "gallery-calligraphy": 560,
    "gallery-portrait": 560,
    "gallery-tile": 560,
    "gallery-leaf": 560,
    "koi": 900,
}
# The README's first picture: runs and captions.
DRAWN = [
    ("bowl-sine", "the paper's sine"),
    ("bowl-m", "the paper's M"),
    ("koi", "artwork/koi.svg, 64 strokes"),
]
RUNS = {*COPIES, *(run for run, _ in DRAWN), "bowl-m", "bowl-m-blind"}
COMPARED = "scenarios/bowl-m.yaml"
# The film that the README opens with: of a run, at most 3 MB.
FILMED = "koi"
FILM = "--size 640x480 --fps 12 --speed 22 --colour nothing --hide cameras,normal,force".split()


def inside_frame(picture: Image.Image) -> Image.Image:
    """The part of an ink_top.png inside its frame: the region between the longest grey lines."""
    pixels = np.asarray(picture.convert("RGB")).astype(int)
    # Light grey, a little bluish; the canvas is yellowish.
    grey = (pixels.min(axis=2) > 150) & (pixels.max(axis=2) < 215)
    grey &= pixels[:, :, 2] >= pixels[:, :, 0]
    rows = np.flatnonzero(grey.mean(axis=1) > 0.6)
    columns = np.flatnonzero(grey.mean(axis=0) > 0.6)
    return picture.crop((columns[0] + 4, rows[0] + 4, columns[-1] - 4, rows[-1] - 4))


def resized(picture: Image.Image, width: int) -> Image.Image:
    height = round(picture.height * width / picture.width)
    return picture.convert("RGB").resize((width, height), Image.Resampling.LANCZOS)


# What a picture says of its run, in the words under it or in itself alone.
CAPTION = (
    "ink error <!-- figure:{0}.ink_error_rms -->0.000<!-- / --> mm RMS · "
    "force <!-- figure:{0}.force_mean -->0.00<!-- / --> ± <!-- figure:{0}.force_sd -->0.000<!-- / --> N"
)


def measured(run: str, value: Callable[[str], float]) -> str:
    """The caption with its figures, and their markers."""
    return quotes.fill(run, CAPTION.format(run), value, lambda key: "")[0]


def said(text: str) -> PngImagePlugin.PngInfo:
    """Kept in the picture, so that `figures --check` compares it as it does a document."""
    info = PngImagePlugin.PngInfo()
    info.add_itxt("figures", text)
    return info


def drawn(folder: pathlib.Path, out: pathlib.Path, value: Callable[[str], float]) -> None:
    figure = Figure(figsize=(18.64, 6.8), dpi=100, facecolor="white")
    for i, (run, caption) in enumerate(DRAWN):
        axes = figure.add_axes((i / 3 + 0.005, 0.12, 1 / 3 - 0.01, 0.87))
        axes.imshow(np.asarray(inside_frame(Image.open(folder / run / "ink_top.png"))))
        axes.axis("off")
        middle = (i + 0.5) / 3
        figure.text(middle, 0.075, caption, ha="center", size=18, weight="bold", color="#20242a")
        figure.text(
            middle,
            0.03,
            quotes.INLINE.sub(lambda m: m["text"], measured(run, value)),
            ha="center",
            size=14,
            color="#5a616b",
        )
    figure.savefig(out, pil_kwargs={"pnginfo": said("\n".join(measured(run, value) for run, _ in DRAWN))})


def make(program: str, root: pathlib.Path, folder: pathlib.Path, value: Callable[[str], float]) -> None:
    """Writes docs/images from the runs in `folder`, and runs COMPARED with and without perception. value(id): a figure of these runs."""
    images = root / "docs/images"
    for run, width in COPIES.items():
        picture = resized(Image.open(folder / run / "ink_top.png"), width)
        picture.save(images / f"{run}.png", optimize=True, pnginfo=said(measured(run, value)))
    drawn(folder, images / "drawn.png", value)
    compared = folder / "compare"
    if not (compared / "compare.png").exists():
        command = [program, "compare", COMPARED, "--out", str(compared), "--overwrite"]
        subprocess.run(command, cwd=root, check=True, capture_output=True)
    runs = ("bowl-m", "bowl-m-blind")
    Image.open(compared / "compare.png").save(images / "compare.png", optimize=True, pnginfo=said("\n".join(measured(run, value) for run in runs)))
    command = [program, "film", str(folder / FILMED), "--out", str(images / f"{FILMED}.webp"), *FILM]
    subprocess.run(command, cwd=root, check=True, capture_output=True)
