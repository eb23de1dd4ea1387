"""The tables that `./impedraw figures` fills in. Each is a function from figures to Markdown."""
import shlex
from typing import Callable

import quotes

SHAPES = ("sine", "m")
STANDARD = [f"bowl-{s}{kind}" for kind in ("", "-natural", "-blind") for s in SHAPES]
DRAWINGS = "koi koi-blind".split()
GALLERY = "gallery-wall gallery-island gallery-cylinder gallery-text gallery-calligraphy gallery-tile gallery-leaf gallery-portrait".split()

# A metric, its decimals, its label in tables.
METRICS = [
    ("contact_fraction", 3, "`contact_fraction`"),
    ("strokes_missed", 0, "`strokes_missed`"),
    ("ink_up", 2, "`ink_up` [mm]"),
    ("ink_error_rms", 3, "`ink_error_rms` [mm]"),
    ("ink_error_max", 2, "`ink_error_max` [mm]"),
    ("coverage", 3, "`coverage`"),
    ("force_mean", 3, "`force_mean` [N], 5 asked"),
    ("force_sd", 3, "`force_sd` [N]"),
    ("touchdown_peak", 2, "`touchdown_peak` [N]"),
    ("tilt_mean", 3, "`tilt_mean` [deg]"),
    ("tilt_max", 2, "`tilt_max` [deg]"),
    ("speed_mean", 1, "`speed_mean` [mm/s]"),
]

SWITCHES = {
    "bowl-sine": "the standard sine",
    "bowl-sine-plane": "the paper's normals: a plane through neighbours of equal weight",
    "noise": "1 mm of depth noise at 1 m",
    "noise-wide": "the same, a 6 mm voxel, 120 neighbours",
    "fast": "200 mm/s, 5 m/s²",
    "bowl-sine-natural": "no wrench, natural inertia",
    "natural-foreseen": "the same, tip friction 0.3 fed forward",
    "natural-dry-friction": "no wrench, 0.1 Nm of dry friction in every joint",
    "bowl-sine-realistic": "realistic",
    "realistic-unobserved": "realistic, observer off",
    "bowl-sine10": "the paper's ten set-points, joined by straight lines",
}

SPRINGS = {
    "bowl-sine-elastic@worst": "sine",
    "bowl-m-elastic@worst": "M",
    "elastic-untold": "sine, told neither springs nor rotors (one seed)",
    "elastic-fr3": "sine, the FR3's springs, rotors and loop under the iiwa's links, 0.5 Nm of dry friction (one seed)",
    "elastic-harmonic-drive": "the same with a harmonic-drive cobot's springs and rotors, no torque loop, read on the links' side",
}

ROTORS = {
    **{f"{s}-rotors-{t}-as-{m}@worst": f"{w}, rotors of {t} kg m², told {m}"
       for t, models in ((0.1, (0.08, 0.12)), (0.3, (0.24, 0.36))) for m in models for s, w in (("sine", "sine"), ("m", "M"))},
    **{f"{s}-geared-as-{m}@worst": f"{w}, rotors of 0.1 kg m², told {m}, and the rest of a geared arm"
       for m in (0.08, 0.12) for s, w in (("sine", "sine"), ("m", "M"))},
}  # fmt: skip

DISTURBED = ["bowl-sine-real", "bowl-m-real", "bowl-sine-velocity-noise", "bowl-sine-slow-torque",
             "bowl-sine-slow-torque-200", "bowl-sine-unknown", "bowl-m-unknown", "bowl-sine-touch",
             "bowl-m-touch", "bowl-sine-touch-noise", "bowl-m-touch-noise"]


class Tables:
    """figure(id): the entry in figures.json, or None. bounds: bounds.json."""

    def __init__(self, figure: Callable[[str], dict | None], bounds: dict, commands: dict[str, str]):
        self.figure, self.bounds, self.commands = figure, bounds, commands

    def __call__(self, name: str) -> str:
        if name not in TABLES:
            raise KeyError("tables are " + ", ".join(TABLES))
        return "".join("| " + " | ".join(row) + " |\n" for row in TABLES[name](self))

    def number(self, key: str, decimals: int) -> str:
        entry = self.figure(key)
        return f"{entry['value']:.{decimals}f}" if entry else "–"

    def pair(self, kind: str, metric: str, decimals: int) -> str:
        return " / ".join(self.number(f"bowl-{s}{kind}.{metric}", decimals) for s in SHAPES)

    def promised(self, run: str, metric: str) -> str:
        low, high = self.bounds["runs"][run]["bounds"][metric]["promised"]
        if low is None:
            return "–" if high is None else f"≤ {high:g}"
        if high is None:
            return f"≥ {low:g}"
        return f"{low:g}" if low == high else f"{low:g} to {high:g}"

    def promised_pair(self, kind: str, metric: str) -> str:
        both = [self.promised(f"bowl-{s}{kind}", metric) for s in SHAPES]
        return both[0] if both[0] == both[1] else " / ".join(both)

    def lines(self, runs: dict[str, str], columns: str) -> list[list[str]]:
        """One row per run. columns: METRIC:DECIMALS …"""
        asked = [c.split(":") for c in columns.split()]
        return [[words, *(self.number(f"{run}.{m}", int(d)) for m, d in asked)]
                for run, words in runs.items()]


def head(*cells: str) -> list[list[str]]:
    return [list(cells), ["---"] * len(cells)]


def readme(t: Tables) -> list[list[str]]:
    """Five rows against one baseline."""
    kinds = ["", "-realistic", "-blind"]

    def force(kind):
        return " / ".join(f"{t.number(f'bowl-{s}{kind}.force_mean', 2)} ± "
                          f"{t.number(f'bowl-{s}{kind}.force_sd', 2)}" for s in SHAPES)

    rows = head("sine / M", "ideal model and sensing", "realistic sensing and model errors",
                "baseline: no perception")
    for words, metric, decimals in [("ink error, RMS [mm]", "ink_error_rms", 3),
                                    ("ink error, largest [mm]", "ink_error_max", 2),
                                    ("share of the line that is covered", "coverage", 3),
                                    ("touchdown peak [N]", "touchdown_peak", 1),
                                    ("pen tilt, mean [deg]", "tilt_mean", 2)]:
        rows.append([words, *(t.pair(kind, metric, decimals) for kind in kinds)])
    rows.insert(5, ["force, 5 N asked: mean ± SD [N]", *map(force, kinds)])
    return rows


def standard(t: Tables) -> list[list[str]]:
    rows = head("sine / M", "true wrench", "limit", "no wrench", "limit", "no perception", "limit")
    for metric, decimals, words in METRICS:
        rows.append([words])
        for kind in ("", "-natural", "-blind"):
            rows[-1] += [t.pair(kind, metric, decimals), t.promised_pair(kind, metric)]
    return rows


def realistic(t: Tables) -> list[list[str]]:
    rows = head("sine / M", "ideal sensor", "limit", "realistic, seed 1", "worst of 5 seeds", "limit")
    for metric, decimals, words in METRICS:
        rows.append([words, t.pair("-sensor", metric, decimals), t.promised_pair("-sensor", metric),
                     t.pair("-realistic", metric, decimals),
                     t.pair("-realistic@worst", metric, decimals),
                     t.promised_pair("-realistic", metric)])
    return rows


def disturbed(t: Tables) -> list[list[str]]:
    """The worst of five seeds of each scenario that lacks something, with its limit beneath."""
    rows = head("worst of seeds 1 to 5", "contact", "RMS [mm]", "max [mm]", "coverage", "force [N]",
                "SD [N]", "touchdown [N]", "speed [mm/s]", "time scale")
    columns = [("contact_fraction", 3), ("ink_error_rms", 3), ("ink_error_max", 2), ("coverage", 3),
               ("force_mean", 2), ("force_sd", 3), ("touchdown_peak", 2), ("speed_mean", 1), ("time_scale_mean", 3)]
    for run in DISTURBED:
        measured = t.bounds["runs"][run]["bounds"]
        rows.append([f"`{run}`", *(t.number(f"{run}@worst.{m}", d) for m, d in columns)])
        rows.append(["limit", *(t.promised(run, m) if m in measured else "–" for m, _ in columns)])
    return rows


def seeds(t: Tables) -> list[list[str]]:
    all_seeds = t.bounds["runs"]["bowl-sine-realistic"]["seeds"]
    rows = head("sine / M", *(f"seed {s}" for s in all_seeds))
    for metric, decimals, words in METRICS:
        if metric not in ("strokes_missed", "ink_up"):
            rows.append([words, *(t.pair(f"-realistic@{s}", metric, decimals) for s in all_seeds)])
    return rows


def switches(t: Tables) -> list[list[str]]:
    return head("", "RMS [mm]", "max [mm]", "coverage", "force [N]", "SD [N]", "touchdown [N]", "tilt [deg]",
                "normal error [deg]") + t.lines(
        SWITCHES, "ink_error_rms:3 ink_error_max:2 coverage:3 force_mean:3 force_sd:3 touchdown_peak:2 "
                  "tilt_mean:3 normal_error_mean:3")


def drawings(t: Tables) -> list[list[str]]:
    runs = {run: f"`{t.commands[run]}`" for run in DRAWINGS + GALLERY}
    return head("", "RMS [mm]", "max [mm]", "coverage", "ink up [mm]", "force [N]", "SD [N]",
                "tilt, max [deg]") + t.lines(
        runs, "ink_error_rms:3 ink_error_max:2 coverage:3 ink_up:1 force_mean:3 force_sd:3 tilt_max:2")


def speeds(t: Tables) -> list[list[str]]:
    rows = head("", "median of 7", "slowest", "machine")
    for run in STANDARD:
        median, slowest = (t.figure(f"{run}.real_time_factor_{w}") for w in ("median", "slowest"))
        rows.append([f"`{run}`", quotes.sized(median["value"]), quotes.sized(slowest["value"]),
                     median["machine"]] if median and slowest else [f"`{run}`", "–", "–", "–"])
    return rows


def springs(t: Tables) -> list[list[str]]:
    return head("", "ink RMS [mm]", "force SD [N]", "coverage", "contact") + t.lines(
        SPRINGS, "ink_error_rms:3 force_sd:3 coverage:3 contact_fraction:3")


def rotors(t: Tables) -> list[list[str]]:
    return head("", "ink RMS [mm]", "force SD [N]", "coverage", "contact") + t.lines(
        ROTORS, "ink_error_rms:3 force_sd:3 coverage:3 contact_fraction:3")


TABLES = {f.__name__: f for f in (springs, rotors, readme, standard, realistic, disturbed, seeds, switches, drawings, speeds)}
