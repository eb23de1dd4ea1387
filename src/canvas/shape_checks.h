// Checks the sizes of built-in canvases. Each throws InputError naming the shape, the setting, its
// value and what would be valid.
#pragma once

#include <string_view>

#include <Eigen/Core>

#include "impedraw/common/range.h"

namespace impedraw {

void require_at_most(std::string_view shape, std::string_view name, double value,
                     std::string_view what, double most);  // [m]
// Limits the number of triangles to what fits in memory easily.
void require_fair_size(std::string_view shape, double edge, double triangles);

}  // namespace impedraw
