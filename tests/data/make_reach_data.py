"""What ./impedraw reach draws and draws on that no package ships: made here, by these few lines.

Writes, into this folder, hilbert.strokes, spiral.csv and flower_tile.obj, and into artwork/ leaf.svg, compass.svg, island.svg and
calligraphy.csv. Run it again after a change: `python3 tests/data/make_reach_data.py`. It needs the standard library, and Debian's
hershey-fonts-data.
"""

import math
import random
from pathlib import Path

HERE = Path(__file__).parent
ARTWORK = HERE.parents[1] / "artwork"
LICENCE = "Own work, made by tests/data/make_reach_data.py, Apache-2.0 like the rest of this repository. One unit is a millimetre."


def hilbert(order):
    """Cells of the curve, in order."""
    side = 1 << order
    for d in range(side * side):
        x = y = 0
        t, s = d, 1
        while s < side:
            rx = 1 & (t // 2)
            ry = 1 & (t ^ rx)
            if ry == 0:
                if rx == 1:
                    x, y = s - 1 - x, s - 1 - y
                x, y = y, x
            x, y = x + s * rx, y + s * ry
            t //= 4
            s *= 2
        yield x, y


def write_hilbert():
    points = "\n".join(f"{10 * x + 5} {10 * y + 5}" for x, y in hilbert(4))
    (HERE / "hilbert.strokes").write_text(f"160 160\n{points}\nEnd\n")


def write_spiral():
    rows = []
    for arm in range(2):
        for i in range(361):
            t = i / 360
            angle, r = 2 * math.pi * (3.5 * t + arm / 2), 8 + 72 * t
            rows.append(f"{arm},{r * math.cos(angle):.2f},{r * math.sin(angle):.2f}")
    (HERE / "spiral.csv").write_text("stroke,x,y\n" + "\n".join(rows) + "\n")


def write_tile():
    """300 × 300 mm, 7.5 mm a cell: six petals of up to 18 mm around a hollow, heights in mm, z up."""
    cells, cell = 40, 7.5
    lines = ["# A relief tile, six petals, in mm. " + LICENCE]
    for j in range(cells + 1):
        for i in range(cells + 1):
            x, y = cell * (i - cells / 2), cell * (j - cells / 2)
            r, angle = math.hypot(x, y), math.atan2(y, x)
            ring = math.exp(-(((r - 85) / 45) ** 2))
            z = ring * (10 + 8 * math.cos(6 * angle) * min(1, (r / 80) ** 2))
            lines.append(f"v {x:g} {y:g} {z:.3f}")
    for j in range(cells):
        for i in range(cells):
            a = j * (cells + 1) + i + 1
            lines.append(f"f {a} {a + 1} {a + cells + 2} {a + cells + 1}")
    (HERE / "flower_tile.obj").write_text("\n".join(lines) + "\n")


def svg(name, what, body):
    (ARTWORK / name).write_text(
        f'<?xml version="1.0" encoding="UTF-8"?>\n<!-- {what} {LICENCE} -->\n'
        '<svg xmlns="http://www.w3.org/2000/svg" width="200mm" height="200mm" viewBox="-100 -100 200 200" fill="none" stroke="#1c2a3a">\n'
        + body + "</svg>\n")


def path(points, closed=False, extra=""):
    text = "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points) + ("Z" if closed else "")
    return f'  <path d="{text}"{extra}/>\n'


def write_leaf():
    body = ('  <path id="blade" fill="#3b7a57" stroke="none" d="M0 -92C58 -58 66 22 0 84C-66 22 -58 -58 0 -92Z"/>\n'
            '  <path id="stalk" d="M0 84C2 90 6 95 14 98"/>\n')
    for i in range(5):
        y = 56 - 26 * i
        for side in (-1, 1):
            body += f'  <path d="M0 {y}Q{16 * side} {y - 6} {30 * side} {y - 24}"/>\n'
    svg("leaf.svg", "A leaf: its blade is filled, to be hatched.", body)


def write_compass():
    body = ""
    for r, dash in ((92, "40 15"), (70, "24 20"), (46, "30 8 10 8")):
        body += f'  <circle r="{r}" stroke-dasharray="{dash}"/>\n'
    for i in range(8):
        c, s = math.cos(math.pi * i / 4), math.sin(math.pi * i / 4)
        dash = "" if i % 2 == 0 else ' stroke-dasharray="24 10"'
        body += f'  <path d="M{20 * c:.2f} {20 * s:.2f}L{96 * c:.2f} {96 * s:.2f}"{dash}/>\n'
    body += '  <circle r="12"/>\n'
    svg("compass.svg", "A compass rose of dashed lines.", body)


def ring(radius, rough, seed, points=120):
    """A closed line about the origin: a few random harmonics."""
    generator = random.Random(seed)
    waves = [(k, rough * generator.uniform(0.4, 1) / k, generator.uniform(0, 2 * math.pi)) for k in range(2, 8)]
    for i in range(points):
        a = 2 * math.pi * i / points
        r = radius * (1 + sum(h * math.cos(k * a + p) for k, h, p in waves))
        yield r * math.cos(a), 0.8 * r * math.sin(a)


def write_island():
    """A map in layers: two coasts, contours, a river, a dashed road, towns as dots."""
    body = '<g id="coast">\n' + path(ring(78, 0.22, 7), True)
    body += path([(x * 0.14 + 70, y * 0.14 - 68) for x, y in ring(90, 0.3, 3, 40)], True) + '</g>\n<g id="contours">\n'
    for radius, seed in ((52, 7), (34, 8), (16, 9)):
        body += path([(x + 6, y - 4) for x, y in ring(radius, 0.18, seed, 90)], True)
    body += '</g>\n<g id="river">\n  <path d="M8 -6C-4 6 4 18 -10 24S-18 44 -30 52"/>\n</g>\n'
    body += '<g id="road">\n  <path stroke-dasharray="6 3" d="M-52 -20C-30 -34 -8 -30 10 -22S44 -2 50 22"/>\n</g>\n<g id="towns" stroke-linecap="round">\n'
    for x, y in ((-52, -20), (10, -22), (50, 22), (-28, 40)):
        body += f'  <circle cx="{x}" cy="{y}" r="3"/>\n'
    svg("island.svg", "A map of an island that there is not, in five layers.", body + "</g>\n")


def hershey(font, letter):
    """Left end, right end and strokes of a letter, y down, in the units of the font."""
    records = Path(f"/usr/share/hershey-fonts/{font}.jhf").read_text().splitlines()
    record = records[ord(letter) - 32]
    left, right = (ord(c) - ord("R") for c in record[8:10])
    points = record[10:]
    strokes = [[(ord(s[i]) - ord("R"), ord(s[i + 1]) - ord("R")) for i in range(0, len(s) - 1, 2)] for s in points.split(" R")]
    return left, right, [s for s in strokes if len(s) > 1]


def rounded(points, pieces=6):
    """Catmull and Rom's curve through the points."""
    ends = [points[0], *points, points[-1]]
    yield points[0]
    for p0, p1, p2, p3 in zip(ends, ends[1:], ends[2:], ends[3:]):
        for i in range(1, pieces + 1):
            t = i / pieces
            yield tuple(
                0.5 * (2 * b + (c - a) * t + (2 * a - 5 * b + 4 * c - d) * t * t + (3 * b - a - 3 * c + d) * t**3)
                for a, b, c, d in zip(p0, p1, p2, p3))


def write_calligraphy():
    """Two lines of handwriting as a broad nib writes them: held at 40°, it draws wide down to the right and thin up to the right."""
    rows, stroke = [], 0
    for line, text in enumerate(("drawn by", "an arm")):
        letters = [hershey("scripts", c) for c in text]
        x = -sum(right - left for left, right, _ in letters) / 2
        for left, right, strokes in letters:
            for points in strokes:
                curve = list(rounded(points))
                for i, (px, py) in enumerate(curve):
                    a, b = curve[max(i - 1, 0)], curve[min(i + 1, len(curve) - 1)]
                    nib = abs(math.sin(math.atan2(a[1] - b[1], b[0] - a[0]) - math.radians(40)))
                    rows.append(f"{stroke},{px + x - left:.2f},{py + 30 * line:.2f},{0.2 + 0.6 * nib:.2f}")
                stroke += 1
            x += right - left
    (ARTWORK / "calligraphy.csv").write_text(f"# Handwriting with the widths of a broad nib. {LICENCE}\nstroke,x,y,width\n" + "\n".join(rows) + "\n")


write_hilbert()
write_spiral()
write_calligraphy()
write_tile()
write_leaf()
write_compass()
write_island()
