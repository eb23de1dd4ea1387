// Compiles the arm's URDF, with model errors, into MuJoCo models. Only this folder's sources
// include this header.
#pragma once

#include <filesystem>

#include <mujoco/mujoco.h>
#include <Eigen/Core>

#include "impedraw/simulation/world_settings.h"

namespace impedraw {

struct CompiledArm {            // owned by the caller
  mjModel* dynamics = nullptr;  // without body shapes, which would slow every step
  mjModel* shape = nullptr;     // with body shapes, for the cameras
  // of each joint: b, with the URDF's <dynamics damping>, and its <dynamics friction>
  Eigen::VectorXd damping, friction;  // [Nm s/rad], [Nm]
};

// Viscous friction enters the dynamics as an inertia h b on every joint. With −b v as a torque,
// Euler's step
//   (M + h b) (v⁺ − v) = h (τ − C v − g − b v) + p   is   M (v⁺ − v) = h (τ − C v − g − b v⁺) + p,
// which is implicit and exact for any impulses p, however light a joint is.
// Throws InputError for a missing or malformed file and for errors out of range.
CompiledArm compile_arm(const std::filesystem::path& urdf, double dt, double gravity,
                        const ModelErrors& errors);

}  // namespace impedraw
