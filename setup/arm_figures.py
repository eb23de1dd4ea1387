"""Draws sine, M and text with each arm of models/arms on the bowl that --place auto puts, and writes the table of docs/arms-by-urdf.md.

Usage: python3 setup/arm_figures.py PROGRAM FOLDER
"""
import json
import pathlib
import subprocess
import sys

from quotes import fill_part

ROOT = pathlib.Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/arms-by-urdf.md"
TITLES = {"iiwa14": "KUKA iiwa 14", "iiwa7": "KUKA iiwa 7", "fr3": "Franka FR3", "panda": "Franka Panda", "ur5e": "UR5e", "gen3": "Kinova Gen3"}
DRAWINGS = {
    "sine": ["scenarios/bowl-sine.yaml"],
    "M": ["scenarios/bowl-m.yaml"],
    "text": ["scenarios/bowl-sine.yaml", "--text", "robot"],
}


def main():
    program, out = sys.argv[1], pathlib.Path(sys.argv[2])
    out.mkdir(parents=True, exist_ok=True)
    lines = [
        "| arm | drawing | contact | ink RMS, max [mm] | force mean ± SD [N] | touchdown [N] | least distance to a joint limit [rad] | largest joint speed of its limit |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for arm, title in TITLES.items():
        urdf = out / f"{arm}_pen.urdf"
        subprocess.run([program, "arm", "make-urdf", "--arm", arm, "--out", urdf], check=True, stdout=subprocess.DEVNULL)
        for drawing, arguments in DRAWINGS.items():
            folder = out / f"{arm}-{drawing}"
            run = subprocess.run(
                [program, "draw", *arguments, "--place", "auto", "--set", f"arm.urdf={urdf}", "--out", folder, "--overwrite"],
                cwd=ROOT, capture_output=True, text=True,
            )  # fmt: skip
            if run.returncode:
                sys.exit(f"{arm}, {drawing}: {run.stderr.strip()}")
            m = json.loads((folder / "metrics.json").read_text())
            m = {k: v["value"] if isinstance(v, dict) and "value" in v else v for k, v in m.get("metrics", m).items()}
            lines.append(
                f"| {title} | {drawing} | {m['contact_fraction']:.4f} | {m['ink_error_rms']:.3f}, {m['ink_error_max']:.2f} "
                f"| {m['force_mean']:.3f} ± {m['force_sd']:.3f} | {m['touchdown_peak']:.2f} | {m['joint_margin_min']:.2f} | {m['joint_speed_share_max']:.2f} |"
            )
            print(lines[-1], flush=True)
    fill_part(PAGE, "arms", lines)


if __name__ == "__main__":
    main()
