#include "arm.h"

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/vector.h>

#include "impedraw/files/data_folder.h"
#include "module.h"

namespace impedraw::python {

void bind_arm(nb::module_& m) {
  Record<ArmLimits>(m, "ArmLimits", "Limits of an arm's joints, as its URDF gives them.")
      .field("lower", &ArmLimits::lower, "shape (n,) [rad]")
      .field("upper", &ArmLimits::upper, "shape (n,) [rad]")
      .field("torque", &ArmLimits::torque, "±, shape (n,) [Nm]")
      .field("speed", &ArmLimits::speed, "±, shape (n,) [rad/s]")
      .done();
  nb::class_<Arm>(
      m, "ArmModel",
      "Rigid-body model of a serial arm with a pen, read from a URDF. Joints are in the\n"
      "order of the URDF. Not thread-safe: each thread takes a model of its own.")
      .def_static(
          "from_urdf",
          [](const std::filesystem::path& urdf, const std::string& tip_frame, nb::handle rotors) {
            return Arm(urdf, tip_frame, rotors);
          },
          nb::arg("urdf"), nb::arg("tip_frame") = "tip", nb::arg("rotor_inertia") = nb::tuple(),
          nb::sig("def from_urdf(urdf: str | os.PathLike, tip_frame: str = 'tip', rotor_inertia: "
                  "float | collections.abc.Sequence[float] = ()) -> ArmModel"),
          "tip_frame: frame E, origin at the tip's apex, z out of the tip. rotor_inertia: of the\n"
          "joints' rotors, reflected through their gears, one for all joints or one for each; "
          "none:\n"
          "as the URDF says [kg m²]. Raises ValueError if the file is missing or malformed, has "
          "more\n"
          "than 12 joints, or lacks the frame.")
      .def_static(
          "standard",
          [] { return Arm(data_folder() / "models/iiwa14_pen.urdf", "tip", nb::tuple()); },
          "The standard arm of seven joints with a pen.")
      .def_prop_ro("joints", [](const Arm& a) { return a.model.joints(); })
      .def_prop_ro("joint_names", [](const Arm& a) { return a.model.joint_names(); })
      .def_prop_ro("limits", [](const Arm& a) { return ArmLimits(a.model.limits()); })
      .def_prop_ro("rotor_inertia",
                   [](const Arm& a) { return array(a.model.rotor_inertia(), nb::handle()); })
      .def_prop_ro("urdf", [](const Arm& a) { return a.urdf; })
      .def(
          "compute",
          [](Arm& a, nb::handle q, nb::handle v) {
            ArmTerms terms(a.model.joints());
            a.model.compute(a.vector(q, "q"), a.vector(v, "v"), &terms);
            return terms;
          },
          nb::arg("q"), nb::arg("v"),
          nb::sig("def compute(self, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike) -> "
                  "ArmTerms"),
          "All terms at q, shape (n,) [rad], and v, shape (n,) [rad/s]. Their relative difference\n"
          "from MuJoCo's is below 1e-9.")
      .def(
          "tip_pose", [](Arm& a, nb::handle q) { return a.model.tip_pose(a.vector(q, "q")); },
          nb::arg("q"), nb::sig("def tip_pose(self, q: numpy.typing.ArrayLike) -> Pose"),
          "X_WE at q, shape (n,) [rad].");
}

}  // namespace impedraw::python
