// A driver for tests of what drives an arm.
#pragma once

#include <stdexcept>
#include <string>

#include "impedraw/run/simulated_arm.h"

namespace impedraw {

// The simulated arm with a test's modifications. Records the order of the calls.
class TestDriver : public Driver {
 public:
  explicit TestDriver(Prepared& e)
      : inner_(e, e.belief.start_q, Disturbances(e.scenario, e.plan.path)), info_(inner_.info()) {}

  DriverInfo info() const override { return info_; }
  void start() override {
    called("start");
    if (!start_failure.empty()) throw std::runtime_error(start_failure);
    inner_.start();
  }
  const ArmState& read() noexcept override {
    called("read");
    const ArmState& state = inner_.read();
    if (fault_time >= 0.0 && state.time >= fault_time) fault_ = "the cable was pulled";
    return state;
  }
  void command(const JointVector& tau, const JointVector& gravity) noexcept override {
    called("command");
    finite &= tau.allFinite() && gravity.allFinite();
    last_tau = tau;
    last_gravity = gravity;
    inner_.command(tau, gravity);
  }
  const std::string& fault() const noexcept override {
    return fault_.empty() ? inner_.fault() : fault_;
  }
  void stop() noexcept override {
    called("stop");
    inner_.stop();
  }
  const GroundTruth* truth() const noexcept override { return truthful ? inner_.truth() : nullptr; }

  DriverInfo& changed_info() { return info_; }
  SimulatedArm& inner() { return inner_; }

  bool truthful = true, finite = true;
  double fault_time = -1.0;
  std::string start_failure;
  std::string order;  // "start (read command)* read stop", where it is kept
  JointVector last_tau, last_gravity;

 private:
  void called(const char* what) {
    const std::string name = what;
    // read after read or command after command would show
    if (name == last_ || order.empty() || name == "start" || name == "stop") order += name + " ";
    last_ = name;
  }

  SimulatedArm inner_;
  DriverInfo info_;
  std::string fault_, last_;
};

}  // namespace impedraw
