#include "impedraw/control/impedance.h"

#include <cstring>
#include <string_view>

#include "module.h"
#include "record.h"

namespace impedraw::python {

namespace {

// The usual case, an array of six doubles, is read without an ndarray in between: a third of what
// a step from Python costs on top of one from C++.
Vector6 wrench_of(nb::handle value) {
  Vector6 F_ext = Vector6::Zero();
  if (value.is_none()) return F_ext;
  Py_buffer view;
  if (PyObject_CheckBuffer(value.ptr()) &&
      PyObject_GetBuffer(value.ptr(), &view, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT) == 0) {
    const bool doubles = view.ndim == 1 && view.shape[0] == 6 && view.itemsize == 8 &&
                         view.format && std::string_view(view.format) == "d";
    if (doubles) std::memcpy(F_ext.data(), view.buf, 6 * sizeof(double));
    PyBuffer_Release(&view);
    if (doubles) return F_ext;
  }
  PyErr_Clear();
  assign(value, F_ext, "F_ext");
  return F_ext;
}

// A controller, and the number of joints for which it was made.
struct Controller {
  ImpedanceController law;
  int joints;
  Controller(const ImpedanceSettings& settings, int n) : law(settings, n), joints(n) {}

  void require(const ArmTerms& arm) const {
    if (arm.q.size() != joints)
      throw nb::value_error(("terms are of an arm of " + std::to_string(arm.q.size()) +
                             " joints; the controller was made for " + std::to_string(joints))
                                .c_str());
  }
};

}  // namespace

void bind_control(nb::module_& m) {
  nb::enum_<ContactMode>(m, "ContactMode", "State of the pen's contact with the surface.")
      .value("free", ContactMode::free)
      .value("approach", ContactMode::approach)
      .value("contact", ContactMode::contact)
      .value("lift", ContactMode::lift)
      .value("retreat", ContactMode::retreat);
  nb::enum_<SurfaceStatus>(m, "SurfaceStatus", "Whether perception knows the surface here.")
      .value("ok", SurfaceStatus::ok)
      .value("none", SurfaceStatus::none, "no perception at all")
      .value("too_few", SurfaceStatus::too_few, "fewer than k points within reach")
      .value("off_edge", SurfaceStatus::off_edge, "beyond the edge of the cloud");
  nb::list names;
  for (const std::string_view name : kTorqueTermNames) names.append(nb::str(name.data()));
  m.attr("TORQUE_TERMS") = nb::tuple(names);

  Record<ArmTerms>(m, "ArmTerms",
                   "Terms of the arm's rigid-body dynamics at one instant (2), (5)–(7). n joints.\n"
                   "Spatial quantities are in W, taken at the origin of E, linear part first.")
      .field("q", &ArmTerms::q, "joint position, shape (n,) [rad]")
      .field("v", &ArmTerms::v, "joint velocity, shape (n,) [rad/s]")
      .field("M", &ArmTerms::M, "joint inertia, shape (n, n) [kg m²]")
      .field("Cv", &ArmTerms::Cv, "Coriolis and centrifugal torque, shape (n,) [Nm]")
      .field("g", &ArmTerms::g, "gravity torque, shape (n,): τ = g holds the arm still [Nm]")
      .field("J", &ArmTerms::J, "tip Jacobian, shape (6, n), V_WE = J v")
      .field("Jdot_v", &ArmTerms::Jdot_v, "drift acceleration J̇ v, shape (6,) [m/s², rad/s²]")
      .field("X_WE", &ArmTerms::X_WE, "pose of the pen tip")
      .field("V_WE", &ArmTerms::V_WE, "its spatial velocity, shape (6,) [m/s, rad/s]")
      .done();
  Record<TipReference>(m, "TipReference",
                       "Planned motion of the pen tip at one instant, in W. z_D = −n_WD.")
      .field("p_WD", &TipReference::p_WD, "shape (3,) [m]")
      .field("v_WD", &TipReference::v_WD, "shape (3,) [m/s]")
      .field("a_WD", &TipReference::a_WD, "shape (3,) [m/s²]")
      .field("n_WD", &TipReference::n_WD, "outward unit normal of the planned surface, shape (3,)")
      .field("w_WD", &TipReference::w_WD, "angular velocity of n_WD, shape (3,) [rad/s]")
      .field("alpha_WD", &TipReference::alpha_WD, "its derivative, shape (3,) [rad/s²]")
      .field("pen_down", &TipReference::pen_down, "contact is desired")
      .done();
  Record<SurfaceEstimate>(m, "SurfaceEstimate", "The surface under the tip, as perception has it.")
      .field("status", &SurfaceEstimate::status, "n_W and distance are valid with ok alone")
      .field("n_W", &SurfaceEstimate::n_W, "outward unit normal, shape (3,), W")
      .field("distance", &SurfaceEstimate::distance,
             "of the query point from the surface [m], > 0 outside")
      .done();
  Record<ControlStatus>(m, "ControlStatus", "What a step met.")
      .field("bad_input", &ControlStatus::bad_input,
             "an input is not finite, has the wrong size, or a normal is not of unit length")
      .field("near_singular", &ControlStatus::near_singular, "a direction was released")
      .field("stale_state", &ControlStatus::stale_state, "older than timing.max_state_age")
      .field("stale_wrench", &ControlStatus::stale_wrench, "older than timing.max_wrench_age")
      .field("torque_limited", &ControlStatus::torque_limited, "a limit on torque or its rate")
      .field("speed_limited", &ControlStatus::speed_limited,
             "limits.tip_speed, turn_speed or joint_speed")
      .field("joint_limit", &ControlStatus::joint_limit, "within joint_range.margin of a limit")
      .field("surface_lost", &ControlStatus::surface_lost, "contact desired, no surface here")
      .field("damping_limit", &ControlStatus::damping_limit, "the damping is near its limit here")
      .field("stiff_contact", &ControlStatus::stiff_contact,
             "the pen would hammer: the arm's own inertia counts")
      .done()
      .def_prop_ro("ok", &ControlStatus::ok, "nothing was met");
  Record<ImpedanceTorque>(m, "ImpedanceTorque", "Result of one step, n joints.")
      .field("tau", &ImpedanceTorque::tau, "torque after limits, shape (n,) [Nm]")
      .field("terms", &ImpedanceTorque::terms,
             "shape (n, 8): a column for each of TORQUE_TERMS; the columns sum to the torque\n"
             "before limits [Nm]")
      .field("mode", &ImpedanceTorque::mode, "state of contact")
      .field("status", &ImpedanceTorque::status, "what the step met")
      .field("push", &ImpedanceTorque::push, "desired normal force [N]")
      .field("task_share", &ImpedanceTorque::task_share, "share of the task that limits left")
      .field("p_WD", &ImpedanceTorque::p_WD, "desired tip, compensation included, shape (3,) [m]")
      .field("n_WD", &ImpedanceTorque::n_WD, "normal that the push follows, shape (3,)")
      .field("axis_WD", &ImpedanceTorque::axis_WD, "desired pen axis, outward, shape (3,)")
      .done();

  nb::class_<Controller>(
      m, "ImpedanceController",
      "Operational-space impedance control of a pen tip: the law (1), (10)–(17) of\n"
      "src/control/impedance.h. One call of step() every timing.dt. Not thread-safe.")
      .def(
          "__init__",
          [](Controller* self, const ImpedanceSettings& settings, nb::handle arm) {
            const bool model = nb::hasattr(arm, "joints");
            new (self) Controller(
                settings, static_cast<int>(integer_of(
                              model ? nb::object(arm.attr("joints")) : nb::borrow(arm), "arm")));
          },
          nb::arg("settings"), nb::arg("arm"),
          nb::sig("def __init__(self, settings: ImpedanceSettings, arm: ArmModel | int) -> None"),
          "arm: the arm, or its number of joints. Raises ValueError as "
          "ImpedanceSettings.validate() does.")
      .def(
          "step",
          [](Controller& c, const ArmTerms& arm, const TipReference& reference,
             const SurfaceEstimate& surface, nb::handle F_ext, double state_age,
             double wrench_age) {
            c.require(arm);
            return c.law.step(arm, reference, surface, wrench_of(F_ext), {state_age, wrench_age});
          },
          nb::arg("arm"), nb::arg("reference"), nb::arg("surface"),
          nb::arg("F_ext").none() = nb::none(), nb::arg("state_age") = 0.0,
          nb::arg("wrench_age") = 0.0,
          nb::sig(
              "def step(self, arm: ArmTerms, reference: TipReference, surface: SurfaceEstimate, "
              "F_ext: numpy.typing.ArrayLike | None = None, state_age: float = 0.0, "
              "wrench_age: float = 0.0) -> ImpedanceTorque"),
          "Computes one step. F_ext: wrench of the environment on the tip at E in W, shape (6,)\n"
          "[N, Nm]; used with WrenchFeedback.measured alone. Ages [s] beyond timing's delays.\n"
          "Faults of the loop (not finite, stale) are in the result's status, not raised.")
      .def(
          "brake",
          [](Controller& c, const ArmTerms& arm) {
            c.require(arm);
            return c.law.brake(arm);
          },
          nb::arg("arm"), "Gravity compensation and damping −c M v, c = 20 /s.")
      .def(
          "reset", [](Controller& c) { c.law.reset(); },
          "Restores the initial state: mode free, no carried force.")
      .def(
          "retune",
          [](Controller& c, const TipGain& stiffness, double normal_force) {
            c.law.retune(stiffness, normal_force);
          },
          nb::arg("stiffness"), nb::arg("normal_force"),
          "Changes K and F_n from the next step on; the state is kept. Raises ValueError as the\n"
          "constructor does, and then changes nothing.")
      .def_ro("joints", &Controller::joints)
      .def(
          "_time_steps",
          [](Controller& c, const ArmTerms& arm, const TipReference& reference,
             const SurfaceEstimate& surface, int steps) {
            const Vector6 F_ext = Vector6::Zero();
            const double start = processor_seconds();
            for (int i = 0; i < steps; ++i) c.law.step(arm, reference, surface, F_ext);
            return (processor_seconds() - start) / steps;
          },
          "Processor seconds of a step called from C++, for comparison with calls from Python.");
}

}  // namespace impedraw::python
