// Forces on a knife that is drawn through a sheet, and what they make of a line of contact.
//
// Drag   R d            against the way: the work of fracture R, of each metre and each depth d
// Down   R d cot α      without friction the force is across the edge, which is inclined by α to
//                       the surface (slice-push: A. G. Atkins, Interface Focus 6, 2016, section 1)
// Aside  R (c + d)      c = d cot α: length of the edge in the sheet. What opens when the blade
//                       moves across itself: its length below, and its front. A lower bound by the
//                       same balance of work, and not a measured law.
// Hence under the force F: d = F tan α/R and c = F/R; a spring of R cot α [N/m] along the normal;
// along the edge μ = tan α, across it μ = 1 + tan α.
//
// Coefficient  R of HDPE, cut: 4 kJ/m² (A. N. Gent, C. Wang, J. Polymer Science B 34, 1996)
#pragma once

#include <algorithm>
#include <cmath>

#include "impedraw/simulation/world_settings.h"

namespace impedraw {

struct BladeSettings {
  double toughness = 4e3;         // R [J/m²]
  double angle = 0.785398163397;  // α [rad]
};

// The line that this blade touches with, and which lies level with E under `force` [N]. radius:
// half its length; 0: c/2 [m].
inline PadSettings blade_edge(const BladeSettings& s, double radius, double force) {
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

// The line on which a roller with the pad's foam stands, as long as the pad is wide. It rolls along
// x_E with the foam's resistance alone, and slides across with the pad's friction.
inline PadSettings roller_line(PadSettings pad, double trail, double force) {
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
