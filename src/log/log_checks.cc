#include "impedraw/log/log_checks.h"

#include <cmath>
#include <limits>
#include <span>
#include <string>

#include <fmt/format.h>

namespace impedraw {
namespace {

using Eigen::Vector3d;

constexpr double kFarthest = 100.0;  // of any coordinate [m]
constexpr double kLatest = 1e9;      // [s]
constexpr double kLongest = 1e4;     // of target and ink [m]
constexpr double kWidest = 1.0;      // gap between points of a target's stroke [m]
constexpr int kMostStrokes = 10'000'000;

[[noreturn]] void fail_at(const LogReader& log, const std::string& name, std::size_t row,
                          const std::string& what) {
  log.fail(fmt::format("dataset {}: row {} {}", name, row, what));
}

bool is_near(const Vector3d& p) {
  return p.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= kFarthest;
}

std::string far_text(const Vector3d& p) {
  return fmt::format("is ({:.4g}, {:.4g}, {:.4g}), must be finite and within ± {:g} m", p.x(),
                     p.y(), p.z(), kFarthest);
}

void require_near(const LogReader& log, const char* name, std::span<const Vector3d> points) {
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!is_near(points[i])) fail_at(log, name, i, far_text(points[i]));
  }
}

void require_strokes(const LogReader& log, const RunConstants& c) {
  double length = 0.0;
  for (std::size_t i = 0; i < c.target_stroke.size(); ++i) {
    const int stroke = c.target_stroke[i], before = i > 0 ? c.target_stroke[i - 1] : 0;
    if (stroke < before || stroke >= kMostStrokes)
      fail_at(log, "/target/stroke", i,
              fmt::format("is {}, must be {} to {}", stroke, before, kMostStrokes - 1));
    if (i == 0 || stroke != before) continue;
    const double gap = (c.target_points[i] - c.target_points[i - 1]).norm();
    length += gap;
    if (gap > kWidest)
      fail_at(log, "/target/points", i,
              fmt::format("is {:.4g} m from the point before it on the same stroke, must be at "
                          "most {:g} m",
                          gap, kWidest));
    if (length > kLongest)
      fail_at(log, "/target/points", i,
              fmt::format("is beyond {:g} km of strokes, which no drawing has", 1e-3 * kLongest));
  }
}

std::string in_steps(const LogReader& log, const char* name) {
  return (log.rate() == LogRate::reduced ? "/every_step" : "") + std::string(name);
}

}  // namespace

void require_along(const LogReader& log, const LogStep& step, std::size_t row) {
  if (step.stroke >= 0 && !(std::abs(step.stroke_along) <= kLongest))
    fail_at(log, in_steps(log, "/stroke_along"), row,
            fmt::format("is {}, must be finite and within ± {:g} m", step.stroke_along, kLongest));
}

void require_valid(const LogReader& log, const RunConstants& c) {
  require_near(log, "/canvas/vertices", c.canvas_vertices);
  const long vertices = static_cast<long>(c.canvas_vertices.size());
  for (std::size_t i = 0; i < c.canvas_triangles.size(); ++i) {
    for (const int v : c.canvas_triangles[i]) {
      if (v < 0 || v >= vertices)
        fail_at(log, "/canvas/triangles", i,
                fmt::format("names vertex {}, must be 0 to {}", v, vertices - 1));
    }
  }
  require_near(log, "/cloud/points", c.cloud_points);
  require_near(log, "/target/points", c.target_points);
  require_strokes(log, c);
}

StepChecks::StepChecks(const LogReader& log)
    : log_(log),
      last_time_(-std::numeric_limits<double>::infinity()),
      last_point_(Vector3d::Constant(LogRow::kNone)) {}

void StepChecks::next(const LogStep& step) {
  const auto fail = [&](const char* name, const std::string& what) {
    fail_at(log_, in_steps(log_, name), row_, what);
  };
  if (!(step.time > last_time_) || !(std::abs(step.time) <= kLatest))
    fail("/time",
         fmt::format("is {:.9g}, must be more than {:.9g} s, the row before it, and at most {:g} s",
                     step.time, last_time_, kLatest));
  last_time_ = step.time;
  if (step.stroke < -1 || step.stroke >= kMostStrokes)
    fail("/stroke", fmt::format("is {}, must be -1 to {}", step.stroke, kMostStrokes - 1));
  const int modes = static_cast<int>(log_.header().mode_names.size());
  if (step.mode < 0 || step.mode >= modes)
    fail("/mode", fmt::format("is {}, must be 0 to {}", step.mode, modes - 1));
  const Vector3d& p = step.contact_point;
  if (!p.array().isNaN().any()) {
    const char* name = log_.rate() == LogRate::reduced ? "/contact_point" : "/contact/point";
    if (!is_near(p)) fail(name, far_text(p));
    if (!last_point_.array().isNaN().any()) length_ += (p - last_point_).norm();
    if (length_ > kLongest)
      fail(name, fmt::format("is beyond {:g} km of ink, which no run has", 1e-3 * kLongest));
  }
  last_point_ = p;
  ++row_;
}

}  // namespace impedraw
