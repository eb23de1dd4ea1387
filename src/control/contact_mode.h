// State machine of the pen's contact with the surface.
//
//   free              ──pen down desired, surface known──> approach
//   approach          ──touch──>                           contact
//   contact           ──touch lost──>                      approach
//   approach, contact ──pen up desired──>                  lift
//   lift              ──clear of the surface──>            free
//   lift              ──pen down desired, surface known──> approach
//   approach, contact ──surface or wrench lost──>          retreat
//   retreat           ──pen up desired──>                  free
//
// A pen deeper than `deepest` beneath the surface as estimated, less the error found at touch,
// counts as surface lost.
// Touch requires the tip to be near the estimated surface *and* something to hold it. With a
// measured wrench, that is a normal force within `search_distance` of where the surface was felt
// last, or within `first_search_distance` of the estimate. Without one, it is a tip that
// no longer follows the approach, within `enter_distance`. Distance alone would start the push
// before touch, with a force peak of twice the push. The distance at a measured touch is treated as
// an error of the estimate or of the pen's length, and is subtracted until the touch is lost; on a
// canvas that is followed it is one of the forecast, and is found anew all the time, with a time
// constant of 0.3 s. Touch
// is lost beyond `leave_distance` (hysteresis) or after `loss_time` without measured force.
#pragma once

#include <optional>
#include <string_view>

namespace impedraw {

enum class ContactMode { free, approach, contact, lift, retreat };
inline constexpr std::string_view kContactModeNames[] = {"free", "approach", "contact", "lift",
                                                         "retreat"};

struct ContactSettings {
  double enter_distance = 1.0e-3;   // tip to estimated surface [m]
  double search_distance = 4.0e-3;  // the same, with a measured wrench [m]
  // The same, before the first touch: cameras that agree may err together [m].
  double first_search_distance = 4.0e-3;
  double leave_distance = 2.5e-3;  // [m], > enter_distance
  double touch_force = 0.3;        // measured, along n [N]
  double touch_gap = 0.8e-3;  // lag of the tip behind the approach at touch, without a wrench [m]
  double loss_force = 0.05;   // measured, along n [N]
  double loss_time = 0.03;    // time below loss_force after which touch is lost [s]
  // time for which the last normal is used while perception has none [s]
  double lost_surface_time = 0.25;
  // Deeper beneath the estimated surface than where it was touched, the pen is on no surface that
  // perception knows: off an edge, or down a wall. What is soft at its end adds its own way [m].
  double deepest = 6.0e-3;

  // Throws InputError for a value out of range, and if there is no hysteresis.
  void validate() const;
};

// Inputs of one step.
struct ContactEvidence {
  bool pen_down = false;  // desired by the plan
  bool surface_known = false;
  double distance = 0.0;  // to the estimated surface [m]
  bool wrench_known = false;
  bool wrench_lost = false;   // a wrench is expected but stale
  double normal_force = 0.0;  // measured [N]
  double approach_gap = 0.0;  // distance minus the approach's desired distance [m]
  bool carried = false;       // on a canvas that is followed
};

class ContactStates {
 public:
  // dt: step [s]. Throws InputError as ContactSettings::validate() does.
  ContactStates(const ContactSettings& settings, double dt);
  ContactMode next(const ContactEvidence& evidence) noexcept;
  ContactMode mode() const { return mode_; }
  void reset() noexcept;

 private:
  ContactSettings settings_;
  double dt_;
  ContactMode mode_ = ContactMode::free;
  double distance_at_touch_ = 0.0;  // [m]
  std::optional<double> felt_;      // distance at which a force held the tip lately [m]
  double time_without_force_ = 0.0;
  double time_without_surface_ = 0.0;
};

}  // namespace impedraw
