#include "impedraw/metrics/ending.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/ink/ink_lines.h"
#include "impedraw/metrics/metrics.h"

namespace impedraw {
namespace {

constexpr double kIgnored = 1e-3;   // a shorter gap, or rest [m]
constexpr double kRounding = 1e-9;  // of sums of lengths [m]

// Length of the strokes that have ink, as the plan measures them.
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

struct EndName {
  const char *name, *told;
};
constexpr std::array<EndName, 6> kEnds = {
    {{"finished", "finished"},
     {"stopped", "halted"},
     {"interrupted", "stopped by a person"},
     {"nothing_drawn", "nothing drawn"},
     {"far_off", "far off"},
     {"unknown", "not known: the run was killed, or its log is of an older version"}}};

const EndName& of(RunEnd end) { return kEnds[static_cast<std::size_t>(end)]; }

}  // namespace

DrawnLengths drawn_lengths(const RunData& run, const Promise& promise, const Ending& ending) {
  DrawnLengths out;
  out.asked = promise.asked;
  out.not_drawn = promise.lengths;
  if (promise.unnamed > kIgnored) out.not_drawn["unnamed"] = promise.unnamed;
  double rest = promise.promised - promise.flat * inked_length(run);
  for (const auto& [reason, length] : ending.given_up) {
    const double part = std::clamp(promise.flat * length, 0.0, std::max(0.0, rest));
    if (part > 0.0) out.not_drawn[reason] += part;
    rest -= part;
  }
  const bool broken_off = ending.end == RunEnd::stopped || ending.end == RunEnd::interrupted ||
                          ending.end == RunEnd::unknown;
  if (rest > kIgnored) out.not_drawn[broken_off ? "not_reached" : "no_ink"] += rest;
  out.drawn = out.asked;
  for (const auto& [reason, length] : out.not_drawn) out.drawn -= length;
  if (out.drawn < kRounding) out.drawn = 0.0;
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

std::string promise_text(const Promise& p) {
  nlohmann::ordered_json text = {{"asked", p.asked},
                                 {"promised", p.promised},
                                 {"undrawable", p.undrawable},
                                 {"unnamed", p.unnamed},
                                 {"flat", p.flat},
                                 {"problems", p.problems},
                                 {"lengths", p.lengths},
                                 {"asks_ink", p.asks_ink},
                                 {"slope", p.slope},
                                 {"time", p.time},
                                 {"axis", {p.axis_W.x(), p.axis_W.y(), p.axis_W.z()}}};
  if (p.reachable) text["reachable"] = *p.reachable;
  if (p.face > 0.0) text["face"] = p.face;
  return text.dump();
}

std::optional<Promise> read_promise(const std::map<std::string, std::string>& attributes) {
  const auto found = attributes.find(kPromiseAttribute);
  if (found == attributes.end()) return std::nullopt;
  const auto text = nlohmann::json::parse(found->second, nullptr, false);
  try {
    Promise p;
    text.at("asked").get_to(p.asked);
    text.at("promised").get_to(p.promised);
    text.at("undrawable").get_to(p.undrawable);
    text.at("unnamed").get_to(p.unnamed);
    p.flat = text.value("flat", 1.0);
    if (text.contains("reachable")) p.reachable = text["reachable"].get<double>();
    text.at("problems").get_to(p.problems);
    if (text.contains("lengths")) text["lengths"].get_to(p.lengths);
    p.asks_ink = text.value("asks_ink", true);
    p.face = text.value("face", 0.0);
    text.at("slope").get_to(p.slope);
    text.at("time").get_to(p.time);
    for (int i = 0; i < 3; ++i) p.axis_W[i] = text.at("axis").at(i).get<double>();
    return p;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;  // another program's attribute
  }
}

const char* name_of(RunEnd end) noexcept { return of(end).name; }

std::string told(const Ending& ending) {
  return of(ending.end).told + (ending.cause.empty() ? "" : ": " + ending.cause);
}

std::string ending_text(const Ending& e) {
  return nlohmann::ordered_json(
             {{"end", name_of(e.end)}, {"cause", e.cause}, {"given_up", e.given_up}})
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

Ending read_ending(const std::map<std::string, std::string>& attributes) {
  Ending ending{RunEnd::unknown};
  const auto found = attributes.find(kEndingAttribute);
  if (found == attributes.end()) return ending;
  try {
    const auto text = nlohmann::json::parse(found->second);
    for (std::size_t i = 0; i < kEnds.size(); ++i)
      if (text.at("end") == kEnds[i].name) ending.end = static_cast<RunEnd>(i);
    text.at("cause").get_to(ending.cause);
    text.at("given_up").get_to(ending.given_up);
  } catch (const nlohmann::json::exception&) {
    return {RunEnd::unknown};  // another program's attribute
  }
  return ending;
}

Ending judged(Ending ending, const Metrics& m, bool any_ink, const Promise& promise) {
  if (ending.end != RunEnd::finished || !promise.asks_ink) return ending;
  const auto& drawn = m.drawn.value();
  const double promised =
      m.length_promised.value() ? *m.length_promised.value() / *m.length_asked.value() : 1.0;
  if (!any_ink || (drawn && *drawn < kLeastDrawn * promised)) {
    ending.end = RunEnd::nothing_drawn;
    ending.cause =
        any_ink ? fmt::format("less than {:.0f} % of the drawing has ink", 100.0 * kLeastDrawn)
        : m.contact_fraction.value()
            ? "the pen never pressed on the canvas while it should have drawn"
            : "the pen never came to a stroke";
    const std::string rest = rest_text(m.not_drawn_mm);
    if (!rest.empty()) ending.cause += "; not drawn: " + rest;
    return ending;
  }
  // Without an estimate of the surface the set-point lies beneath it: the path is elsewhere.
  const auto& ink = m.ink_error_rms.value();
  const auto& path = m.tracking_error_rms.value();
  const bool ink_off = ink && *ink > kFarOff + 1e3 * promise.face;
  if (!ink_off && !(path && *path > kFarOff && m.normal_error_mean.value())) return ending;
  ending.end = RunEnd::far_off;
  ending.cause = fmt::format("{} is {:.1f} mm (RMS) away from {}, more than {:.0f} mm",
                             ink_off ? "the ink" : "the pen", ink_off ? *ink : *path,
                             ink_off ? "its line" : "its path", kFarOff);
  return ending;
}

}  // namespace impedraw
