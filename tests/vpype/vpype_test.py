"""Strokes are joined and ordered at least as well as by vpype's linemerge and linesort, and no length is lost."""

import json
import os
import random
import subprocess

import numpy as np
import pytest

vpype = pytest.importorskip("vpype", reason="vpype has no release for this Python")
vpype_cli = pytest.importorskip("vpype_cli")

PROGRAM = os.environ.get("DRAWN_STROKES", "build/release/tests/drawing/drawn_strokes")
PX = 96 / 25.4  # vpype's units per mm


def svg(lines, size=200):
    paths = "".join("<path d='M" + "L".join(f"{x:.4f} {y:.4f}" for x, y in line) + "'/>" for line in lines)
    return f"<svg xmlns='http://www.w3.org/2000/svg' width='{size}mm' height='{size}mm' viewBox='0 0 {size} {size}'><g fill='none' stroke='black' stroke-width='0.3'>{paths}</g></svg>"


def streets(seed, n=12, spacing=15.0):
    """The segments between crossings of a bent grid, some left out, each either way round, in no order: a map from a GIS."""
    rng = random.Random(seed)
    node = {(i, j): (10 + spacing * (i + rng.uniform(-0.3, 0.3)), 10 + spacing * (j + rng.uniform(-0.3, 0.3))) for i in range(n) for j in range(n)}
    pairs = [((i, j), (i + a, j + b)) for i in range(n) for j in range(n) for a, b in ((1, 0), (0, 1)) if (i + a, j + b) in node]
    lines = [[node[p], node[q]][:: rng.choice((1, -1))] for p, q in pairs if rng.random() < 0.8]
    rng.shuffle(lines)
    return lines


def chains(seed, count=40, pieces=12):
    """Lines of a CAD file that were cut into pieces."""
    rng = random.Random(seed)
    lines = []
    for _ in range(count):
        x, y, a = rng.uniform(20, 180), rng.uniform(20, 180), rng.uniform(0, 6.3)
        for _ in range(pieces):
            a += rng.uniform(-0.5, 0.5)
            # The page ends nothing: what leaves it would be clipped.
            nx, ny = min(195, max(5, x + 4 * np.cos(a))), min(195, max(5, y + 4 * np.sin(a)))
            if abs(nx - x) + abs(ny - y) > 0.5:
                lines.append([(x, y), (nx, ny)][:: rng.choice((1, -1))])
            x, y = nx, ny
    rng.shuffle(lines)
    return lines


def apart(seed, count=300):
    rng = random.Random(seed)
    return [[(x, y), (x + rng.uniform(-8, 8), y + rng.uniform(-8, 8))] for x, y in ((rng.uniform(10, 190), rng.uniform(10, 190)) for _ in range(count))]


def figures(lines):
    """Count, length and way in the air of lines of complex points."""
    down = sum(np.abs(np.diff(line)).sum() for line in lines)
    air = sum(abs(b[0] - a[-1]) for a, b in zip(lines, lines[1:]))
    return len(lines), down, air


def ours(path):
    done = subprocess.run([PROGRAM, "--ordered", path], capture_output=True, text=True, check=True)
    strokes = json.loads(done.stdout)["strokes"]
    return figures([np.array([complex(*p) for p in s["points"]]) for s in strokes])


def theirs(path):
    document = vpype_cli.execute(f"read '{path}' linemerge --tolerance 0.05mm linesort --two-opt")
    return figures([line / PX for layer in document.layers.values() for line in layer])


@pytest.mark.parametrize("kind", [streets, chains, apart])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_joined_and_ordered_as_well(kind, seed, tmp_path):
    path = tmp_path / f"{kind.__name__}-{seed}.svg"
    lines = kind(seed)
    path.write_text(svg(lines))
    asked = figures([np.array([complex(*p) for p in line]) for line in lines])[1]
    (count, down, air), (their_count, their_down, their_air) = ours(path), theirs(path)
    assert down == pytest.approx(asked, rel=2e-3) and down == pytest.approx(their_down, rel=2e-3)
    assert count <= their_count
    assert air <= their_air
