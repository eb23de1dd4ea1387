"""1. Draw a picture on a bowl, and look at what came of it.

Run: python 1_draw_and_look.py [picture.svg]
"""

import pathlib
import sys
import tempfile

import numpy as np

import impedraw as idr

# Without a picture, the built-in sine.
picture = sys.argv[1:2]
folder = pathlib.Path(tempfile.mkdtemp()) / "run"
run = idr.draw(*picture, canvas=idr.Bowl(radius=0.3), settings={"control.normal_force": 4}, out=folder)

print(f"{run.end}: ink error {run.metrics.ink_error_rms:.3f} mm, force {run.metrics.force_mean:.2f} N")
force = run.log["contact/force"]  # NumPy: a row a millisecond
print(f"largest force {np.linalg.norm(force, axis=1).max():.2f} N over {len(force)} steps")
print(f"replay: {run.page}  (run.show() opens it; in a notebook, it stands in the cell)")
assert run.metrics.force_mean is not None and abs(run.metrics.force_mean - 4) < 0.2
