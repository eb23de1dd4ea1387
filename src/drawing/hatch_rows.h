// Lines of a hatch, in rows, and how they are joined to strokes that the pen draws in one go.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "impedraw/drawing/regions.h"

namespace impedraw {

// A line of a hatch. A closed one repeats its first point.
struct HatchLine {
  std::vector<Eigen::Vector2d> points;
  std::int64_t row = 0;  // lines of neighbouring rows lie beside each other
};

// The parts of the lines in the region.
std::vector<HatchLine> lines_inside(const std::vector<HatchLine>& lines, const RegionIndex& region);

// The parts of the lines where a tone between 0 and 1 asks for them, looked at every `step`. Row k
// is drawn where the tone is above its threshold. The thresholds of any 2ⁿ rows in succession are
// spread evenly (van der Corput), so that rows go out one by one, each between others that stay.
std::vector<HatchLine> lines_of_tone(const std::vector<HatchLine>& lines, double step,
                                     const std::function<double(const Eigen::Vector2d&)>& tone);

// Strokes along the lines. Each goes on from the end of a line to the nearest place of one in a row
// beside it, or of a closed one in its row, at most `farthest` away, where the way between them
// stays in the region. Closed lines begin anywhere. The ends of the others stand back by `inset`,
// so that the ink of a join does, too.
std::vector<std::vector<Eigen::Vector2d>> flowing(std::vector<HatchLine> lines,
                                                  const RegionIndex& region, double inset,
                                                  double farthest);

}  // namespace impedraw
