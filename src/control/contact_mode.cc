#include "impedraw/control/contact_mode.h"

#include <algorithm>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/control/describe_control.h"

namespace impedraw {

namespace {

using Mode = ContactMode;

// Events derived from the evidence, one bit each.
enum Event : unsigned {
  kPenUp = 1,
  kApproachable = 2,
  kTouch = 4,
  kTouchLost = 8,
  kSurfaceLost = 16,
  kClear = 32
};

struct Transition {
  Mode from;
  unsigned event;
  Mode to;
};

constexpr Transition kTable[] = {
    // the first match applies
    {Mode::free, kApproachable, Mode::approach},   {Mode::approach, kPenUp, Mode::lift},
    {Mode::approach, kSurfaceLost, Mode::retreat}, {Mode::approach, kTouch, Mode::contact},
    {Mode::contact, kPenUp, Mode::lift},           {Mode::contact, kSurfaceLost, Mode::retreat},
    {Mode::contact, kTouchLost, Mode::approach},   {Mode::lift, kClear, Mode::free},
    {Mode::lift, kApproachable, Mode::approach},   {Mode::retreat, kPenUp, Mode::free},
};

}  // namespace

void ContactSettings::validate() const {
  require_ranges("control.contact", *this);
  if (!(leave_distance > enter_distance))
    throw InputError(
        "contact.leave_distance must lie above contact.enter_distance: without hysteresis the "
        "contact chatters");
}

ContactStates::ContactStates(const ContactSettings& settings, double dt)
    : settings_(settings), dt_(dt) {
  settings_.validate();
}

void ContactStates::reset() noexcept {
  mode_ = Mode::free;
  time_without_force_ = time_without_surface_ = distance_at_touch_ = 0.0;
}

ContactMode ContactStates::next(const ContactEvidence& e) noexcept {
  time_without_surface_ = e.surface_known ? 0.0 : time_without_surface_ + dt_;
  const bool no_force = e.wrench_known && e.normal_force < settings_.loss_force;
  time_without_force_ = mode_ == Mode::contact && no_force ? time_without_force_ + dt_ : 0.0;

  constexpr double kFollows = 0.3;  // [s]
  if (e.carried && e.surface_known && mode_ == Mode::contact && e.wrench_known && !no_force)
    distance_at_touch_ += dt_ / kFollows * (e.distance - distance_at_touch_);

  // A hand that lifts the pen is quicker than a cloud's error changes along a line.
  if (mode_ == Mode::contact && e.surface_known && e.wrench_known && !no_force)
    felt_ = felt_ ? *felt_ + dt_ / kFollows * (e.distance - *felt_) : e.distance;
  const double search = e.carried ? settings_.search_distance
                        : felt_   ? std::max(0.0, *felt_) + settings_.search_distance
                                  : settings_.first_search_distance;
  const bool near =
      e.surface_known && e.distance < (e.wrench_known ? search : settings_.enter_distance);
  const bool held = e.wrench_known ? e.normal_force > settings_.touch_force
                                   : e.approach_gap > settings_.touch_gap;
  const double error = mode_ == Mode::contact ? distance_at_touch_ : 0.0;
  const bool far = e.surface_known && e.distance - error > settings_.leave_distance;
  const bool lost_for_long = time_without_surface_ > settings_.lost_surface_time;

  unsigned events = 0;
  if (!e.pen_down) events |= kPenUp;
  if (e.pen_down && e.surface_known && !e.wrench_lost) events |= kApproachable;
  if (near && held) events |= kTouch;
  if (far || time_without_force_ > settings_.loss_time) events |= kTouchLost;
  const bool deep =
      mode_ == Mode::contact && e.surface_known && e.distance - error < -settings_.deepest;
  if (lost_for_long || e.wrench_lost || deep) events |= kSurfaceLost;
  if (!e.pen_down && (far || lost_for_long)) events |= kClear;

  for (const Transition& t : kTable) {
    if (t.from != mode_ || !(events & t.event)) continue;
    mode_ = t.to;
    time_without_force_ = 0.0;
    if (mode_ == Mode::contact) distance_at_touch_ = e.wrench_known ? e.distance : 0.0;
    break;
  }
  return mode_;
}

}  // namespace impedraw
