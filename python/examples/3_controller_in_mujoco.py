"""3. The controller in your own loop: MuJoCo's Python bindings simulate the user's arm, and a table of MuJoCo's
own is the surface. impedraw gives the arm's terms, the path and the torque.

Run: python 3_controller_in_mujoco.py   (needs: pip install mujoco)
"""

import mujoco  # type: ignore[import-untyped]
import numpy as np

import impedraw as idr

arm = idr.ArmModel.standard()  # or ArmModel.from_urdf("your_arm.urdf", tip_frame="tip")
table = 0.10  # height of the surface [m]

spec = mujoco.MjSpec.from_file(str(arm.urdf))
spec.compiler.fusestatic = False
spec.option.timestep = 1e-3
spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
for geom in spec.geoms:
    geom.contype = geom.conaffinity = 0
# The pen's tip, a sphere of 1 mm, and a table, the only two that touch.
q = np.array([0.0, 0.55, 0.0, -1.45, 0.0, 1.15, 0.0])
start = arm.tip_pose(q)
last = spec.bodies[-1]
model = spec.compile()
data = mujoco.MjData(model)
data.qpos[:] = q
mujoco.mj_forward(model, data)
R, p = data.xmat[model.nbody - 1].reshape(3, 3), data.xpos[model.nbody - 1]
tip = R.T @ (start.p - 1e-3 * start.R[:, 2] - p)
last.add_geom(name="tip", type=mujoco.mjtGeom.mjGEOM_SPHERE, size=[1e-3, 0, 0], pos=tip, contype=1, conaffinity=1, mass=0, friction=[0.3, 0, 0], condim=3)
spec.worldbody.add_geom(name="table", type=mujoco.mjtGeom.mjGEOM_BOX, size=[1, 1, 0.05], pos=[0.6, 0, table - 0.05], contype=1, conaffinity=1, friction=[0.3, 0, 0], condim=3, solref=[-20000, -60])
model = spec.compile()
data = mujoco.MjData(model)
data.qpos[:] = q

centre = start.p[:2]
stroke = np.array([centre, centre + [0.04, 0.02]])
path = idr.plan_tip_path([stroke], table, idr.PathSettings(start_p_WE=start.p, start_n_W=-start.R[:, 2]))
settings = idr.ImpedanceSettings(normal_force=3.0, null_space=idr.NullSpaceSettings(q_0=q))
controller = idr.ImpedanceController(settings, arm)

forces, errors = [], []
F_ext = np.zeros(6)
for i in range(int(path.duration / 1e-3)):
    terms = arm.compute(data.qpos, data.qvel)
    # Here the surface is known. A cloud's SurfaceEstimator gives the same struct: estimator.estimate(terms.X_WE.p).
    surface = idr.SurfaceEstimate(status="ok", n_W=[0, 0, 1], distance=terms.X_WE.p[2] - table)
    sample = path.at(i * 1e-3)
    out = controller.step(terms, sample.reference, surface, F_ext)
    data.qfrc_applied[:] = out.tau
    mujoco.mj_step(model, data)
    # The wrench on the tip, as a force-torque sensor would give it.
    F_ext = np.zeros(6)
    for k in range(data.ncon):
        c = np.zeros(6)
        mujoco.mj_contactForce(model, data, k, c)
        f = data.contact[k].frame.reshape(3, 3).T @ c[:3]
        if model.geom(data.contact[k].geom1).name == "tip":
            f = -f
        F_ext += np.r_[f, np.cross(data.contact[k].pos - terms.X_WE.p, f)]
    if sample.stroke == 0:
        forces.append(F_ext[2])
        d = terms.X_WE.p[:2] - stroke[0]
        u = (stroke[1] - stroke[0]) / np.linalg.norm(stroke[1] - stroke[0])
        errors.append(1e3 * abs(u[0] * d[1] - u[1] * d[0]))

settled = np.array(forces[100:])
print(f"force {settled.mean():.2f} ± {settled.std():.2f} N, line within {max(errors):.2f} mm")
assert abs(settled.mean() - 3) < 0.3 and max(errors) < 1.0
