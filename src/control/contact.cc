#include "impedraw/control/contact.h"

#include <algorithm>
#include <utility>

#include "impedraw/control/tip_friction.h"

namespace impedraw {

namespace {

constexpr double kForesees = 0.1;    // to which a carrier's acceleration is known [m/s²]
constexpr double kNoSinking = 0.01;  // rise beyond which an approach does not sink [m/s]
constexpr double kFirm = 0.4;        // share of F_n that outranks where a carrier is thought to be
constexpr double kThere = 3e-3;      // distance that counts then, at most [m]

}  // namespace

SurfaceContact::SurfaceContact(const ImpedanceSettings& s)
    : measured_(s.wrench == WrenchFeedback::measured),
      dt_(s.timing.dt),
      normal_force_(s.normal_force),
      friction_(s.friction),
      approach_(s.approach),
      states_(s.contact, s.timing.dt),
      tracker_(s.surface.normal_bandwidth, s.timing.dt),
      felt_(s.felt_normal, s.timing.dt) {}

void SurfaceContact::reset() noexcept {
  states_.reset();
  felt_.reset();
  now_.mode = ContactMode::free;
  now_.rise = 0.0;
}

const Contact& SurfaceContact::update(const StepInput& in) noexcept {
  SurfaceEstimate surface = in.surface;
  if (surface.status == SurfaceStatus::ok && surface.n_W.dot(in.reference.n_WD) < kOtherSide) {
    surface.n_W = -surface.n_W;
    surface.distance = -surface.distance;
  }
  now_.v_K.setZero();
  if (in.carrier) now_.v_K = in.carrier->velocity_at(in.arm.X_WE.p);
  now_.force = in.reference.force > 0.0 ? in.reference.force : normal_force_;
  now_.force_rate = in.reference.force_rate;
  now_.v = in.arm.V_WE.head<3>() - now_.v_K;
  update_mode(in, surface);
  update_approach(surface);
  update_rise(in);
  update_felt_normal(in.F_ext);
  return now_;
}

// Mode and tracked normal.
void SurfaceContact::update_mode(const StepInput& in, const SurfaceEstimate& surface) noexcept {
  const bool known = surface.status == SurfaceStatus::ok, was_on_surface = now_.on_surface();
  ContactEvidence evidence;
  evidence.pen_down = in.reference.pen_down;
  evidence.surface_known = known;
  evidence.distance = known ? surface.distance : 0.0;
  evidence.wrench_known = measured_;
  evidence.wrench_lost = in.wrench_lost;
  evidence.normal_force =
      measured_ ? in.F_ext.head<3>().dot(was_on_surface ? tracker_.n() : surface.n_W) : 0.0;
  evidence.approach_gap = surface.distance - approach_distance_;
  evidence.carried = in.carrier != nullptr;
  // The estimate of a carrier is late.
  if (in.carrier && evidence.normal_force > kFirm * now_.force)
    evidence.distance = std::clamp(evidence.distance, -kThere, kThere);
  const ContactMode before = now_.mode;
  now_.mode = states_.next(evidence);

  if (now_.on_surface()) {
    if (!was_on_surface) tracker_.reset(in.reference.n_WD, in.reference.w_WD);
    known ? tracker_.update(surface.n_W, in.reference.alpha_WD) : tracker_.coast();
  }
  if (now_.mode == ContactMode::approach && before != now_.mode)
    approach_distance_ = known ? surface.distance : 0.0;
  now_.n_T = tracker_.n();
  now_.w_T = tracker_.w();
  now_.n = now_.on_surface() ? tracker_.n() : in.reference.n_WD;
  now_.surface_lost = in.reference.pen_down && !known && surface.status != SurfaceStatus::none;
}

void SurfaceContact::update_approach(const SurfaceEstimate& surface) noexcept {
  now_.sinking = now_.off_target = 0.0;
  if (now_.mode != ContactMode::approach) return;
  const bool known = surface.status == SurfaceStatus::ok;
  approach_distance_ += now_.rise * dt_;
  // A tip that is held back must not release a wound-up spring.
  if (known && approach_distance_ < surface.distance - approach_.lag) {
    approach_distance_ = surface.distance - approach_.lag;
  } else if (approach_distance_ > -approach_.overtravel && now_.rise < kNoSinking) {
    approach_distance_ -= approach_.speed * dt_;
    now_.sinking = approach_.speed;
  }
  if (known) now_.off_target = approach_distance_ - surface.distance;
}

// The filter is slow enough that the damping along n stays.
void SurfaceContact::update_rise(const StepInput& in) noexcept {
  if (!in.carrier || now_.mode == ContactMode::retreat) {
    carried_ = false;
    now_.rise = 0.0;  // its effect decays with the force carried over at the switch
    return;
  }
  const Eigen::Vector3d lasting = in.carrier->acceleration_at(in.arm.X_WE.p) * dt_;
  const double corrected = now_.n.dot(now_.v_K - v_K_ - lasting), known = kForesees * dt_;
  if (std::exchange(carried_, true)) now_.rise -= corrected - std::clamp(corrected, -known, known);
  v_K_ = now_.v_K;
  const bool touches = now_.mode == ContactMode::contact;
  const double shown = touches ? now_.n.dot(now_.v) : 0.0;
  now_.rise += (touches ? kRiseRate : kApproachRiseRate) * dt_ * (shown - now_.rise);
  now_.rise = std::clamp(now_.rise, -kFastestRise, kFastestRise);
}

void SurfaceContact::update_felt_normal(const Wrench& F_ext) noexcept {
  if (!measured_ || !felt_.in_use() || now_.mode != ContactMode::contact) {
    felt_.reset();
    now_.n_C = now_.n;
    return;
  }
  const Eigen::Vector3d n = felt_.corrected(tracker_.n());  // as felt in the steps before
  felt_.update(n, F_ext.head<3>(), slip_along(n, now_.v, friction_.fade_speed),
               friction_.coefficient, kLeastForce * now_.force);
  now_.n = felt_.corrected(tracker_.n());
  now_.n_C = felt_.seen_from(now_.n);
}

}  // namespace impedraw
