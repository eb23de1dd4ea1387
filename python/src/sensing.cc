#include "impedraw/sensing/joint_state_estimator.h"
#include "impedraw/sensing/tool_identification.h"
#include "impedraw/sensing/wrench_estimator.h"
#include "module.h"
#include "record.h"

namespace impedraw::python {

namespace {

template <class T>
T dense(nb::handle value, const char* name) {
  T x;
  assign(value, x, name);
  return x;
}

JointVector joints_of(nb::handle value, const char* name, Eigen::Index n) {
  const auto x = dense<JointVector>(value, name);
  if (x.size() != n) refuse(name, value, std::to_string(n) + " entries");
  return x;
}

struct JointEstimator {
  JointStateEstimator estimator;
  int joints;
  JointEstimator(const JointStateEstimatorSettings& settings, int n)
      : estimator(settings, n), joints(n) {}
};

ToolIdentification identify(nb::handle R_WS, nb::handle readings_S, nb::handle gravity_W) {
  const DoubleArray R = doubles_of(R_WS, "R_WS"), f = doubles_of(readings_S, "readings_S");
  require_shape(R, "R_WS", {-1, 3, 3});
  require_shape(f, "readings_S", {static_cast<long>(R.shape(0)), 6});
  std::vector<StaticReading> poses(R.shape(0));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    poses[i].R_WS =
        Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data() + 9 * i);
    poses[i].reading_S = Eigen::Map<const Vector6>(f.data() + 6 * i);
  }
  Eigen::Vector3d g(0.0, 0.0, -9.81);
  if (!gravity_W.is_none()) assign(gravity_W, g, "gravity_W");
  return identify_tool(poses, g);
}

}  // namespace

void bind_sensing(nb::module_& m) {
  Record<Tool>(m, "Tool", "The body on the far side of a force-torque sensor. S: its frame.")
      .field("mass", &Tool::mass, "[kg], 0 to 20")
      .field("p_SC", &Tool::p_SC, "centre of mass, in S, shape (3,) [m]")
      .field("I_SC", &Tool::I_SC, "about the centre of mass, in S, shape (3, 3) [kg m²]")
      .done();
  using W = WrenchEstimatorSettings;
  Record<W>(m, "WrenchEstimatorSettings", "Settings of the wrench estimator.")
      .field("dt", &W::dt, "step [s]")
      .field("tool", &W::tool, "on the far side of the sensor")
      .field("X_ES", &W::X_ES, "sensor frame in the tip's frame")
      .field("gravity_W", &W::gravity_W, "shape (3,) [m/s²]")
      .field("sensor_delay", &W::sensor_delay, "age of a reading, rounded to steps [s]")
      .field("filter_bandwidth", &W::filter_bandwidth, "ω, below 2/dt [rad/s]; 0: no filter")
      .field("tare_time", &W::tare_time, "[s]")
      .field("tare_speed", &W::tare_speed, "at rest below this [m/s]")
      .field("tare_turn_rate", &W::tare_turn_rate, "at rest below this [rad/s]")
      .field("range_force", &W::range_force, "of the sensor, ± on each axis [N]")
      .field("range_torque", &W::range_torque, "the same [Nm]")
      .done();
  nb::class_<WrenchEstimator>(m, "WrenchEstimator",
                              "Wrench of the environment on the pen tip from the readings of a "
                              "force-torque sensor:\nsrc/sensing/wrench_estimator.h.")
      .def(nb::init<const W&>(), nb::arg("settings"))
      .def(
          "update",
          [](WrenchEstimator& e, nb::handle reading_S, const Pose& X_WE, nb::handle V_WE) {
            const Vector6 F = e.update(dense<Vector6>(reading_S, "reading_S"), X_WE,
                                       dense<Vector6>(V_WE, "V_WE"));
            return array(F, nb::handle());
          },
          nb::arg("reading_S"), nb::arg("X_WE"), nb::arg("V_WE"),
          nb::sig("def update(self, reading_S: numpy.typing.ArrayLike, X_WE: Pose, V_WE: "
                  "numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]"),
          "One step. Returns F_ext at E in W, shape (6,) [N, Nm]: zero until tared, the value\n"
          "before after a fault.")
      .def("start_tare", &WrenchEstimator::start_tare)
      .def_prop_ro("tared", &WrenchEstimator::tared, "a bias is available")
      .def_prop_ro("taring", &WrenchEstimator::taring, "a tare is in progress")
      .def_prop_ro("fault", &WrenchEstimator::fault, "the last update rejected its reading")
      .def_prop_ro(
          "bias", [](const WrenchEstimator& e) { return array(e.bias(), nb::handle()); },
          nb::for_getter(nb::sig("def bias(self, /) -> numpy.typing.NDArray[numpy.float64]")),
          "bias_S, shape (6,) [N, Nm]")
      .def_prop_ro("group_delay", &WrenchEstimator::group_delay,
                   "age of F_ext at low frequency [s]");

  using J = JointStateEstimatorSettings;
  Record<J>(m, "JointStateEstimatorSettings", "Settings of the joint state estimator.")
      .field("dt", &J::dt, "step [s], at least 0.001 and below 1/bandwidth")
      .field("bandwidth", &J::bandwidth, "of the filter [rad/s], 1 to 900")
      .field("sensor_delay", &J::sensor_delay, "age of a reading [s], 0 to 0.03")
      .field("torque_delay", &J::torque_delay, "until a torque acts [s], 0 to 0.03")
      .field("least_bandwidth", &J::least_bandwidth,
             "noise of the readings lowers the bandwidth to this at the most [rad/s], 1 to 900")
      .done()
      .def("validate", &J::validate, "Raises ValueError naming the setting and what is valid.");
  nb::class_<JointEstimator>(m, "JointStateEstimator",
                             "Joint positions and velocities from position readings that are "
                             "quantised, noisy and late:\nsrc/sensing/joint_state_estimator.h.")
      .def(nb::init<const J&, int>(), nb::arg("settings"), nb::arg("joints"))
      .def(
          "update",
          [](JointEstimator& e, nb::handle q_read, int steps) {
            e.estimator.update(joints_of(q_read, "q_read", e.joints), steps);
          },
          nb::arg("q_read"), nb::arg("steps") = 1,
          nb::sig("def update(self, q_read: numpy.typing.ArrayLike, steps: int = 1) -> None"),
          "Advances by `steps` of dt, then corrects with the newest reading, shape (n,) [rad].")
      .def(
          "coast", [](JointEstimator& e, int steps) { e.estimator.coast(steps); },
          nb::arg("steps") = 1, "Advances without a reading.")
      .def(
          "commanded",
          [](JointEstimator& e, const ArmTerms& arm, nb::handle F_ext, nb::handle tau) {
            if (arm.q.size() != e.joints)
              throw nb::value_error("arm: terms of another number of joints");
            e.estimator.commanded(arm, dense<Vector6>(F_ext, "F_ext"),
                                  joints_of(tau, "tau", e.joints));
          },
          nb::arg("arm"), nb::arg("F_ext"), nb::arg("tau"),
          nb::sig("def commanded(self, arm: ArmTerms, F_ext: numpy.typing.ArrayLike, tau: "
                  "numpy.typing.ArrayLike) -> None"),
          "At the end of a step: terms at q, v, newest F_ext (6,) [N, Nm], torque (n,) [Nm].")
      .def(
          "reset", [](JointEstimator& e) { e.estimator.reset(); }, "Forgets everything.")
      .def_prop_ro(
          "q", [](const JointEstimator& e) { return array(e.estimator.q(), nb::handle()); },
          nb::for_getter(nb::sig("def q(self, /) -> numpy.typing.NDArray[numpy.float64]")),
          "shape (n,) [rad]")
      .def_prop_ro(
          "v", [](const JointEstimator& e) { return array(e.estimator.v(), nb::handle()); },
          nb::for_getter(nb::sig("def v(self, /) -> numpy.typing.NDArray[numpy.float64]")),
          "shape (n,) [rad/s]")
      .def_prop_ro(
          "lag", [](const JointEstimator& e) { return e.estimator.lag(); }, "[s]");

  using I = ToolIdentification;
  Record<I>(m, "ToolIdentification", "What identify_tool() finds.")
      .field("mass", &I::mass, "[kg]")
      .field("p_SC", &I::p_SC, "centre of mass, shape (3,) [m]")
      .field("bias_S", &I::bias_S, "shape (6,) [N, Nm]")
      .field("residual_force", &I::residual_force, "RMS per axis [N]")
      .field("residual_torque", &I::residual_torque, "RMS per axis [Nm]")
      .field("mass_error", &I::mass_error, "standard error [kg]")
      .field("p_SC_error", &I::p_SC_error, "standard errors, shape (3,) [m]")
      .field("condition", &I::condition, "of both problems, the larger; ideal: 1")
      .done();
  m.def("identify_tool", &identify, nb::arg("R_WS"), nb::arg("readings_S"),
        nb::arg("gravity_W").none() = nb::none(),
        nb::sig("def identify_tool(R_WS: numpy.typing.ArrayLike, readings_S: "
                "numpy.typing.ArrayLike, gravity_W: numpy.typing.ArrayLike | None = None) -> "
                "ToolIdentification"),
        "Mass and centre of mass of a tool from readings at rest. R_WS: shape (N, 3, 3);\n"
        "readings_S: means at rest, shape (N, 6) [N, Nm]; gravity_W: (3,) [m/s²], default\n"
        "(0, 0, −9.81). Source: Atkeson, An, Hollerbach 1986.");
}

}  // namespace impedraw::python
