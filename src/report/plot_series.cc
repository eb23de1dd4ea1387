#include "impedraw/report/plot_series.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <nlohmann/json.hpp>

#include "impedraw/report/decimate.h"

namespace impedraw {
namespace {

using Json = nlohmann::json;

Json to_json(const Envelope& e, double decimals) {
  const double scale = std::pow(10.0, decimals);
  Json t = Json::array(), v = Json::array();
  for (std::size_t i = 0; i < e.t.size(); ++i) {
    t.push_back(std::round(1e4 * e.t[i]) / 1e4);
    v.push_back(std::isfinite(e.v[i]) ? Json(std::round(scale * e.v[i]) / scale) : Json(nullptr));
  }
  return {{"t", t}, {"v", v}};
}

// The line seen from above, rounded to 0.01 mm.
Json lines_to_json(std::vector<Line2d> lines) {
  decimate_to(lines, 0.02, 20000);
  Json out = Json::array();
  for (const Line2d& line : lines) {
    Json points = Json::array();
    for (const Eigen::Vector2d& p : line)
      points.push_back({std::round(1e2 * p.x()) / 1e2, std::round(1e2 * p.y()) / 1e2});
    out.push_back(points);
  }
  return out;
}

Line2d from_above(std::span<const Eigen::Vector3d> line) {
  constexpr double kSpacing = 0.2;  // [mm]
  Line2d out;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Eigen::Vector2d p = 1e3 * line[i].head<2>();
    if (out.empty() || i + 1 == line.size() || (p - out.back()).norm() >= kSpacing)
      out.push_back(p);
  }
  return out;
}

}  // namespace

Envelope envelope(std::span<const double> t, const std::function<double(std::size_t)>& v,
                  std::size_t points) {
  Envelope e;
  const std::size_t n = t.size(), bins = std::max<std::size_t>(1, points / 2);
  const auto add = [&](std::size_t i, double value) {
    e.t.push_back(t[i]);
    e.v.push_back(value);
  };
  if (n <= points) {
    for (std::size_t i = 0; i < n; ++i) add(i, v(i));
    return e;
  }
  for (std::size_t b = 0; b < bins; ++b) {
    const std::size_t begin = b * n / bins, end = (b + 1) * n / bins;
    std::size_t least = end, largest = end;
    double low = 0.0, high = 0.0;
    for (std::size_t i = begin; i < end; ++i) {
      const double value = v(i);
      if (!std::isfinite(value)) continue;
      if (least == end || value < low) least = i, low = value;
      if (largest == end || value > high) largest = i, high = value;
    }
    if (least == end) {
      add(begin, LogRow::kNone);
    } else {
      add(std::min(least, largest), least < largest ? low : high);
      if (least != largest) add(std::max(least, largest), least < largest ? high : low);
    }
  }
  return e;
}

Json plot_series(const RunData& run, const InkMatch& drawn, std::size_t points) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  std::vector<Line2d> ink, target;
  for (const auto& line : drawn.targets) target.push_back(from_above(line));
  for (const InkLine& line : drawn.lines)
    ink.push_back(
        from_above(std::span(run.contact_point).subspan(line.begin, line.end - line.begin)));
  const auto series = [&](const auto& v, double scale, double decimals) {
    return to_json(envelope(
                       run.time, [&](std::size_t i) { return scale * v[i]; }, points),
                   decimals);
  };
  Json out;
  out["force"] = series(run.f, 1.0, 4);
  out["push"] = series(run.push, 1.0, 4);
  out["tilt"] = series(run.tilt, kDegrees, 4);
  out["normal_error"] = series(run.normal_error, kDegrees, 4);
  out["strokes"] = Json::array();
  for (const StrokeSpan& span : drawn.spans)
    out["strokes"].push_back({run.time[span.begin], run.time[span.end - 1]});
  out["target"] = lines_to_json(std::move(target));
  out["ink"] = lines_to_json(std::move(ink));
  return out;
}

}  // namespace impedraw
