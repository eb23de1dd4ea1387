"""Pictures as lines, against coverage by nearest distances, and lines that are known."""

import io
import pathlib
import zlib

import numpy as np
import pytest
import skimage
from PIL import Image
from scipy.ndimage import gaussian_filter
from scipy.spatial import cKDTree

from impedraw.image import tones, trace
from impedraw.image.picture import Refused, read_tone, render_svg
from impedraw.image.stipple import tour

PORTRAIT = pathlib.Path(skimage.__file__).parent / "data/astronaut.png"


def ink_by_distance(strokes, shape, pen):
    """A pixel's quarter points that lie within half a pen of points along the lines."""
    points = np.vstack([np.column_stack([np.interp(np.arange(0, s[-1], 0.2), s, line[:, k]) for k in (0, 1)])
                        for line in strokes for s in [np.concatenate([[0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])]])  # fmt: skip
    y, x = np.mgrid[: 2 * shape[0], : 2 * shape[1]] / 2 + 0.25
    near = cKDTree(points).query(np.column_stack([x.ravel(), y.ravel()]), distance_upper_bound=pen / 2)[0] < pen / 2
    return near.reshape(shape[0], 2, shape[1], 2).mean((1, 3))


@pytest.mark.parametrize("style", tones.STYLES)
def test_the_ink_has_the_tone_of_a_portrait(style):
    tone = read_tone(PORTRAIT, 512)
    strokes = tones.strokes_of(tone, style, 1.4, 5000, 45.0, 1, lambda share: None)
    if style == "stipple":
        assert len(strokes) == 1 and len(strokes[0]) == 5000
    ink = gaussian_filter(ink_by_distance(strokes, tone.shape, 1.4), 10)
    assert np.corrcoef(ink.ravel(), gaussian_filter(tone, 10).ravel())[0, 1] >= 0.95


def test_a_tour_visits_every_point_and_is_short():
    points = np.random.default_rng(3).random((2000, 2))
    line = tour(points)
    assert {tuple(p) for p in line} == {tuple(p) for p in points}
    assert np.linalg.norm(np.diff(line, axis=0), axis=1).sum() < 1.15 * 0.7124 * np.sqrt(2000) + 2


def test_every_kind_of_picture_has_its_tone(tmp_path):
    ramp = np.tile(np.linspace(0, 255, 64).astype(np.uint8), (32, 1))
    grey, wanted = Image.fromarray(ramp), 1 - ramp / 255.0
    kinds = {"L.png": grey, "P.png": grey.convert("RGB").quantize(256), "cmyk.jpg": grey.convert("CMYK"), "16.png": Image.fromarray(ramp.astype(np.uint16) * 257)}
    black = Image.new("RGBA", grey.size)
    black.putalpha(Image.fromarray(255 - ramp))
    kinds["clear.png"] = black
    for name, image in kinds.items():
        image.save(tmp_path / name)
        assert np.abs(read_tone(tmp_path / name, 64) - wanted).max() < 0.06, name
    exif = Image.Exif()
    exif[0x0112] = 6
    grey.save(tmp_path / "turned.jpg", exif=exif)
    assert np.abs(read_tone(tmp_path / "turned.jpg", 64) - np.rot90(wanted, -1)).max() < 0.06


def test_what_is_broken_is_refused_in_one_line(tmp_path):
    whole = io.BytesIO()
    Image.open(PORTRAIT).save(whole, "PNG")
    (tmp_path / "cut.png").write_bytes(whole.getvalue()[:50000])
    (tmp_path / "text.png").write_text("no picture")

    def chunk(kind, data):
        return len(data).to_bytes(4, "big") + kind + data + zlib.crc32(kind + data).to_bytes(4, "big")

    size = (60000).to_bytes(4, "big")
    bomb = b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", size + size + bytes([8, 2, 0, 0, 0])) + chunk(b"IDAT", zlib.compress(bytes(10**6))) + chunk(b"IEND", b"")
    (tmp_path / "bomb.png").write_bytes(bomb)
    for name in ("cut.png", "text.png", "bomb.png"):
        with pytest.raises(Refused):
            read_tone(tmp_path / name, 512)
    (tmp_path / "cut.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg" width="4" height="4"><path')
    with pytest.raises(Refused, match="cannot be rendered: [^\\n]+$"):
        render_svg(tmp_path / "cut.svg", 512)


def test_a_curve_of_known_centre_line_is_one_stroke():
    s = np.linspace(0, 2 * np.pi, 4000)
    line = np.column_stack([40 + 50 * s, 150 + 60 * np.sin(s)])
    for width in (3, 6, 9):
        y, x = np.mgrid[:300, :400] + 0.5
        off = cKDTree(line).query(np.column_stack([x.ravel(), y.ravel()]))[0].reshape(x.shape)
        strokes = trace.centre_lines(trace.ink_of(np.clip(width / 2 - off + 0.5, 0, 1), 3))
        assert len(strokes) == 1
        assert cKDTree(line).query(strokes[0][0] / 3)[0].max() < 0.5
        assert abs(np.median(strokes[0][1]) / 3 - width) < 0.5


def nib_stroke(times, colour):
    """The outline of a nib's stroke on a page of 90 × 40 mm at that scale, 0.6 to 2.2 mm wide, with its centre line and widths."""
    s = np.linspace(0, 2 * np.pi, 2000)
    line = np.column_stack([5 + 80 * s / s[-1], 20 + 12 * np.sin(s)])
    normal = np.column_stack([-12 * np.cos(s), np.full_like(s, 80 / s[-1])])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    width = 1.4 - 0.8 * np.cos(s)
    outline = np.vstack([line + width[:, None] / 2 * normal, (line - width[:, None] / 2 * normal)[::-1]])
    path = " ".join(f"{x:.5f},{y:.5f}" for x, y in outline)
    svg = f'<svg xmlns="http://www.w3.org/2000/svg" width="{90 * times}mm" height="{40 * times}mm" viewBox="0 0 90 40"><path d="M{path}Z" fill="{colour}"/></svg>'
    return svg, line * times, width * times


@pytest.mark.parametrize("times, colour", [(1, "black"), (0.05, "yellow"), (20, "#369")])
def test_the_outline_of_a_stroke_is_its_centre_line_and_widths(tmp_path, monkeypatch, times, colour):
    from impedraw.image.__main__ import as_strokes

    monkeypatch.chdir(tmp_path)
    svg, line, width = nib_stroke(times, colour)
    (tmp_path / "nib.svg").write_text(svg)
    words = as_strokes(["draw", "--svg", "nib.svg", "--trace", "--out", "o"])
    assert words == ["draw", "--out", "o", "--svg", "runs/pictures/nib-trace.csv"]
    x, y, stroke, drawn = np.loadtxt(words[-1], delimiter=",", skiprows=1, unpack=True)
    assert not stroke.any()
    off, nearest = cKDTree(line).query(np.column_stack([x, y]))
    assert off.max() < 0.12 * times  # at the ends, which are cut straight
    inner = (nearest > 100) & (nearest < 1900)
    assert off[inner].max() < 0.06 * times
    assert np.abs(drawn - width[nearest])[inner].max() < 0.1 * times
    assert np.ptp(x) > 79 * times


def test_draws_an_image_by_its_lines(tmp_path, monkeypatch):
    from impedraw.image.__main__ import as_strokes

    monkeypatch.chdir(tmp_path)
    Image.open(PORTRAIT).resize((64, 64)).save(tmp_path / "a.png")
    words = as_strokes(["plan", "--image=a.png", "--text-like", "x", "--style", "hatch", "--size", "40", "--out", "o"])
    assert words == ["plan", "--text-like", "x", "--out", "o", "--svg", "runs/pictures/a-hatch.csv"]
    rows = (tmp_path / words[-1]).read_text().splitlines()
    assert rows[0] == "x,y,stroke" and len(rows) > 20
    assert max(float(row.split(",")[0]) for row in rows[1:]) < 40
    with pytest.raises(SystemExit) as refused:
        as_strokes(["draw", "--image", "none.png"])
    assert refused.value.code == 2
