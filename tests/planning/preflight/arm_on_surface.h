// The arm over surfaces that canvases are made of, for the pre-flight checks.
#pragma once

#include "impedraw/arm/arm_model.h"
#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/canvas/canvas.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw::surfaces {

inline constexpr const char* kArm = "models/iiwa14_pen.urdf";

// Pen upright in the middle of the drawing, well within every limit.
inline JointVector start_posture(ArmModel& arm) {
  JointVector seed(7);
  seed << 0.0, 0.6, 0.0, -1.4, 0.0, 1.1, 0.0;
  return find_posture(arm, {{0.5, 0, 0.3}, -Eigen::Vector3d::UnitZ()}, seed).q;
}

inline SurfaceHeight seen_from_above(const Canvas& canvas) {
  return [&canvas](double x, double y) -> std::optional<SurfaceSample> {
    const auto hit = canvas.ray({x, y, canvas.bounds().max().z() + 1}, -Eigen::Vector3d::UnitZ());
    if (!hit) return std::nullopt;
    return SurfaceSample{hit->p_W, hit->n_W};
  };
}

inline SurfaceHeight flat(double z) {
  return [z](double x, double y) { return SurfaceSample{{x, y, z}, Eigen::Vector3d::UnitZ()}; };
}

// A wall of no thickness: x = at, from y = −half to half, z = low to high.
inline TriangleMesh wall(double at, double half, double low, double high) {
  return {{{at, -half, low}, {at, half, low}, {at, half, high}, {at, -half, high}},
          {{0, 1, 2}, {0, 2, 3}}};
}

}  // namespace impedraw::surfaces
