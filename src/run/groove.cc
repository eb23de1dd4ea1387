#include "impedraw/run/groove.h"

#include <algorithm>
#include <cmath>

#include <nlohmann/json.hpp>

#include "impedraw/planning/stroke_part.h"

namespace impedraw {

GrooveJudge::GrooveJudge(const Experiment& e)
    : lines_(
          std::max(1, static_cast<int>(e.plan.strokes.size() / depths_of(e.scenario.tool).size()))),
      asked_(e.scenario.tool.depth),
      depth_(static_cast<std::size_t>(lines_)) {
  for (const PlacedStroke& stroke : e.plan.strokes) {
    std::vector<double>& line = depth_[static_cast<std::size_t>(stroke.number % lines_)];
    const double end = stroke.start + plane_length(stroke);
    if (line.empty()) line.resize(static_cast<std::size_t>(stroke.start / kBin), LogRow::kNone);
    line.resize(std::max(line.size(), static_cast<std::size_t>(std::ceil(end / kBin))), 0.0);
  }
}

void GrooveJudge::add(const LogRow& row) {
  if (row.stroke < 0 || !row.contact_point.allFinite() || !std::isfinite(row.stroke_along)) return;
  std::vector<double>& line = depth_[static_cast<std::size_t>(row.stroke % lines_)];
  const auto bin = static_cast<std::size_t>(std::max(0.0, row.stroke_along) / kBin);
  const Eigen::Vector3d to_surface = row.contact_point_W() - row.tip_position;
  if (bin >= line.size()) return;
  // A log of a reduced rate has no row in some of the places that the cutter passes.
  const bool on = row.stroke == last_stroke_ && bin > last_bin_ && bin <= last_bin_ + 5;
  for (std::size_t b = on ? last_bin_ + 1 : bin; b <= bin; ++b)
    line[b] = std::max(line[b], row.contact_normal_W().dot(to_surface));
  last_stroke_ = row.stroke;
  last_bin_ = bin;
}

nlohmann::ordered_json GrooveJudge::results() const {
  double count = 0.0, sum = 0.0, square = 0.0, most = 0.0;
  for (const std::vector<double>& line : depth_)
    for (const double depth : line) {
      if (!std::isfinite(depth)) continue;
      count += 1.0;
      sum += depth;
      square += (depth - asked_) * (depth - asked_);
      most = std::max(most, std::abs(depth - asked_));
    }
  nlohmann::ordered_json out;
  for (const char* name : {"depth_error_rms", "depth_error_max", "depth_mean"})
    out["metrics"][name] = nullptr;
  if (count > 0.0)
    out["metrics"] = {{"depth_error_rms", 1e3 * std::sqrt(square / count)},
                      {"depth_error_max", 1e3 * most},
                      {"depth_mean", 1e3 * sum / count}};
  out["depth_asked_mm"] = 1e3 * asked_;
  return out;
}

}  // namespace impedraw
