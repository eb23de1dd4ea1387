"""What is drawn of small SVGs of each kind is what Chromium shows of them."""

import base64
import os
import pathlib
import shutil
import struct
import subprocess
import zlib

import pytest
import seen

PROGRAM = os.environ.get("DRAWN_STROKES", "build/release/tests/drawing/drawn_strokes")
SIDE = 120  # [mm]: at half the tool's size a kind takes half a second
RECT = "<rect x='15' y='15' width='70' height='70'"
LINES = "<path d='M0 20H100M0 50H100M0 80H100' stroke='black' fill='none'/>"

INNER = b"<svg xmlns='http://www.w3.org/2000/svg' width='20' height='20' viewBox='0 0 20 20'><circle cx='10' cy='10' r='9' fill='#6bb' stroke='black'/><path d='M2 2L18 18' stroke='red'/></svg>"


def woff(font):
    """A TrueType font as WOFF: the head, where each table lies, the tables packed."""
    count = struct.unpack(">H", font[4:6])[0]
    entries, tables, at = b"", b"", 44 + 20 * count
    for k in range(count):
        tag, checksum, offset, size = struct.unpack(">4s3I", font[12 + 16 * k : 28 + 16 * k])
        table = font[offset : offset + size]
        packed = min(zlib.compress(table), table, key=len)
        entries += tag + struct.pack(">4I", at + len(tables), len(packed), size, checksum)
        tables += packed + bytes(-len(packed) % 4)
    return struct.pack(">4s4sIHHI2H5I", b"wOFF", font[:4], at + len(tables), count, 0, len(font), 1, 0, 0, 0, 0, 0, 0) + entries + tables


def own_fonts():
    """Text in fonts that the drawing holds, one of them under the name of an installed font."""
    match = shutil.which("fc-match")
    found = subprocess.run([match, "-f", "%{file}", "DejaVu Serif:bold"], capture_output=True, text=True).stdout if match else ""
    if not found.endswith(".ttf"):
        return LINES
    font = pathlib.Path(found).read_bytes()
    data = [base64.b64encode(f).decode() for f in (font, woff(font))]
    return (
        "<style>@font-face { font-family: 'Own'; src: url(https://example.org/own.ttf), "
        f'url("data:font/ttf;base64,{data[0]}") }}\n@font-face {{ font-family: DejaVu Sans; font-weight: 400; '
        f"src: url(data:font/woff;base64,{data[1]}) format('woff') }}</style>"
        "<text x='5' y='40' font-size='22' font-family='Own'>Radij</text><text x='5' y='80' font-size='22' font-family='DejaVu Sans'>Radij</text>"
    )


KINDS = {
    "beyond the page": "<circle cx='90' cy='50' r='30' fill='#36c'/><path d='M-20 20L120 80' stroke='red'/>",
    "view box, sliced": ("viewBox='0 0 100 50' preserveAspectRatio='xMidYMid slice'", RECT + " fill='teal'/>" + LINES),
    "view box, at its edge": ("viewBox='-10 -20 200 100' preserveAspectRatio='xMaxYMin meet'", RECT + " fill='teal'/>" + LINES),
    "stretched": ("viewBox='0 0 100 50' preserveAspectRatio='none'", RECT + " rx='9' fill='none' stroke='black' stroke-width='4'/>"),
    "one colour": RECT + " fill='#262'/><circle cx='80' cy='50' r='18' fill='#262'/><circle cx='30' cy='50' r='9' fill='#262'/>",
    "stroke over an edge": RECT + " fill='orange'/><path d='M15 15H85V60' fill='none' stroke='black' stroke-width='6'/>",
    "stroke over lines": LINES + "<path d='M10 50H90' stroke='#c33' stroke-width='12' stroke-linecap='round'/>",
    "casing": "<path d='M10 50Q50 0 90 50' fill='none' stroke='black' stroke-width='14'/>"
    "<path d='M10 50Q50 0 90 50' fill='none' stroke='gold' stroke-width='9'/>",
    "area over a stroke of its colour": "<path d='M10 30H90M10 70H90' stroke='#262' stroke-width='12'/><path d='M20 10h20v80h-20z' fill='#262'/>"
    "<path d='M50 10h40v80h-40z' fill='white'/><path d='M60 20h20v60h-20z' fill='#262'/>",
    "open and filled": "<path d='M15 80L30 20 70 20 85 80' fill='#fb8' stroke='black' stroke-width='3'/>",
    "wider twin": "<path d='M10 50H90' stroke='black'/><path d='M10 50H90' stroke='black' stroke-width='9'/>",
    "nested clips": "<clipPath id='a'><circle cx='50' cy='50' r='40'/></clipPath><clipPath id='b' clip-path='url(#a)'>"
    "<rect x='30' width='70' height='100'/></clipPath><g clip-path='url(#b)'>" + LINES + RECT + " fill='#8ac'/></g>",
    "clip in the box's unit": "<clipPath id='a' clipPathUnits='objectBoundingBox'><path d='M0 0L1 0.5 0 1Z'/></clipPath>"
    + RECT + " fill='#8ac' clip-path='url(#a)'/>",
    "mask": "<mask id='m'><rect width='100' height='100' fill='white'/><circle cx='50' cy='50' r='20'/></mask>"
    "<g mask='url(#m)'>" + RECT + " fill='#484'/>" + LINES + "</g>",
    "white over lines": LINES + "<circle cx='50' cy='50' r='25' fill='white'/>",
    "white over a border": RECT + " fill='#68b'/><path d='M15 15h40v40h-40z' fill='#016'/><path d='M25 15l30 30v8L15 20v-5zM40 15h6v40h-6z' fill='white'/>",
    "paint order": LINES + RECT + " fill='#ddf' stroke='navy' stroke-width='8' paint-order='stroke'/>",
    "dashes": "<path d='M10 30H90' stroke='black' stroke-width='3' stroke-dasharray='12 5 3'/>"
    "<path d='M10 65H90' stroke='black' pathLength='9' stroke-dasharray='1 2'/>",
    "even-odd": "<path d='M50 5L79 95 3 39H97L21 95Z' fill='#933' fill-rule='evenodd'/>",
    "nonzero": "<path d='M50 5L79 95 3 39H97L21 95Z' fill='#933'/>",
    "markers": "<marker id='m' refX='5' refY='5' markerWidth='10' markerHeight='10' orient='auto'><path d='M0 0L10 5 0 10Z'/></marker>"
    "<path d='M20 80L50 20 80 80' fill='none' stroke='black' marker-mid='url(#m)' marker-end='url(#m)'/>" + RECT + " fill='none' stroke='red' marker-start='url(#m)'/>",
    "use and symbol": "<symbol id='s' viewBox='0 0 10 10'><path d='M0 0H12V12' stroke='black' fill='#6bb'/></symbol>"
    "<use href='#s' width='40' height='40' x='5' y='5'/><use href='#s' width='30' height='30' x='60' y='50' transform='rotate(9)'/>",
    "pattern": "<pattern id='p' width='12' height='12' patternUnits='userSpaceOnUse' patternTransform='rotate(20)'>"
    "<path d='M0 6H12' stroke='black'/><circle cx='4' cy='3' r='2' fill='red'/></pattern>" + RECT + " fill='url(#p)' stroke='black'/>",
    "gradient": "<linearGradient id='g'><stop stop-color='white'/><stop offset='0.3' stop-color='white'/><stop offset='1' stop-color='#024'/></linearGradient>"
    + RECT + " fill='url(#g)'/>",
    "styles": "<style>.a{stroke:#c0c;stroke-width:3;fill:none} path.a{stroke:green} #h{display:none}</style>"
    "<path class='a' d='M10 10L90 40'/><circle class='a' cx='50' cy='60' r='20'/><path id='h' class='a' d='M0 99H99'/>",
    "switch": "<switch><path systemLanguage='xx' d='M0 0H90V90'/><path d='M10 90H90V10Z' fill='#555'/></switch>",
    "opacity": LINES + RECT + " fill='#08f' opacity='0.4'/>",
    "let through": LINES + RECT + " fill='#08f' opacity='0.7'/>",
    "veil": RECT + " fill='#246'/><circle cx='60' cy='30' r='25' fill='#fff' opacity='0.4'/><path d='M20 60Q50 20 95 90' fill='none' stroke='white' stroke-width='5' stroke-opacity='0.5'/>",
    "stroke that fades": "<linearGradient id='g' gradientUnits='userSpaceOnUse' x1='0' x2='60'><stop/><stop offset='1' stop-opacity='0'/></linearGradient>"
    "<path d='M5 20L90 30' stroke='url(#g)' stroke-width='4'/>" + RECT + " fill='none' stroke='teal'/>",
    "shadow of a box": "<linearGradient id='g' x2='0' y2='1'><stop stop-opacity='0'/><stop offset='.5'/><stop offset='1' stop-opacity='0'/></linearGradient>"
    "<radialGradient id='r' gradientUnits='userSpaceOnUse' r='10'><stop/><stop offset='1' stop-opacity='0'/></radialGradient>"
    "<g opacity='.5'><path d='M20 70H80V90H20Z' fill='url(#g)'/><path d='M0 -10H10V10H0Z' transform='translate(80 80)' fill='url(#r)'/>"
    "<path d='M0 -10H10V10H0Z' transform='matrix(-1 0 0 1 20 80)' fill='url(#r)'/></g><path d='M15 20H85V75H15Z' fill='#68b'/>",
    "gradient on a gradient": "<linearGradient id='g'><stop stop-color='#036'/><stop offset='1' stop-color='#fc6'/></linearGradient>"
    "<linearGradient id='h'><stop stop-color='#fc6'/><stop offset='1' stop-color='#036'/></linearGradient>" + RECT + " fill='url(#g)'/><circle cx='50' cy='50' r='25' fill='url(#h)'/>",
    "group with opacity": "<g opacity='.5'>" + RECT + " fill='#036'/><circle cx='60' cy='50' r='25' fill='#036'/></g>",
    "multiplied": RECT + " fill='#fc6'/><circle cx='60' cy='50' r='25' fill='#fc6' style='mix-blend-mode:multiply'/>",
    "blurred within a clip": "<filter id='f' x='-2' y='-2' width='5' height='5'><feGaussianBlur stdDeviation='8'/></filter><clipPath id='c'><circle cx='50' cy='50' r='40'/></clipPath>"
    "<g clip-path='url(#c)'><rect width='100' height='100' fill='#fc6'/><circle cx='80' cy='30' r='30' fill='#036' filter='url(#f)'/></g>",
    "shadow beneath a card": "<filter id='f' x='-1' y='-1' width='3' height='3'><feGaussianBlur in='SourceAlpha' stdDeviation='3'/><feOffset dy='4'/><feMerge><feMergeNode/><feMergeNode in='SourceGraphic'/></feMerge></filter>"
    + RECT + " fill='#fc6' filter='url(#f)'/>",
    "map of one colour": "<path d='M10 10H50L60 40 45 60 52 90H10Z' fill='#262'/><path d='M50 10H90V90H52L45 60 60 40Z' fill='#262'/>",
    "label in HTML": LINES + "<foreignObject x='10' y='55' width='80' height='24'><div xmlns='http://www.w3.org/1999/xhtml' style='line-height:1.5;text-align:center;font-family:Arial'><p style='margin:0'>Label</p></div></foreignObject>",
    "alike colours": RECT + " fill='#ca353c'/><path d='M50 10H70V90Z' fill='#c9353d'/>",
    "units": ("width='1in' height='2.54cm'", "<path d='M2mm' /><line x1='5mm' y1='20%' x2='.8in' y2='12pt' stroke='black'/><circle cx='50%' cy='3pc' r='5mm'/>"),
    "fonts of its own": own_fonts(),
    "a picture that is a drawing": f"<image href='data:image/svg+xml;base64,{base64.b64encode(INNER).decode()}' x='10' y='20' width='70' height='30'/>",
    "nested pages": "<svg x='10' y='10' width='50' height='80' viewBox='0 0 10 10'>" + "<circle cx='9' cy='5' r='4' fill='#a5a'/></svg>" + LINES,
    "not scaling": ("viewBox='0 0 10 10'", "<path d='M1 1L9 5 1 9' fill='none' stroke='black' vector-effect='non-scaling-stroke' stroke-width='2'/>"),
}  # fmt: skip


@pytest.fixture(scope="module")
def all_seen(tmp_path_factory):
    if not seen.CHROMIUM:
        pytest.skip("Chromium is not installed (the package chromium, or CHROMIUM=FILE)")
    folder = tmp_path_factory.mktemp("kinds")
    files = []
    for number, kind in enumerate(KINDS.values()):
        head, body = kind if isinstance(kind, tuple) else ("viewBox='0 0 100 100'", kind)
        size = "" if "width=" in head else "width='100' height='100'"
        files.append(folder / f"{number}.svg")
        files[-1].write_text(f"<svg xmlns='http://www.w3.org/2000/svg' {size} {head}>{body}</svg>")
    return dict(zip(KINDS, seen.look(PROGRAM, files, os.environ.get("MARKED"), SIDE)))


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_seen_is_drawn(all_seen, kind):
    result = all_seen[kind]
    assert result.drawn > 20
    assert result.bare < 1e-3
    assert result.false < 1e-3
    assert result.missed < 5e-3


def test_the_measure_notices_what_is_false_and_what_is_missing(tmp_path):
    if not seen.CHROMIUM:
        pytest.skip("Chromium is not installed (the package chromium, or CHROMIUM=FILE)")
    file = pathlib.Path(tmp_path, "a.svg")
    file.write_text("<svg xmlns='http://www.w3.org/2000/svg' width='100' height='100'><path d='M10 30H90M10 60H90' stroke='black'/></svg>")
    px = 25.4 / 96
    line = lambda y: {"edge": False, "colour": 0, "width": px, "points": [[10 * px, y * px], [90 * px, y * px]]}  # noqa: E731
    picture = seen.chromiums([file], [(100, 100)], SIDE)[0]
    false = seen.compare(picture, {"page": [100 * px, 100 * px], "strokes": [line(30), line(60), line(80)]}, side=SIDE)
    assert false.false == pytest.approx(1 / 3, abs=0.01) and false.bare == pytest.approx(1 / 3, abs=0.01) and false.missed == 0
    missed = seen.compare(picture, {"page": [100 * px, 100 * px], "strokes": [line(30)]}, side=SIDE)
    assert missed.false == 0 and missed.missed == pytest.approx(0.5, abs=0.02)
