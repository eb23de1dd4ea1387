"""Kills and power cuts at random instants of draw, --resume, report and plan; nothing may be lost but the seconds allowed.

    soak.py IMPEDRAW RECORD_IO.so [--kills N] [--seed S]

Each round runs one command in a run's folder and ends it: by a signal, or by a power cut as in tests/log/power_cut/replay.py.
After it, what the folder holds must be what a user can go on with:
- the log is whole, and no step that was on the disk is gone: a kill loses no more than the steps that a power cut may lose;
- results are whole or absent; nothing is left in the folder for temporary files;
- the next command goes on. At the end, --resume finishes the drawing, with ink on all of it.
"""

import argparse
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import h5py

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "log/power_cut"))
from replay import Disk, read_trace  # noqa: E402

MOST_LOST = 4096 + 300  # steps
SVG = """<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="60mm" viewBox="0 0 60 60">
<path d="M5 5H55V20H5V35H55V50H5" fill="none" stroke="black"/></svg>"""
SIGNALS = [signal.SIGKILL, signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT, signal.SIGSEGV]
# SIGQUIT is the emergency stop: the run ends as stopped.
POLITE = {signal.SIGTERM: 143, signal.SIGINT: 130, signal.SIGHUP: 129, signal.SIGQUIT: 3}
WHOLE = {"metrics.json": b"}\n", "report.html": b"</html>\n", "ink_top.svg": b"</svg>\n", "ink_page.svg": b"</svg>\n",
         "strokes.json": b"}\n", "ink_top.png": b"IEND\xaeB`\x82", "ink_page.png": b"IEND\xaeB`\x82", "plan.json": b"}\n"}


class Failure(Exception):
    pass


class Soak:
    def __init__(self, program, shim, seed, scratch):
        self.program, self.shim, self.scratch = program, shim, scratch
        self.rng = random.Random(seed)
        self.run = scratch / "run"
        self.tmp = scratch / "tmp"
        self.tmp.mkdir()
        (scratch / "drawing.svg").write_text(SVG)
        self.environment = dict(os.environ, TMPDIR=str(self.tmp))
        self.kept = 0  # steps that the log has for certain
        self.counts = {}

    def command(self, name):
        # Slow enough that a run takes some seconds.
        draw = ["draw", "--svg", "drawing.svg", "--out", "run", "--set", "path.draw_speed=0.004",
                "--set", "drawing.placement.fit_width=0.06"]
        return [str(self.program)] + {"draw": draw + ["--overwrite"], "resume": draw + ["--resume"], "report": ["report", "run"],
                                      "plan": ["plan", "--svg", "drawing.svg", "--out", "plan"]}[name]

    def start(self, name, trace=None):
        environment = self.environment
        if trace:
            environment = dict(environment, LD_PRELOAD=str(self.shim), RECORD_IO_FOLDER=str(self.run), RECORD_IO_TRACE=str(trace))
        return subprocess.Popen(self.command(name), cwd=self.scratch, env=environment, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.PIPE)

    def journal_steps(self, folder):
        """Steps in the log and its journal, whether synced or not: the records' heads are counted."""
        log, journal = folder / "run.h5", folder / "run.journal"
        steps = log_steps(log)
        if not journal.exists():
            return steps
        data, at, tables, more = journal.read_bytes(), 0, 1, 0
        while at + 56 <= len(data) and data[at:at + 4] == b"IRJ1":
            kind = int.from_bytes(data[at + 24:at + 28], "little")
            rows = int.from_bytes(data[at + 40:at + 48], "little")
            size = int.from_bytes(data[at + 48:at + 56], "little")
            if kind == 0xFFFFFFFF:
                text = data[at + 56:at + 56 + size].decode()
                log_id = float(text.split()[1])
                with h5py.File(log) as f:
                    if f.attrs["log_id"] != log_id:
                        return steps  # of a log that has been replaced
                tables = text.count("table ")
            elif kind == tables - 1:
                more += rows
            at += 56 + size
        return steps + more

    def round(self, number):
        begun = (self.run / "run.h5").exists()
        name = self.rng.choice(["draw", "resume", "resume", "resume", "resume", "report", "plan"] if begun else ["draw", "resume"])
        power_cut = name != "plan" and self.rng.random() < 0.35
        after = self.rng.uniform(0, 4) if name in ("draw", "resume") else self.rng.uniform(0, 2)
        kill = signal.SIGKILL if power_cut else self.rng.choice(SIGNALS)
        what = f"round {number}: {name}, {'power cut' if power_cut else signal.Signals(kill).name} after {after:.2f} s"
        self.counts[name] = self.counts.get(name, 0) + 1
        before = self.scratch / "before"
        shutil.rmtree(before, ignore_errors=True)
        if self.run.exists():
            shutil.copytree(self.run, before, symlinks=True)
        trace = self.scratch / "trace" if power_cut else None
        if trace:
            trace.unlink(missing_ok=True)
        start = Disk(self.run) if power_cut and self.run.exists() else Disk()
        fresh_id = log_id(self.run)
        process = self.start(name, trace)
        try:
            out, err = process.communicate(timeout=after)
            ended = True
        except subprocess.TimeoutExpired:
            process.send_signal(kill)
            ended = False
            out, err = process.communicate(timeout=120)
        try:
            self.check_end(name, process.returncode, None if ended else kill, out, err)
            reached = self.journal_steps(self.run) if (self.run / "run.h5").exists() else 0
            if log_id(self.run) != fresh_id and name == "draw":
                self.kept = 0  # another run has begun
            if power_cut and trace.exists():
                # Somewhere in the last second, or anywhere.
                steps = list(read_trace(trace))
                until = self.rng.choice([len(steps), self.rng.randint(0, len(steps))])
                for step in steps[:until]:
                    start.do(*step)
                shutil.rmtree(self.run, ignore_errors=True)
                start.write(self.run, None)
                reached = self.journal_steps(self.run) if (self.run / "run.h5").exists() else 0
                new = log_id(self.run)
                shutil.rmtree(self.run)
                start.write(self.run, random.Random(self.rng.random()))
                if not any(self.run.iterdir()):
                    self.run.rmdir()
                if name == "draw" and log_id(self.run) != fresh_id:
                    self.kept = 0
                if log_id(self.run) != new:
                    reached = self.kept
            if name != "plan":
                self.check_folder(max(self.kept, reached - MOST_LOST))
            for file, end in WHOLE.items():
                for folder in ("run", "plan"):
                    path = self.scratch / folder / file
                    # Results older than a cut may lack their last sync: they are whole or absent all the same.
                    if path.exists() and not path.read_bytes().endswith(end):
                        raise Failure(f"{path.name} is not whole")
            left = [p.name for p in self.tmp.iterdir()]
            if left:
                raise Failure(f"left in the folder for temporary files: {left}")
        except Failure as failure:
            raise Failure(f"{what}: {failure}") from None

    def check_end(self, name, code, kill, out, err):
        allowed = {0, 1} if name == "plan" else {0}
        if kill is not None:
            allowed = allowed | {-kill, POLITE.get(kill, -kill)}
        if code not in allowed:
            raise Failure(f"ended with {code}: {err}")
        if "Traceback" in err or "Error" in err or any(len(line) > 600 for line in err.splitlines()):
            raise Failure(f"said {err}")

    def check_folder(self, least):
        if not (self.run / "run.h5").exists():
            if least > 0:
                raise Failure(f"no log; at least {least} steps were on the disk")
            return
        # What `report` finds is what is kept.
        report = subprocess.run(self.command("report"), cwd=self.scratch, env=self.environment, capture_output=True, text=True)
        steps = log_steps(self.run / "run.h5")
        if report.returncode != 0:
            raise Failure(f"report ends with {report.returncode}: {report.stderr}")
        if steps < least:
            raise Failure(f"{steps} steps are left of at least {least}")
        json.loads((self.run / "metrics.json").read_text())
        left = sorted(p.name for p in self.run.iterdir() if p.name.startswith(".impedraw") or p.name == "run.journal")
        if left:
            raise Failure(f"left in the run's folder: {left}")
        self.kept = steps

    def finish(self):
        resumed = subprocess.run(self.command("resume"), cwd=self.scratch, env=self.environment, capture_output=True, text=True)
        if resumed.returncode != 0:
            raise Failure(f"the last --resume ends with {resumed.returncode}: {resumed.stderr}")
        if log_steps(self.run / "run.h5") < self.kept:
            raise Failure("the last --resume lost steps")
        metrics = json.loads((self.run / "metrics.json").read_text())
        if metrics["coverage"] != 1.0 or metrics["strokes_missed"] != 0:
            raise Failure(f"the drawing is not whole: coverage {metrics['coverage']}")
        with h5py.File(self.run / "run.h5") as f:
            times = f["every_step/time"][:]
            if not (times[1:] > times[:-1]).all():
                raise Failure("times do not increase")


def log_steps(log):
    with h5py.File(log) as f:
        return len(f["every_step/time"])


def log_id(folder):
    try:
        with h5py.File(folder / "run.h5") as f:
            return f.attrs["log_id"]
    except OSError:
        return None


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("program", type=Path)
    parser.add_argument("shim", type=Path)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--seed", type=int, default=random.SystemRandom().randrange(10**9))
    options = parser.parse_args()
    print(f"seed {options.seed}, {options.kills} kills", flush=True)
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as scratch:
        soak = Soak(options.program.resolve(), options.shim.resolve(), options.seed, Path(scratch).resolve())
        try:
            for number in range(options.kills):
                soak.round(number)
                if (number + 1) % 20 == 0:
                    spent = time.monotonic() - began
                    left = spent * (options.kills - number - 1) / (number + 1)
                    print(f"{number + 1} of {options.kills} kills, {left / 60:.0f} min left", flush=True)
            soak.finish()
        except Failure as failure:
            print(f"soak: seed {options.seed}: {failure}", file=sys.stderr)
            sys.exit(1)
    print(f"{options.kills} kills, {soak.counts}, in {time.monotonic() - began:.0f} s; nothing was lost")


main()
