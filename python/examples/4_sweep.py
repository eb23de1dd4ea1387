"""4. A sweep by hand: force and speed on a plane, a row a run. Runs of one process share their scene, so that each takes
a fraction of the first. (`impedraw.sweep` and `./impedraw sweep` do it on many cores and machines, and go on after a kill.)

Run: python 4_sweep.py
"""

import itertools
import pathlib
import tempfile
import time

from impedraw import _runner

line = pathlib.Path(tempfile.mkdtemp()) / "line.svg"
line.write_text('<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="10mm" viewBox="0 0 20 10"><path d="M0 5 H20" stroke="black"/></svg>')

print("force N  speed m/s  ink error mm  force rms N  wall s")
rows = []
for force, speed in itertools.product([2, 5, 10], [0.02, 0.05]):
    start = time.perf_counter()
    result = _runner.run(
        {"canvas.kind": "plane", "drawing.placement.scale": 1, "control": {"normal_force": force}, "path.draw_speed": speed}, svg=line
    )
    m = result["metrics"]
    rows.append(m)
    print(f"{force:7}  {speed:9}  {m['ink_error_rms']:12.4f}  {m['force_rms_error']:11.4f}  {time.perf_counter() - start:6.2f}")
assert all(m["strokes_missed"] == 0 and m["coverage"] > 0.99 for m in rows)
