// How much of a drawing was drawn, and what the rest lacks. Lengths are in the drawing plane.
//
// Drawn: where a row has ink, whatever its place. Gaps of up to 1 mm count as drawn. The rest is,
// by reason, what the pre-flight left out (names of Problem), what was given up while drawing
// (Ending::given_up), and what has no ink: `not_reached` where the run ended before, else `no_ink`.
#pragma once

#include <map>
#include <optional>
#include <string>

#include "impedraw/log/run_data.h"
#include "impedraw/metrics/ending.h"
#include "impedraw/metrics/promise.h"

namespace impedraw {

struct DrawnLengths {
  double asked = 0.0, drawn = 0.0;          // [m]
  std::map<std::string, double> not_drawn;  // by reason [m]
};

DrawnLengths drawn_lengths(const RunData& run, const Promise& promise, const Ending& ending);

// "edge 0.2 m, too steep 31 mm", the longest first; empty: nothing is missing.
std::string rest_text(const std::map<std::string, double>& not_drawn_mm);
// "31 mm", "2.9 m".
std::string length_text(double mm);

}  // namespace impedraw
