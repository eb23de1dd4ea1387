#include "report/plot_series.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "report/statistics.h"

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

Json lines_to_json(const std::vector<std::vector<Eigen::Vector3d>>& lines, std::size_t points) {
  double length = 0.0;
  for (const auto& line : lines) {
    for (std::size_t i = 0; i + 1 < line.size(); ++i) length += (line[i + 1] - line[i]).norm();
  }
  const double step = std::max(0.2e-3, length / static_cast<double>(points));
  Json out = Json::array();
  for (const auto& line : lines) {
    Json thin = Json::array();
    Eigen::Vector3d last = Eigen::Vector3d::Constant(LogRow::kNone);
    for (std::size_t i = 0; i < line.size(); ++i) {
      if ((line[i] - last).norm() < step && i + 1 < line.size()) continue;
      last = line[i];
      thin.push_back({std::round(1e5 * last.x()) / 1e2, std::round(1e5 * last.y()) / 1e2});
    }
    out.push_back(thin);
  }
  return out;
}

// Equal bins up to the 99.9th percentile; what is slower counts in the last.
Json histogram(const std::vector<double>& seconds) {
  std::vector<double> micros;
  for (const double s : seconds) {
    if (std::isfinite(s)) micros.push_back(1e6 * s);
  }
  if (micros.empty()) return nullptr;
  constexpr int kBins = 80;
  const double low = *std::min_element(micros.begin(), micros.end()), high = std::max(percentile(micros, 0.999), low + 1e-3);
  std::vector<double> edges;
  std::vector<long> counts(kBins, 0);
  for (int k = 0; k <= kBins; ++k) edges.push_back(low + (high - low) * k / kBins);
  for (const double m : micros) ++counts[std::min(kBins - 1, static_cast<int>((m - low) / (high - low) * kBins))];
  return {{"edges", edges}, {"counts", counts}};
}

}  // namespace

Envelope envelope(std::span<const double> t, std::span<const double> v, std::size_t points) {
  Envelope e;
  const std::size_t n = v.size(), bins = std::max<std::size_t>(1, points / 2);
  if (n <= points) return {{t.begin(), t.end()}, {v.begin(), v.end()}};
  for (std::size_t b = 0; b < bins; ++b) {
    const std::size_t begin = b * n / bins, end = (b + 1) * n / bins;
    std::size_t least = end, largest = end;
    for (std::size_t i = begin; i < end; ++i) {
      if (!std::isfinite(v[i])) continue;
      if (least == end || v[i] < v[least]) least = i;
      if (largest == end || v[i] > v[largest]) largest = i;
    }
    const auto add = [&](std::size_t i, double value) {
      e.t.push_back(t[i]);
      e.v.push_back(value);
    };
    if (least == end) {
      add(begin, LogRow::kNone);
    } else {
      add(std::min(least, largest), v[std::min(least, largest)]);
      if (least != largest) add(std::max(least, largest), v[std::max(least, largest)]);
    }
  }
  return e;
}

Json plot_series(const RunData& run, const Drawn& drawn, std::size_t points) {
  const std::size_t n = run.rows();
  const auto scaled = [&](const std::vector<double>& v, double scale) {
    std::vector<double> out(v);
    for (double& value : out) value *= scale;
    return out;
  };
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  std::vector<double> speed(n, LogRow::kNone), torque(n), mode(n);
  std::vector<std::vector<Eigen::Vector3d>> ink;
  for (const InkLine& line : drawn.lines) {
    ink.emplace_back(run.contact_point.begin() + line.begin, run.contact_point.begin() + line.end);
    if (line.stroke < 0) continue;
    for (std::size_t i = line.begin; i + 1 < line.end; ++i) {
      speed[i] = 1e3 * (run.contact_point[i + 1] - run.contact_point[i]).norm() / (run.time[i + 1] - run.time[i]);
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    torque[i] = 100.0 * (run.joint_torque.row(row).transpose().array().abs() / run.torque_limit.array()).maxCoeff();
    mode[i] = run.mode[i];
  }
  const auto series = [&](const std::vector<double>& v, double decimals) { return to_json(envelope(run.time, v, points), decimals); };
  Json out;
  out["force"] = series(drawn.f, 4);
  out["push"] = series(run.push, 4);
  out["ink_error"] = series(scaled(drawn.error, 1e3), 5);
  out["tilt"] = series(scaled(drawn.tilt, kDegrees), 4);
  out["normal_error"] = series(scaled(drawn.normal_error, kDegrees), 4);
  out["speed"] = series(speed, 2);
  out["torque"] = series(torque, 2);
  out["mode"] = series(mode, 0);
  out["mode_names"] = run.mode_names;
  out["strokes"] = Json::array();
  for (const StrokeSpan& span : drawn.spans) out["strokes"].push_back({run.time[span.begin], run.time[span.end - 1]});
  out["step_time"] = histogram(run.step_time);
  out["target"] = lines_to_json(drawn.targets, 20000);
  out["ink"] = lines_to_json(ink, 20000);
  return out;
}

}  // namespace impedraw
