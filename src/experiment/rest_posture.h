// The rest posture of the null space.
#pragma once

#include <vector>

#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/belief.h"

namespace impedraw {

// Returns arm.q_0 if given. Otherwise the tip is on the surface at the drawing's centre, or, if
// there is none, at the middle of the first of `strokes` that has one. Throws InputError if q_0 is
// not a posture of the arm.
JointVector rest_posture(const ArmSettings& settings, const PlacedArtwork& artwork,
                         const std::vector<PlacedStroke>& strokes, const Belief& belief,
                         const SettingErrors& setting_errors);

}  // namespace impedraw
