"""4. A sweep: force and speed on a plane, on all cores. The same call goes on after a kill.

Run: python 4_sweep.py   (needs: pip install 'impedraw[sweep]')
"""

import pathlib
import tempfile

import impedraw as idr

folder = pathlib.Path(tempfile.mkdtemp())
line = folder / "line.svg"
line.write_text('<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="10mm" viewBox="0 0 20 10"><path d="M0 5 H20" stroke="black"/></svg>')

done = idr.sweep(
    {
        "name": "force-and-speed",
        "scenario": "scenarios/bowl-sine.yaml",
        "svg": str(line),
        "set": {"canvas.kind": "plane", "drawing.placement.scale": 1, "drawing.redraw": False},
        "axes": {"control.normal_force": [2, 5, 10], "path.draw_speed": [0.02, 0.05]},
        "accept": {"drawn": "coverage > 0.99"},
    },
    out=folder / "force-and-speed",
)
print("force N  speed m/s  ink error mm  force rms N")
for m in done.rows:
    print(f"{m['control.normal_force']:7}  {m['path.draw_speed']:9}  {m['ink_error_rms']:12.4f}  {m['force_rms_error']:11.4f}")
print(f"{done!r}; its page is {done.folder / 'report.html'}")
assert len(done) == 6 and not any(m["failed"] for m in done.rows)
