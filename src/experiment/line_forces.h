// Widths of lines become forces of the pen.
//
// A stroke whose width is known, as painted and scaled with the drawing, gets the force at which
// the pen draws that width (ink/pen.h), if its width changes with the force; one that gives forces
// gets those. Both stay within the pen's limits. All others keep control.normal_force. An
// engraver's lines are laid once for each of its passes, all lines of a pass together, and get the
// forces of their cuts.
#pragma once

#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/metrics/pens.h"

namespace impedraw {

// The pens of the artwork's layers, one each: `pens` over `pen`, in the colour of the layer's first
// line if none is given. Throws InputError for a pen of no layer, or a colour that is none.
std::vector<DrawnPen> layer_pens(const Scenario& scenario, const Artwork& artwork,
                                 const SettingErrors& setting_errors);

// Sets PlacedStroke::force of the strokes as drawn, and notes what the pen cannot do; sets speed,
// waits and pauses as `pens` and the layers' names have them. Without perception or touch the force
// is that of a spring, and stays as it is: noted. Throws InputError if pen.least_force is above
// pen.most_force, and as layer_pens() does.
void give_forces(const Scenario& scenario, const SettingErrors& setting_errors,
                 PlacedArtwork* artwork);

// The greatest force of the strokes, or control.normal_force [N].
double hardest(const Scenario& scenario, const std::vector<PlacedStroke>& strokes);

}  // namespace impedraw
