#include "impedraw/canvas/shape_checks.h"

#include <cmath>

#include <fmt/format.h>

#include "impedraw/common/errors.h"

namespace impedraw {

namespace {
constexpr double kMostTriangles = 2e7;  // beyond it, a slip of units rather than a wish
}

void require_positive(std::string_view shape, std::string_view name, double value) {
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw InputError(
        fmt::format("{}: {} = {} m, must be a finite length above 0", shape, name, value));
  }
}

void require_finite(std::string_view shape, std::string_view name, double value,
                    std::string_view unit) {
  if (!std::isfinite(value))
    throw InputError(fmt::format("{}: {} = {} {}, must be finite", shape, name, value, unit));
}

void require_finite(std::string_view shape, std::string_view name, const Eigen::Vector3d& value) {
  if (!value.allFinite()) {
    throw InputError(fmt::format("{}: {} = ({}, {}, {}), must be finite", shape, name, value.x(),
                                 value.y(), value.z()));
  }
}

void require_at_most(std::string_view shape, std::string_view name, double value,
                     std::string_view what, double most) {
  if (value > most)
    throw InputError(
        fmt::format("{}: {} = {} m, must be at most {}, {} m", shape, name, value, what, most));
}

void require_fair_size(std::string_view shape, double edge, double triangles) {
  if (triangles > kMostTriangles) {
    throw InputError(fmt::format(
        "{}: edge = {} m makes {:.0e} triangles, at most {:.0e} are made: take a longer edge",
        shape, edge, triangles, kMostTriangles));
  }
}

}  // namespace impedraw
