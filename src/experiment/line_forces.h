// Widths of lines become forces of the pen.
//
// A stroke whose width is known, as painted and scaled with the drawing, gets the force at which
// the pen draws that width (ink/pen.h), if its width changes with the force; one that gives forces
// gets those. Both stay within the pen's limits. All others keep control.normal_force.
#pragma once

#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/scenario.h"

namespace impedraw {

// Sets PlacedStroke::force of the strokes as drawn, and notes what the pen cannot do. Without
// perception or touch the force is that of a spring, and stays as it is: noted. Throws InputError
// if pen.least_force is above pen.most_force.
void give_forces(const Scenario& scenario, const SettingErrors& setting_errors,
                 PlacedArtwork* artwork);

// The greatest force of the strokes, or control.normal_force [N].
double hardest(const Scenario& scenario, const std::vector<PlacedStroke>& strokes);

}  // namespace impedraw
