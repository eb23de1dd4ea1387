#include "impedraw/canvas/shape_checks.h"

#include <fmt/format.h>

#include "impedraw/common/errors.h"

namespace impedraw {

namespace {
constexpr double kMostShapeTriangles = 2e7;  // more is probably a wrong unit
}

void require_at_most(std::string_view shape, std::string_view name, double value,
                     std::string_view what, double most) {
  if (value > most)
    throw InputError(
        fmt::format("{}.{} is {} m, allowed is at most {}, {} m", shape, name, value, what, most));
}

void require_fair_size(std::string_view shape, double edge, double triangles) {
  if (triangles > kMostShapeTriangles) {
    throw InputError(
        fmt::format("{}.edge is {} m, which makes {:.0e} triangles, at most {:.0e} are made: take "
                    "a longer edge",
                    shape, edge, triangles, kMostShapeTriangles));
  }
}

}  // namespace impedraw
