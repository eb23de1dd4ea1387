"""Draws where a second of a command goes: docs/images/speed.svg, from samples of the processor (Linux' perf, which must be installed).

    .venv/bin/python setup/speed_picture.py [--program PROGRAM]

Draws the sine and plans the koi on a scanned surface, and counts each sample for the first of STAGES that a function on its stack is
named like. The shares are of processor time, of all threads.
"""
import argparse
import collections
import pathlib
import re
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
MESH = "build/surface-meshes/bunny.obj"
COMMANDS = {
    "draw": ["draw"],
    "plan --svg artwork/koi.svg, on a scan": ["plan", "--svg", "artwork/koi.svg", "--set", "canvas.kind=mesh", "--set",
                                              f"canvas.mesh.file={MESH}", "--set", "drawing.skip_unreachable=true"],
}  # fmt: skip
STAGES = [
    ("holes and creases", "find_holes|find_creases"),
    ("fits at the cloud's points", "fit_every_point|DetailLevels::of"),
    ("surface under the strokes", "CloudHeight|descend|PlanSurface::estimate"),
    ("images, cloud, canvas", "take_snapshot|render_depth|Canvas::|estimator_of"),
    ("postures", "JointRates|find_posture|ArmModel::|check_"),
    ("log", "RunLog|LogFile"),
    ("loop", "Executor|impedraw::run|World::"),
    ("pictures", "write_sheet|write_svg_and_png|write_ink_top"),
    ("figures and page", "write_report|make_payload|compute_metrics|LogReader|write_plan|_json|topology|distortion"),
]
COLOURS = ["#1b6ca8", "#3f8fc4", "#79b4d9", "#a9cfe5", "#e0a526", "#7a4fa3", "#b02e4c", "#3d8f5b", "#83bf95", "#cccccc"]


def shares(program, words):
    """Stage → its share of the samples."""
    with tempfile.TemporaryDirectory() as folder:
        data = pathlib.Path(folder) / "samples"
        record = ["perf", "record", "-q", "-o", data, "--call-graph", "dwarf,16384", "-F", "200", program, *words, "--out", f"{folder}/run"]
        subprocess.run(record, cwd=ROOT, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        script = ["perf", "script", "-i", data, "--no-inline", "-F", "ip,sym"]
        stacks = subprocess.run(script, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=True).stdout.split("\n\n")
    count = collections.Counter(next((name for name, like in STAGES if re.search(like, stack)), "rest") for stack in stacks if stack.strip())
    return {name: count[name] / max(1, count.total()) for name, _ in [*STAGES, ("rest", "")]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/src/app/impedraw")
    program = parser.parse_args().program
    out, y = [], 18
    for title, words in COMMANDS.items():
        found, x = shares(program, words), 0.0
        out.append(f'<text x="0" y="{y}" font-weight="bold">{title}</text>')
        for colour, share in zip(COLOURS, found.values()):
            out.append(f'<rect x="{x:.1f}" y="{y + 6}" width="{720 * share:.1f}" height="26" fill="{colour}"/>')
            if share > 0.05:
                out.append(f'<text x="{x + 4:.1f}" y="{y + 24}">{100 * share:.0f} %</text>')
            x += 720 * share
        y += 58
    for k, (name, colour) in enumerate(zip(found, COLOURS)):
        x, row = 240 * (k % 3), y + 22 * (k // 3)
        out.append(f'<rect x="{x}" y="{row - 11}" width="13" height="13" fill="{colour}"/><text x="{x + 19}" y="{row}">{name}</text>')
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 720 {row + 10}" font-family="sans-serif" font-size="13">'
    (ROOT / "docs/images/speed.svg").write_text("\n".join([head, *out, "</svg>\n"]))


main()
