// The states of a pen that comes down, draws and leaves, as a table.
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
// Touch is known when the tip is near the estimated surface *and* something holds it: the measured
// force along the normal, within `search_distance`, or, without a wrench, the tip that no longer
// follows the approach, within `enter_distance`. Distance alone would push before touch: a peak of
// twice the push. What the distance reads at a measured touch is taken for the error of the
// estimate, or of the pen's length, and counts no more until the touch is lost: beyond
// `leave_distance` (hysteresis), or after `loss_time` without measured force.
#pragma once

#include <string_view>

namespace impedraw {

enum class ContactMode { free, approach, contact, lift, retreat };
inline constexpr std::string_view kContactModeNames[] = {"free", "approach", "contact", "lift",
                                                         "retreat"};

struct ContactSettings {
  double enter_distance = 1.0e-3;   // tip to estimated surface [m]
  double search_distance = 4.0e-3;  // the same with a measured wrench [m]
  double leave_distance = 2.5e-3;   // [m], > enter_distance
  double touch_force = 0.3;         // measured, along n [N]
  double touch_gap = 0.8e-3;  // without a wrench: how far the tip stays behind the approach [m]
  double loss_force = 0.05;   // measured, along n [N]
  double loss_time = 0.03;    // below loss_force for so long: lost [s]
  // how long the last normal is trusted when perception has none [s]
  double lost_surface_time = 0.25;

  void validate() const;  // throws InputError where there is no hysteresis
};

// What one step knows of the contact.
struct ContactEvidence {
  bool pen_down = false;  // desired by the plan
  bool surface_known = false;
  double distance = 0.0;  // to the estimated surface [m]
  bool wrench_known = false;
  bool wrench_lost = false;   // it should be there, and is stale
  double normal_force = 0.0;  // measured [N]
  double approach_gap = 0.0;  // distance minus the one that the approach asks for [m]
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
  double time_without_force_ = 0.0;
  double time_without_surface_ = 0.0;
};

}  // namespace impedraw
