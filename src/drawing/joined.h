// Strokes whose ends meet become one.
#pragma once

#include <vector>

#include "impedraw/drawing/stroke.h"

namespace impedraw {

// Makes one stroke of those whose ends meet: a map's streets, a CAD file's pieces. The pen need not
// be lifted between them.

inline constexpr double kJoined = 0.05;  // how far apart ends that meet may lie [mm]

// Each stroke goes on, from its end and then from its start, with the open stroke of its layer,
// colour and width that begins or ends there and turns least. All lengths stay.
std::vector<Stroke> joined(std::vector<Stroke> strokes);

}  // namespace impedraw
