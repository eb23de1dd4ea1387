#include "impedraw/control/impedance_settings.h"

#include "impedraw/common/pose.h"
#include "module.h"
#include "record.h"

namespace impedraw::python {

void bind_control_settings(nb::module_& m) {
  nb::enum_<InertiaShaping>(m, "InertiaShaping", "How the desired inertia M_d is chosen.")
      .value("natural", InertiaShaping::natural, "M_d = Λ; required without a measured wrench")
      .value("scaled", InertiaShaping::scaled, "M_d = c Λ")
      .value("shaped", InertiaShaping::shaped, "M_d constant in the surface frame")
      .value("light_normal", InertiaShaping::light_normal,
             "M_d = S Λ S, S = I − (1 − √c) n nᵀ: natural, but lighter along the normal");
  nb::enum_<WrenchFeedback>(m, "WrenchFeedback", "Whether F_ext is known.")
      .value("none", WrenchFeedback::none)
      .value("measured", WrenchFeedback::measured);
  nb::enum_<ErrorProjection>(m, "ErrorProjection",
                             "Projection of the position error (13) onto the tangent plane.")
      .value("lifted", ErrorProjection::lifted)
      .value("paper", ErrorProjection::paper);
  nb::enum_<PenAxis>(m, "PenAxis", "Direction of the pen's axis in approach and contact.")
      .value("surface", PenAxis::surface, "along the estimated normal at the tip")
      .value("plan", PenAxis::plan, "along the plan's");

  Record<Pose>(m, "Pose", "X_AB: coordinates in B to coordinates in A, p_A = R p_B + p.")
      .field("p", &Pose::p, "p_AB, shape (3,) [m]")
      .field("R", &Pose::R, "R_AB, shape (3, 3), a rotation")
      .done();
  Record<AxialGain>(m, "AxialGain", "A gain in the surface frame, equal along both tangents.")
      .field("tangent", &AxialGain::tangent, "along both tangents, or about them")
      .field("normal", &AxialGain::normal, "along the normal, or about it")
      .done();
  Record<TipGain>(m, "TipGain", "A 6×6 gain, block-diagonal in its linear and angular parts.")
      .field("linear", &TipGain::linear, "N/m, N s/m or kg")
      .field("angular", &TipGain::angular, "Nm/rad, Nm s/rad or kg m²")
      .done();
  Record<TimingSettings>(m, "TimingSettings", "Delays of inputs and torque.")
      .field("dt", &TimingSettings::dt, "step [s], above 0 to 0.1")
      .field("loop_delay", &TimingSettings::loop_delay,
             "greatest age of the state while its torque acts [s], 0 to 0.021")
      .field("wrench_delay", &TimingSettings::wrench_delay,
             "age of F_ext as passed to step() [s], 0 to 1")
      .field("velocity_age", &TimingSettings::velocity_age,
             "age of v as passed to step() [s], 0 to 0.1")
      .field("velocity_lag", &TimingSettings::velocity_lag,
             "lag of an estimated v to what its model does not explain [s], 0 to 1.1")
      .field("max_state_age", &TimingSettings::max_state_age, "an older state is stale [s], 0 to 1")
      .field("max_wrench_age", &TimingSettings::max_wrench_age,
             "an older wrench is stale [s], 0 to 1")
      .done();
  Record<SurfaceSettings>(m, "SurfaceSettings", "Use of the estimated surface in the law.")
      .field("projection", &SurfaceSettings::projection, "of the position error (13)")
      .field("drawing_axis_W", &SurfaceSettings::drawing_axis_W,
             "z, unit, out of the drawing plane, shape (3,), W")
      .field("min_axis_cosine", &SurfaceSettings::min_axis_cosine,
             "least |n·z| for lifting an error along z, above 0 to 1")
      .field("pen_axis", &SurfaceSettings::pen_axis, "direction of the pen's axis")
      .field("normal_bandwidth", &SurfaceSettings::normal_bandwidth,
             "of the tracker of the surface normal [rad/s], 1 to 500")
      .done();
  Record<ApproachSettings>(m, "ApproachSettings", "Motion towards the surface and away from it.")
      .field("speed", &ApproachSettings::speed, "along −n [m/s], 0.0001 to 0.2")
      .field("overtravel", &ApproachSettings::overtravel,
             "the approach ends this far beneath the estimated surface [m], 0 to 0.5")
      .field("lag", &ApproachSettings::lag,
             "the approach waits if the tip lags by more [m], 0.0001 to 0.05")
      .field("retreat_height", &ApproachSettings::retreat_height,
             "above the plan, after surface or wrench is lost [m], 0 to 0.5")
      .done();
  Record<ContactSettings>(m, "ContactSettings", "When touch is found and lost.")
      .field("enter_distance", &ContactSettings::enter_distance,
             "tip to estimated surface [m], 0 to 0.05")
      .field("search_distance", &ContactSettings::search_distance,
             "the same, with a measured wrench [m], 0 to 0.05")
      .field("first_search_distance", &ContactSettings::first_search_distance,
             "the same, before the first touch [m], 0 to 0.05")
      .field("leave_distance", &ContactSettings::leave_distance,
             "[m], above enter_distance, to 0.1")
      .field("touch_force", &ContactSettings::touch_force, "measured, along n [N], 0 to 50")
      .field("touch_gap", &ContactSettings::touch_gap,
             "lag of the tip at touch, without a wrench [m], 0.00001 to 0.02")
      .field("loss_force", &ContactSettings::loss_force, "measured, along n [N], 0 to 50")
      .field("loss_time", &ContactSettings::loss_time,
             "time below loss_force after which touch is lost [s], 0 to 5")
      .field("lost_surface_time", &ContactSettings::lost_surface_time,
             "time for which the last normal is used [s], 0 to 5")
      .done();
  Record<TipSettings>(m, "TipSettings", "Model of the pen tip.")
      .field("radius", &TipSettings::radius, "of the tip sphere [m], 0 to 0.05")
      .field("stiffness", &TipSettings::stiffness, "along the normal [N/m]; 0: rigid")
      .done();
  Record<FrictionSettings>(m, "FrictionSettings",
                           "What contact at the tip may add to a measured wrench besides the force "
                           "along n.")
      .field("coefficient", &FrictionSettings::coefficient, "μ̂, 0 to 3")
      .field("normal_error_deg", &FrictionSettings::normal_error_deg,
             "the estimated normal may err by this [deg], 0 to 60")
      .field("feedforward", &FrictionSettings::feedforward,
             "μ̂ of the feedforward used without a measured wrench, 0 to 3")
      .field("fade_speed", &FrictionSettings::fade_speed,
             "friction fades out below this speed [m/s], above 0")
      .done();
  Record<ObserverSettings>(m, "ObserverSettings",
                           "Momentum observer: the torque that the arm's model does not explain.")
      .field("enabled", &ObserverSettings::enabled, "needs a measured wrench")
      .field("bandwidth", &ObserverSettings::bandwidth, "K_o [rad/s], 1 to 900")
      .field("limit", &ObserverSettings::limit, "of each |r_j| [Nm], 0 to 1000")
      .field("yield_limit", &ObserverSettings::yield_limit, "n entries [Nm]; empty: no such bound")
      .done();
  Record<ForceIntegralSettings>(m, "ForceIntegralSettings",
                                "Slow, bounded integral of the force error.")
      .field("enabled", &ForceIntegralSettings::enabled, "needs a measured wrench")
      .field("rate", &ForceIntegralSettings::rate, "of push per force error [1/s], 0.01 to 50")
      .field("limit", &ForceIntegralSettings::limit, "± [N], 0 to 50")
      .done();
  Record<StabilityCheckSettings>(m, "StabilityCheckSettings",
                                 "What set-up checks the force loop for.")
      .field("contact_stiffness_max", &StabilityCheckSettings::contact_stiffness_max,
             "stiffest contact [N/m], 1 to 1e7")
      .field("natural_mass_max", &StabilityCheckSettings::natural_mass_max,
             "Λ along the normal [kg], 0.1 to 1000")
      .done();
  Record<OperationalSpaceSettings>(m, "OperationalSpaceSettings",
                                   "Where a direction of the tip counts as lost.")
      .field("max_effective_mass", &OperationalSpaceSettings::max_effective_mass, "[kg]")
      .field("characteristic_length", &OperationalSpaceSettings::characteristic_length,
             "[m]; converts an inertia I to a comparable mass, I / length²")
      .done();
  Record<NullSpaceSettings>(m, "NullSpaceSettings", "τ_null = K_q (q_0 − q) − D_q v + τ_limit.")
      .field("stiffness", &NullSpaceSettings::stiffness,
             "K_q, n entries [Nm/rad]; empty: 10 on each joint")
      .field("damping_ratio", &NullSpaceSettings::damping_ratio, "ζ, 0 to 3")
      .field("q_0", &NullSpaceSettings::q_0,
             "rest posture (14), n entries [rad]; empty: the middle of each joint's range")
      .done();
  Record<JointRangeSettings>(m, "JointRangeSettings",
                             "Near the ends of a joint's range τ_limit pushes it back.")
      .field("lower", &JointRangeSettings::lower, "n entries [rad]; empty: no limits")
      .field("upper", &JointRangeSettings::upper, "n entries [rad]; empty: no limits")
      .field("margin", &JointRangeSettings::margin, "where τ_limit starts [rad], 0.001 to 1")
      .field("torque", &JointRangeSettings::torque,
             "τ_limit at the end of the range [Nm], 0 to 300")
      .done();
  Record<LimitSettings>(m, "LimitSettings",
                        "Limits on commanded torque and on the tip's speed and turning.")
      .field("torque", &LimitSettings::torque, "±, n entries [Nm]; empty: 1000 on each joint")
      .field("torque_rate", &LimitSettings::torque_rate, "±, n entries [Nm/s]; empty: none")
      .field(
          "joint_speed", &LimitSettings::joint_speed,
          "± that V_d + B⁻¹ K e may ask for, and above which a joint is damped, n entries [rad/s]; "
          "empty: none")
      .field("tip_speed", &LimitSettings::tip_speed, "of V_d + B⁻¹ K e [m/s], 0.001 to 5")
      .field("turn_speed", &LimitSettings::turn_speed, "the same [rad/s], 0.01 to 50")
      .done();
  Record<ImpedanceSettings>(
      m, "ImpedanceSettings",
      "Settings of the impedance controller, in groups. Gains are given in the surface frame S,\n"
      "z = n. A vector has one entry per joint; an empty one selects its default.")
      .field("timing", &ImpedanceSettings::timing, "delays of inputs and torque")
      .field("inertia", &ImpedanceSettings::inertia, "how M_d of (1) is chosen")
      .field("wrench", &ImpedanceSettings::wrench, "whether F_ext is known")
      .field("stiffness", &ImpedanceSettings::stiffness, "K of (1): [N/m], [Nm/rad]")
      .field("reference_stiffness", &ImpedanceSettings::reference_stiffness,
             "damping of an axis with zero stiffness: [N/m], [Nm/rad]")
      .field("shaped_inertia", &ImpedanceSettings::shaped_inertia, "M_d if shaped: [kg], [kg m²]")
      .field("inertia_scale", &ImpedanceSettings::inertia_scale,
             "c of M_d = c Λ or of S, 0.01 to 100")
      .field("damping_ratio", &ImpedanceSettings::damping_ratio, "ζ of every mode, 0.05 to 3")
      .field("normal_force", &ImpedanceSettings::normal_force, "F_n, in contact [N], 0 to 50")
      .field("switch_time", &ImpedanceSettings::switch_time,
             "time constant of the force carried over at a mode switch [s], 0.001 to 5")
      .field("surface", &ImpedanceSettings::surface, "use of the estimated surface")
      .field("approach", &ImpedanceSettings::approach, "motion towards the surface and away")
      .field("contact", &ImpedanceSettings::contact, "when touch is found and lost")
      .field("tip", &ImpedanceSettings::tip, "model of the pen tip")
      .field("friction", &ImpedanceSettings::friction, "at the tip")
      .field("observer", &ImpedanceSettings::observer, "momentum observer")
      .field("force_integral", &ImpedanceSettings::force_integral, "of the force error")
      .field("stability_check", &ImpedanceSettings::stability_check, "at set-up")
      .field("operational_space", &ImpedanceSettings::operational_space, "near singularities")
      .field("null_space", &ImpedanceSettings::null_space, "τ_null")
      .field("joint_range", &ImpedanceSettings::joint_range, "τ_limit")
      .field("limits", &ImpedanceSettings::limits, "torque, tip speed")
      .done()
      .def("validate", &ImpedanceSettings::validate, nb::arg("joints"),
           "Raises ValueError naming the first invalid setting, its value and what is valid.")
      .def("completed", &ImpedanceSettings::completed, nb::arg("joints"),
           "These settings with every empty vector replaced by its default.");
}

}  // namespace impedraw::python
