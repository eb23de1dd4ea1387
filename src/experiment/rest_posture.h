// The posture that the null space pulls the arm to.
#pragma once

#include <vector>

#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/scene.h"

namespace impedraw {

// arm.q_0 where it is given, else with the tip over the middle of the drawing, or where there is no
// surface there, of the first of `strokes` whose middle has one. Throws InputError: a q_0 that is
// not a posture of the arm.
JointVector rest_posture(const ArmSettings& settings, const PlacedArtwork& artwork,
                         const std::vector<PlacedStroke>& strokes, Scene& scene,
                         const SettingErrors& setting_errors);

}  // namespace impedraw
