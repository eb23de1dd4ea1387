// Watchdog for the step times of a control loop. It reads no clock: the caller passes the times.
#pragma once

namespace impedraw {

struct WatchdogSettings {
  double limit = 1e-3;  // a step that takes longer is late [s]
  int late_in_row = 5;  // number of consecutive late steps that trip the watchdog
  double stall = 0.02;  // a single step of this length trips it too [s]
};

class StepWatchdog {
 public:
  explicit StepWatchdog(const WatchdogSettings& settings = {}) : settings_(settings) {}

  // Call after each step. Returns true once tripped, until reset().
  bool update(double step_time) noexcept {
    const bool late = !(step_time <= settings_.limit);
    in_row_ = late ? in_row_ + 1 : 0;
    late_ += late;
    tripped_ |= in_row_ >= settings_.late_in_row || !(step_time < settings_.stall);
    return tripped_;
  }
  bool tripped() const noexcept { return tripped_; }
  long late() const noexcept { return late_; }  // number of late steps so far
  void reset() noexcept { *this = StepWatchdog(settings_); }

 private:
  WatchdogSettings settings_;
  int in_row_ = 0;
  long late_ = 0;
  bool tripped_ = false;
};

}  // namespace impedraw
