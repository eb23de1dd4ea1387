// Franka's arm (FR3) through its control interface, driven by torque alone: fci_link.h, and
// the session of arm_session.h from the first torque on.
//
// Start    The arm's own URDF, which it sends, must have our model's kinematics, and must allow
//          what our model allows. The motion begins with the first command(): the arm does not
//          wait for a log to be opened.
// Clock    ArmSettings::clock: states count milliseconds. An arm that misses twenty answers in a
//          row stops by a reflex, so the loop must not pause, except where a simulator waits.
// Torque   without gravity: the arm adds its own. At most 900 Nm/s for each state answered: it
//          stops at 1000.
// Reflex   A fault that names the arm's errors. recover() asks the arm to clear it, unless
//          something was touched (fci_collision).
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "impedraw/arm/arm_model.h"
#include "impedraw/drivers/arm_session.h"
#include "impedraw/drivers/fci_link.h"
#include "impedraw/experiment/scenario.h"

namespace impedraw {

class FrankaFci : public ForeignArm {
 public:
  static constexpr double kRecovery = 5.0;  // for the arm to clear a reflex [s]
  static constexpr double kRest = 1.0;      // after it, to come to rest [s]

  // start_q: where the arm must stand at start(), within kStartTolerance; nothing: anywhere. `arm`
  // must outlive the driver. Throws InputError if it has not seven joints, or the url is invalid.
  FrankaFci(const ArmSettings& settings, const ArmModel& arm, double period,
            std::optional<JointVector> start_q);
  ~FrankaFci() override;

  DriverInfo info() const override;
  void start() override;
  const ArmState& read() noexcept override;
  void command(const JointVector& tau, const JointVector& gravity) noexcept override;
  void stop() noexcept override;
  bool recover(JointVector* q) noexcept override;

  void hold() noexcept override;
  void observe(double seconds, const Seen& seen) override;

 private:
  void connect();
  void await_state();
  void require_same_arm();
  void begin_motion();
  bool receive(double until) noexcept override;
  void send(const JointVector& wanted, bool stale) noexcept override;
  bool reachable() const noexcept override { return moving_; }
  void end_motion() noexcept;
  void note_fault(const std::string& cause) noexcept;

  ArmModel arm_;
  std::unique_ptr<FciLink> link_;
  std::uint32_t motion_ = 0;             // id of the Move request
  bool moving_ = false, holds_ = false;  // moving: there is a session
  bool reflex_ = false;                  // the fault is one
  FciState last_;
};

// Throws InputError, which names what differs, unless the arm's own URDF and the model are of the
// same arm: at random postures the tip stands still on the arm's last link, and the model allows no
// range, torque or speed that the arm does not.
void require_same_arm(const std::string& urdf_of_arm, ArmModel model);

}  // namespace impedraw
