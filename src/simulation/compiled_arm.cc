#include "impedraw/simulation/compiled_arm.h"

#include <cmath>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/arm/arm_notes.h"
#include "impedraw/arm/plain_urdf.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/per_joint.h"
#include "impedraw/common/range_check.h"
#include "impedraw/simulation/describe_world.h"

namespace impedraw {

namespace {

void apply(const ModelErrors& e, mjSpec* spec) {
  for (mjsElement* element = mjs_firstElement(spec, mjOBJ_BODY); element;
       element = mjs_nextElement(spec, element)) {
    mjsBody* body = mjs_asBody(element);
    if (!(body->mass > 0.0)) continue;
    body->mass *= e.mass_scale;
    for (double& value : body->inertia) value *= e.mass_scale;
    for (double& value : body->fullinertia)
      value *= e.mass_scale;  // a URDF sets fullinertia, an MJCF either; an unset NaN stays NaN
    if (mjs_firstChild(body, mjOBJ_JOINT, 0))
      for (double& value : body->ipos) value += e.centre_shift / std::sqrt(3.0);
  }
  if (mjsBody* tip = mjs_findBody(spec, "tip")) {
    const Eigen::Quaterniond turned(tip->quat[0], tip->quat[1], tip->quat[2], tip->quat[3]);
    Eigen::Map<Eigen::Vector3d>(tip->pos) +=
        e.pen_longer * (turned.normalized() * Eigen::Vector3d::UnitZ());
  }
}

}  // namespace

CompiledArm compile_arm(const std::filesystem::path& urdf, double dt, double gravity,
                        const ModelErrors& errors) {
  require_ranges("world.errors", errors);
  const std::string text = plain_urdf(urdf).text;
  char error[512] = "";
  mjSpec* spec = mj_parseXMLString(text.c_str(), nullptr, error, sizeof error);
  if (!spec) throw InputError(fmt::format("arm description {}: {}", urdf.string(), error));
  spec->compiler.fusestatic = 0;  // keep the frames of flange and tip
  spec->option.timestep = dt;
  spec->option.integrator = mjINT_EULER;
  spec->option.disableflags |= mjDSBL_CONSTRAINT | mjDSBL_EULERDAMP | mjDSBL_SPRING | mjDSBL_DAMPER;
  mju_copy3(spec->option.gravity, Eigen::Vector3d(0, 0, -gravity).eval().data());
  apply(errors, spec);
  CompiledArm arm;
  arm.shape = mj_compile(spec, nullptr);
  if (arm.shape) {
    while (mjsElement* geom = mjs_firstElement(spec, mjOBJ_GEOM)) mjs_delete(spec, geom);
    arm.dynamics = mj_compile(spec, nullptr);
  }
  const std::string cause = arm.dynamics ? "" : mjs_getError(spec);
  mj_deleteSpec(spec);
  if (!arm.dynamics) {
    mj_deleteModel(arm.shape);
    throw InputError(fmt::format("arm description {}: {}", urdf.string(), cause));
  }
  mjModel* m = arm.dynamics;
  arm.friction = Eigen::Map<const Eigen::VectorXd>(m->dof_frictionloss, m->nv);
  Eigen::Map<Eigen::VectorXd> explicit_damping(m->dof_damping, m->nv);
  arm.damping = explicit_damping.array() + errors.viscous_friction;
  explicit_damping.setZero();
  const std::vector<double>& told = errors.rotor_inertia;
  try {
    Eigen::Map<Eigen::VectorXd>(m->dof_armature, m->nv) =
        dt * arm.damping + per_joint("world.errors.rotor_inertia",
                                     told.empty() ? read_arm_notes(text, urdf).rotor_inertia : told,
                                     m->nv);
  } catch (const InputError&) {
    mj_deleteModel(arm.dynamics);
    mj_deleteModel(arm.shape);
    throw;
  }
  return arm;
}

}  // namespace impedraw
