// The figures of a run of the force benchmark. The force is that of a sensor under the workpiece:
// the true contact force along the true normal, where a simulator gives it.
//
//   settling_time  from the end of a change of the command until the force stays within 5 % of the
//                  change, and at least 0.1 N, of the command [s]; until = the next change
//   overshoot      greatest excess over the command after a change, as a share of the change
//   steady_error   |mean of force − command| in a steady window [N]
//   rms            of force − command from the first to the last instant judged [N]
//   sd             standard deviation of force − command in a steady window [N]
//   bandwidth      at which the amplitude of force/command has fallen to 1/√2 in a sweep [Hz];
//                  the sweep's end if it never does
//   work_lost      ∫ max(0, command − force) |v_t| dt, v_t along the surface: what a tool that
//                  takes work along its way does less than asked [J]
//
// A run with several changes and windows counts the worst. A metric that a case does not ask for is
// absent; so is a settling time of a force that does not settle.
//
// Names after NISTIR 8097 (Falco, Marvel, Norcross, Van Wyk, 2016). Definitions are ours.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

namespace impedraw {

struct JudgedSample {
  double time;   // [s]
  double asked;  // command [N]
  double force;  // under the workpiece [N]
  double speed;  // of the tip along the surface [m/s]
};

// Logarithmic sweep
//   asked = mean + amplitude sin φ(t),  f(t) = from (to/from)^((t − start)/duration)
struct ForceSweep {
  double start = 0.0, duration = 10.0;  // [s]
  double from = 0.5, to = 50.0;         // [Hz]
  double mean = 6.0, amplitude = 2.0;   // [N]

  double frequency(double t) const noexcept;  // [Hz]
  double phase(double t) const noexcept;      // φ [rad]
  double at(double t) const noexcept;         // [N]
  double rate(double t) const noexcept;       // its derivative [N/s]
};

// A change of the command, from before to after, that ends at `at`; judged until `until`.
struct ForceChange {
  double at, until;      // [s]
  double before, after;  // [N]
};

struct ForceWindow {
  double from, to;  // [s]
};

struct ForceQuestion {
  double from = 0.0, to = 0.0;       // judged [s]
  std::vector<ForceChange> changes;  // settling_time, overshoot
  std::vector<ForceWindow> steady;   // steady_error, sd
  std::optional<ForceSweep> sweep;   // bandwidth
  bool moves = false;                // work_lost
};

enum ForceMetric {
  kSettlingTime,
  kOvershoot,
  kSteadyError,
  kRms,
  kSd,
  kBandwidth,
  kWorkLost,
  kForceMetrics
};
inline constexpr std::array<std::string_view, kForceMetrics> kForceMetricNames = {
    "settling_time", "overshoot", "steady_error", "rms", "sd", "bandwidth", "work_lost"};
// True if a greater value is the better one.
inline constexpr bool greater_is_better(int metric) { return metric == kBandwidth; }

struct ForceMetrics {
  std::array<std::optional<double>, kForceMetrics> value;
};

// Samples in the order of time. Without one in the window judged, every metric is absent.
ForceMetrics judge_force(const std::vector<JudgedSample>& record, const ForceQuestion& question);

}  // namespace impedraw
