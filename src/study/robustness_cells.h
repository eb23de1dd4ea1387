// The cells of ./impedraw robustness.
//
// matrix   10, 50, 100, 200 mm/s × slopes 0, 15, 30, 45, 60° × pushes of 1, 5, 20 N, nominal and
//          realistic: a circle on a leaning plane
// error    each model error alone, at three values, on the standard sine; `none` is the baseline
// tuned    what the controller cannot know or is not told, at three values each, under the tuning
//          of bowl-sine-real, whose other errors stay
// canvas   each shape at 50 mm/s and 5 N, nominal and realistic
// switch   observer, rejection of tip friction, force integral: off and on, each under the
//          conditions that it is meant for
#pragma once

#include <vector>

#include "impedraw/study/cell.h"

namespace impedraw {

std::vector<Cell> robustness_cells();

}  // namespace impedraw
