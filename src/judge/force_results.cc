#include "impedraw/judge/force_results.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace impedraw {

namespace {

using Json = nlohmann::ordered_json;

Json number(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

Json json_of(const JudgedController& judged) {
  Json runs = Json::array(), mean, worst;
  for (const JudgedRun& run : judged.runs) {
    Json one = {{"seed", run.seed}};
    for (int m = 0; m < kForceMetrics; ++m)
      one[std::string(kForceMetricNames[m])] = number(run.metrics.value[m]);
    if (!run.run.ended.empty()) one["ended"] = run.run.ended;
    runs.push_back(std::move(one));
  }
  for (int m = 0; m < kForceMetrics; ++m) {
    const ForceSummary summary = judged.summary(m);
    mean[std::string(kForceMetricNames[m])] = number(summary.mean);
    worst[std::string(kForceMetricNames[m])] = number(summary.worst);
  }
  return {{"controller", kForceControllerNames[static_cast<int>(judged.controller)]},
          {"runs", std::move(runs)},
          {"mean", std::move(mean)},
          {"worst", std::move(worst)}};
}

}  // namespace

ForceSummary JudgedController::summary(int metric) const {
  ForceSummary found;
  double sum = 0.0, worst = 0.0;
  for (const JudgedRun& run : runs) {
    const std::optional<double>& value = run.metrics.value[metric];
    if (!value) {
      ++found.lacking;
      continue;
    }
    const bool begun = &run != &runs.front();
    sum += *value;
    const bool worse =
        greater_is_better(metric) ? *value < worst : std::abs(*value) > std::abs(worst);
    if (!begun || worse) worst = *value;
  }
  if (runs.empty() || found.lacking > 0) return found;
  found.mean = sum / static_cast<double>(runs.size());
  found.worst = worst;
  return found;
}

std::vector<ForceBehind> behind(const ForceResults& results) {
  std::vector<ForceBehind> found;
  for (int m = 0; m < kForceMetrics; ++m)
    for (const JudgedCase& c : results.cases) {
      const auto ours = std::find_if(
          c.controllers.begin(), c.controllers.end(),
          [](const JudgedController& j) { return j.controller == ForceController::ours; });
      if (ours == c.controllers.end() || ours->runs.empty()) continue;
      const std::optional<double> own = ours->summary(m).mean;
      std::optional<ForceBehind> most;  // behind the better peer
      for (const JudgedController& peer : c.controllers) {
        const std::optional<double> other = peer.summary(m).mean;
        if (&peer == &*ours || !other) continue;
        const auto better = [m](const std::optional<double>& a, const std::optional<double>& b) {
          if (!a || !b) return a.has_value();
          return greater_is_better(m) ? *a > *b : std::abs(*a) < std::abs(*b);
        };
        if (better(other, own) && (!most || better(other, most->theirs)))
          most = ForceBehind{c.what.name, m, peer.controller, own, other};
      }
      if (most) found.push_back(*most);
    }
  return found;
}

std::string shown_metric(int metric, const std::optional<double>& value) {
  if (!value) return "–";
  switch (metric) {
    case kSettlingTime:
      return fmt::format("{:.2f} s", *value);
    case kOvershoot:
      return fmt::format("{:.0f} %", 100.0 * *value);
    case kBandwidth:
      return fmt::format("{:.1f} Hz", *value);
    case kWorkLost:
      return fmt::format("{:.1f} mJ", 1e3 * *value);
    default:
      return fmt::format("{:.2f} N", *value);
  }
}

std::string force_json(const ForceResults& results) {
  Json cases = Json::array(), lines = Json::array();
  for (const JudgedCase& c : results.cases) {
    Json controllers = Json::array();
    for (const JudgedController& judged : c.controllers) controllers.push_back(json_of(judged));
    cases.push_back(
        {{"case", c.what.name}, {"text", c.what.text}, {"controllers", std::move(controllers)}});
  }
  for (const ForceBehind& b : behind(results))
    lines.push_back({{"case", b.name},
                     {"metric", kForceMetricNames[b.metric]},
                     {"peer", kForceControllerNames[static_cast<int>(b.peer)]},
                     {"ours", number(b.ours)},
                     {"theirs", number(b.theirs)}});
  const Json units = {{"settling_time", "s"},
                      {"overshoot", "share of the change"},
                      {"steady_error", "N"},
                      {"rms", "N"},
                      {"sd", "N"},
                      {"bandwidth", "Hz"},
                      {"work_lost", "J"}};
  Json all = {{"simulated", true},
              {"arm", results.arm},
              {"driver", results.driver},
              {"command", results.again},
              {"runs", results.runs},
              {"seconds", results.seconds},
              {"units", units},
              {"cases", std::move(cases)},
              {"behind", std::move(lines)},
              {"left_out", results.left_out}};
  if (!results.ended.empty()) all["ended"] = results.ended;
  return all.dump(1) + "\n";
}

}  // namespace impedraw
