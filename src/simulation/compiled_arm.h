// The arm's URDF, with its model errors, as MuJoCo models. For this folder's sources alone:
// MuJoCo's headers stay here.
#pragma once

#include <filesystem>

#include <mujoco/mujoco.h>

#include "impedraw/simulation/model_errors.h"

namespace impedraw {

struct CompiledArm {            // owned by the caller
  mjModel* dynamics = nullptr;  // no body shapes, whose places would cost every step
  mjModel* shape = nullptr;     // with them, for the cameras
};

// Viscous friction is taken into the dynamics as h b of inertia on every joint: with −b v as a
// torque, Euler's step
//   (M + h b) (v⁺ − v) = h (τ − C v − g − b v) + p   is   M (v⁺ − v) = h (τ − C v − g − b v⁺) + p,
// implicit and exact beside whatever impulses p are solved for, however light a joint is.
// Throws InputError for a file that is missing or broken and for errors out of range.
CompiledArm compile_arm(const std::filesystem::path& urdf, double dt, double gravity,
                        const ModelErrors& errors);

}  // namespace impedraw
