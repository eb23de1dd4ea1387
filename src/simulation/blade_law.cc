#include "impedraw/simulation/blade_law.h"

#include <algorithm>
#include <cmath>

namespace impedraw {

PadSettings blade_edge(const BladeSettings& s, double radius, double force) {
  constexpr double kDamping = 4e-3;               // b/k [s]
  constexpr double kDeeper = 4.0, kLeast = 5e-3;  // of the depth; [m]
  PadSettings edge;
  edge.face = PadFace::edge;
  edge.radius = radius > 0.0 ? radius : 0.5 * force / s.toughness;
  const double stiffness = s.toughness / std::tan(s.angle);  // [N/m]
  edge.stiffness = stiffness / edge.area();
  edge.damping = kDamping * edge.stiffness;
  edge.friction = std::tan(s.angle);
  edge.friction_across = 1.0 + edge.friction;
  edge.rest = force / stiffness;
  edge.thickness = std::max(kLeast, kDeeper * edge.rest);
  return edge;
}

PadSettings roller_line(PadSettings pad, double trail, double force) {
  constexpr double kRolling = 0.02;  // resistance over force: rubber on a hard face
  constexpr double kWidth = 0.02;    // of the strip that carries it, of a roller of 20 mm [m]
  pad.face = PadFace::axle;
  pad.friction_across = pad.friction;
  pad.friction = kRolling;
  pad.stiffness *= kWidth;
  pad.damping *= kWidth;
  pad.rest = force / (pad.stiffness * pad.area());
  pad.thickness = std::max(pad.thickness, 2.0 * pad.rest);
  pad.trail = trail;
  return pad;
}

}  // namespace impedraw
