#include "impedraw/judge/force_metrics.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include <Eigen/Cholesky>
#include <Eigen/Core>

namespace impedraw {
namespace {

constexpr double kBand = 0.05, kLeastBand = 0.1;  // of a change; [N]
constexpr double kLeastCycles = 2.5;              // of a sweep, in one fit
constexpr int kFits = 121;                        // over a sweep

using Samples = std::span<const JudgedSample>;

Samples within(const std::vector<JudgedSample>& record, double from, double to) {
  const auto before = [](const JudgedSample& s, double t) { return s.time < t; };
  const auto begin = std::lower_bound(record.begin(), record.end(), from, before);
  const auto end = std::lower_bound(begin, record.end(), to, before);
  return {begin, end};
}

// Time after which the force stays in the band; absent if it leaves it within the last tenth.
std::optional<double> settling_time(Samples samples, const ForceChange& change) {
  const double band = std::max(kBand * std::abs(change.after - change.before), kLeastBand);
  double out_at = change.at;
  for (const JudgedSample& s : samples)
    if (std::abs(s.force - s.asked) > band) out_at = s.time;
  if (samples.empty() || out_at > change.until - 0.1 * (change.until - change.at))
    return std::nullopt;
  return out_at - change.at;
}

double overshoot(Samples samples, const ForceChange& change) {
  const double size = change.after - change.before;
  double most = 0.0;
  for (const JudgedSample& s : samples) most = std::max(most, (s.force - s.asked) / size);
  return most;
}

struct Moments {
  double mean, sd, rms;
};

Moments error_moments(Samples samples) {
  double sum = 0.0, squares = 0.0;
  for (const JudgedSample& s : samples) {
    sum += s.force - s.asked;
    squares += (s.force - s.asked) * (s.force - s.asked);
  }
  const double n = static_cast<double>(samples.size()), mean = sum / n;
  return {mean, std::sqrt(std::max(0.0, squares / n - mean * mean)), std::sqrt(squares / n)};
}

// |force/command| at the time t of a sweep: least squares of a + b t + c sin φ + d cos φ.
std::optional<double> gain_at(const std::vector<JudgedSample>& record, const ForceSweep& sweep,
                              double t) {
  const double half = 0.5 * kLeastCycles / sweep.frequency(t);
  if (t - half < sweep.start || t + half > sweep.start + sweep.duration) return std::nullopt;
  Eigen::Matrix4d A = Eigen::Matrix4d::Zero();
  Eigen::Vector4d y = Eigen::Vector4d::Zero();
  for (const JudgedSample& s : within(record, t - half, t + half)) {
    const double phase = sweep.phase(s.time);
    const Eigen::Vector4d x(1.0, (s.time - t) / half, std::sin(phase), std::cos(phase));
    A += x * x.transpose();
    y += s.force * x;
  }
  return A.ldlt().solve(y).tail<2>().norm() / sweep.amplitude;
}

std::optional<double> bandwidth(const std::vector<JudgedSample>& record, const ForceSweep& sweep) {
  std::optional<double> last_gain;
  double last_frequency = 0.0;
  for (int i = 0; i < kFits; ++i) {
    const double t = sweep.start + sweep.duration * i / (kFits - 1);
    const std::optional<double> gain = gain_at(record, sweep, t);
    if (!gain) continue;
    const double f = sweep.frequency(t);
    if (*gain < std::numbers::sqrt2 / 2.0) {
      if (!last_gain) return f;
      const double share = (*last_gain - std::numbers::sqrt2 / 2.0) / (*last_gain - *gain);
      return last_frequency * std::pow(f / last_frequency, share);
    }
    last_gain = gain;
    last_frequency = f;
  }
  return last_gain ? std::optional(last_frequency) : std::nullopt;
}

double work_lost(Samples samples) {
  double work = 0.0;
  for (std::size_t i = 1; i < samples.size(); ++i)
    work += std::max(0.0, samples[i].asked - samples[i].force) * samples[i].speed *
            (samples[i].time - samples[i - 1].time);
  return work;
}

void keep_worst(double value, std::optional<double>* worst) {
  if (!*worst || std::abs(value) > std::abs(**worst)) *worst = value;
}

}  // namespace

double ForceSweep::frequency(double t) const noexcept {
  return from * std::pow(to / from, (t - start) / duration);
}

double ForceSweep::phase(double t) const noexcept {
  return 2.0 * std::numbers::pi * duration / std::log(to / from) * (frequency(t) - from);
}

double ForceSweep::at(double t) const noexcept { return mean + amplitude * std::sin(phase(t)); }

double ForceSweep::rate(double t) const noexcept {
  return amplitude * 2.0 * std::numbers::pi * frequency(t) * std::cos(phase(t));
}

ForceMetrics judge_force(const std::vector<JudgedSample>& record, const ForceQuestion& question) {
  ForceMetrics found;
  const Samples judged = within(record, question.from, question.to);
  if (judged.empty()) return found;
  found.value[kRms] = error_moments(judged).rms;
  bool settles = true;
  for (const ForceChange& change : question.changes) {
    const Samples after = within(record, change.at, change.until);
    keep_worst(overshoot(after, change), &found.value[kOvershoot]);
    const std::optional<double> time = settling_time(after, change);
    settles = settles && time;
    if (time) keep_worst(*time, &found.value[kSettlingTime]);
  }
  if (!settles) found.value[kSettlingTime].reset();
  for (const ForceWindow& window : question.steady) {
    const Samples samples = within(record, window.from, window.to);
    if (samples.empty()) continue;
    const Moments moments = error_moments(samples);
    keep_worst(std::abs(moments.mean), &found.value[kSteadyError]);
    keep_worst(moments.sd, &found.value[kSd]);
  }
  if (question.sweep) found.value[kBandwidth] = bandwidth(record, *question.sweep);
  if (question.moves) found.value[kWorkLost] = work_lost(judged);
  return found;
}

}  // namespace impedraw
