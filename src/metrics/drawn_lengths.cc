#include "impedraw/metrics/drawn_lengths.h"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "impedraw/ink/ink_lines.h"

namespace impedraw {
namespace {

constexpr double kIgnored = 1e-3;  // a shorter gap, or rest [m]

// Of the strokes that have ink, as the plan measures them.
double inked_length(const RunData& run) {
  std::map<int, std::vector<std::pair<double, double>>> parts;
  bool open = false;
  for (std::size_t i = 0; i < run.rows(); ++i) {
    const double along = run.stroke_along[i];
    const int stroke = run.stroke[i];
    if (stroke < 0 || !is_ink(run.f[i]) || !std::isfinite(along)) {
      open = false;
      continue;
    }
    auto& of_stroke = parts[stroke];
    open = open && run.stroke[i - 1] == stroke;
    if (!open) of_stroke.emplace_back(along, along);
    of_stroke.back().first = std::min(of_stroke.back().first, along);
    of_stroke.back().second = std::max(of_stroke.back().second, along);
    open = true;
  }
  double sum = 0.0;
  for (auto& [stroke, of_stroke] : parts) {
    std::sort(of_stroke.begin(), of_stroke.end());
    double end = of_stroke.front().first;
    for (const auto& [from, to] : of_stroke) {
      if (to <= end) continue;
      sum += to - (from > end && from - end > kIgnored ? from : end);
      end = to;
    }
  }
  return sum;
}

}  // namespace

DrawnLengths drawn_lengths(const RunData& run, const Promise& promise, const Ending& ending) {
  DrawnLengths out;
  out.asked = promise.asked;
  out.not_drawn = promise.lengths;
  if (promise.unnamed > kIgnored) out.not_drawn["unnamed"] = promise.unnamed;
  double rest = promise.promised - inked_length(run);
  for (const auto& [reason, length] : ending.given_up) {
    const double part = std::clamp(length, 0.0, std::max(0.0, rest));
    if (part > 0.0) out.not_drawn[reason] += part;
    rest -= part;
  }
  if (rest > kIgnored)
    out.not_drawn[ending.end == RunEnd::finished ? "no_ink" : "not_reached"] += rest;
  out.drawn = out.asked;
  for (const auto& [reason, length] : out.not_drawn) out.drawn -= length;
  out.drawn = std::max(0.0, out.drawn);
  return out;
}

std::string length_text(double mm) {
  return mm < 999.5 ? fmt::format("{:.3g} mm", mm) : fmt::format("{:.3g} m", 1e-3 * mm);
}

std::string rest_text(const std::map<std::string, double>& not_drawn_mm) {
  std::vector<std::pair<double, std::string>> parts;
  for (const auto& [reason, mm] : not_drawn_mm) parts.emplace_back(-mm, reason);
  std::sort(parts.begin(), parts.end());
  std::string text;
  for (auto& [mm, reason] : parts) {
    if (reason == "off_canvas") reason = "edge";
    std::replace(reason.begin(), reason.end(), '_', ' ');
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", reason, length_text(-mm));
  }
  return text;
}

}  // namespace impedraw
