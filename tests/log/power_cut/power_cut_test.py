"""Power cuts at random instants of three runs into one log: at most 4,096 steps (4 s) are lost, and the log goes on.

    power_cut_test.py MADE_UP_LOG RECORD_IO.so [CUTS [SEED]]

The seed of each cut is printed if it fails; `power_cut_test.py … 1 SEED` repeats it on a new record.
"""

import os
import random
import subprocess
import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
from replay import Disk, read_trace  # noqa: E402

MOST_LOST = 4096 + 300  # steps; a mark is made every 100, and a reduced log settles its rows every 128
RUN_1 = 12000  # steps


def may_be_left(marks):
    """The runs that may be in the log, each with the least number of its steps, by the last mark."""
    if not marks:
        return {0: 0, 1: 0}
    run, steps = marks[-1]
    closed = marks[-2:-1] == marks[-1:]  # marked once more when the log is closed
    least = steps if closed else max(0, steps - MOST_LOST)
    if run == 3:
        return {3: least}
    if run == 2:
        return {1: least, 3: 0} if closed else {1: max(RUN_1, least)}
    return {1: least}


def main():
    program, shim = sys.argv[1:3]
    cuts = int(sys.argv[3]) if len(sys.argv) > 3 else 1000 if os.environ.get("IMPEDRAW_LONG") else 60
    seed = int(sys.argv[4]) if len(sys.argv) > 4 else random.SystemRandom().randrange(10**9)
    print(f"seed {seed}, {cuts} cuts")
    with tempfile.TemporaryDirectory() as scratch:
        scratch = Path(scratch)
        (scratch / "run").mkdir()
        trace = scratch / "trace"
        subprocess.run([program, "write", scratch / "run"], check=True, env=dict(
            os.environ, LD_PRELOAD=shim, RECORD_IO_FOLDER=str(scratch / "run"), RECORD_IO_TRACE=str(trace)))
        steps = list(read_trace(trace))
        # Half of the cuts where names change, which is where little is written.
        changes = [i + 1 for i, s in enumerate(steps) if s[0] in "crumd"]
        rng = random.Random(seed)
        instants = sorted((rng.choice(changes) if rng.random() < 0.5 else rng.randint(0, len(steps)), k) for k in range(cuts))
        disk, done, expected = Disk(), 0, []
        for instant, k in instants:
            for step in steps[done:instant]:
                disk.do(*step)
            done = max(done, instant)
            folder = scratch / f"cut-{k}"
            disk.write(folder, random.Random(seed + k))
            expected.append((folder, instant, may_be_left(disk.marks), disk.marks[-1:]))
        said = subprocess.run([program, "check"] + [str(e[0]) for e in expected], capture_output=True, text=True, timeout=3000)
        lines = said.stdout.splitlines()
        failures = [] if said.returncode == 0 and len(lines) == len(expected) else [f"check ended with {said.returncode}: {said.stderr}"]
        worst = 0
        for line, (folder, instant, least, mark) in zip(lines, expected):
            try:
                run, kept = map(int, line.split())
            except ValueError:
                failures.append(f"cut {folder.name} after operation {instant}: {line}")
                continue
            if run not in least or kept < least[run]:
                failures.append(f"cut {folder.name} after operation {instant}: run {run}, {kept} steps; expected {least}")
            elif mark and (mark[0][0] == run or (run, mark[0][0]) == (1, 2)):
                worst = max(worst, mark[0][1] - kept)
        print(f"{len(steps)} operations; at most {worst} steps lost")
        if worst == 0:
            failures.append("no cut lost anything: the record is wrong")
        for failure in failures:
            print(failure, file=sys.stderr)
        sys.exit(bool(failures))


main()
