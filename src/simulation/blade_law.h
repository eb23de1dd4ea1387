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

#include "impedraw/simulation/world_settings.h"

namespace impedraw {

struct BladeSettings {
  double toughness = 4e3;         // R [J/m²]
  double angle = 0.785398163397;  // α [rad]
};

// The line that this blade touches with, and which lies level with E under `force` [N]. radius:
// half its length; 0: c/2 [m].
PadSettings blade_edge(const BladeSettings& blade, double radius, double force);

// The line on which a roller with the pad's foam stands, as long as the pad is wide. It rolls along
// x_E with the foam's resistance alone, and slides across with the pad's friction.
PadSettings roller_line(PadSettings pad, double trail, double force);

}  // namespace impedraw
