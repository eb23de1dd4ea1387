// Keeps the desired force continuous where the law switches: the difference is carried over and
// decays with `switch_time`.
//
// Law   F' = F + C,   C ← (F + F_push)_last − (F + F_push) at a switch of the contact's mode,
//       where F_last contains C,   then C ← C (1 − Δt/T) after each step
#pragma once

#include <algorithm>

#include "impedraw/common/pose.h"
#include "impedraw/control/contact_mode.h"

namespace impedraw {

class Handover {
 public:
  // Time constant T and step [s].
  Handover(double switch_time, double dt) : decay_(std::max(0.0, 1.0 - dt / switch_time)) {}

  // Returns `force` plus the carried force. `push` has its own column in the torque, so that it is
  // not part of the result. [N, Nm]
  Vector6 smooth(ContactMode mode, const Vector6& force, const Vector6& push) noexcept {
    if (mode != last_mode_ || from_zero_) carried_ = last_ - (force + push);
    from_zero_ = false;
    last_mode_ = mode;
    last_ = force + push + carried_;
    const Vector6 continuous = force + carried_;
    carried_ *= decay_;
    return continuous;
  }

  // C of the next step, if there is no switch.
  const Vector6& carried() const noexcept { return carried_; }

  // Forgets the force. The next one starts at once, or grows from zero.
  void reset(bool from_zero) noexcept {
    last_mode_ = ContactMode::free;
    carried_.setZero();
    last_.setZero();
    from_zero_ = from_zero;
  }

 private:
  double decay_;
  ContactMode last_mode_ = ContactMode::free;
  bool from_zero_ = false;
  Vector6 carried_ = Vector6::Zero();
  Vector6 last_ = Vector6::Zero();  // force and push of the last step, C included
};

}  // namespace impedraw
