#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include "impedraw/canvas/canvas.h"
#include "impedraw/experiment/canvas_settings.h"
#include "impedraw/files/data_folder.h"
#include "impedraw/settings/yaml_read.h"
#include "impedraw/simulation/joint_sensor.h"
#include "impedraw/simulation/world.h"
#include "module.h"
#include "record.h"

namespace impedraw::python {

namespace {

// A world, and the canvas that it refers to.
struct OwnedWorld {
  std::shared_ptr<const Canvas> canvas;
  World world;
  OwnedWorld(const std::filesystem::path& urdf, std::shared_ptr<const Canvas> on,
             const WorldSettings& settings)
      : canvas(std::move(on)), world(urdf, canvas.get(), settings) {}

  JointVector vector(nb::handle value, const char* name) const {
    JointVector x;
    assign(value, x, name);
    if (x.size() != world.joints())
      refuse(name, value, std::to_string(world.joints()) + " entries, one for each joint");
    if (!x.allFinite()) refuse(name, value, "finite");
    return x;
  }
};

struct OwnedSensor {
  JointSensor sensor;
  int joints;
  OwnedSensor(const JointSensorSettings& settings, int n, double dt, std::uint64_t seed)
      : sensor(settings, n > 0 && n <= kMaxJoints ? n : 1, dt, seed), joints(n) {
    if (n < 1 || n > kMaxJoints)
      refuse("joints", nb::cast(n), "1 to " + std::to_string(kMaxJoints));
  }

  JointVector vector(nb::handle value, const char* name) const {
    JointVector x;
    assign(value, x, name);
    if (x.size() != joints)
      refuse(name, value, std::to_string(joints) + " entries, one for each joint");
    if (!x.allFinite()) refuse(name, value, "finite");
    return x;
  }
};

std::shared_ptr<Canvas> canvas_of_mesh(nb::handle vertices, nb::handle triangles) {
  const DoubleArray v = doubles_of(vertices, "vertices"), t = doubles_of(triangles, "triangles");
  require_shape(v, "vertices", {-1, 3});
  require_shape(t, "triangles", {-1, 3});
  TriangleMesh mesh;
  for (std::size_t i = 0; i < v.shape(0); ++i)
    mesh.vertices.emplace_back(Eigen::Map<const Eigen::Vector3d>(v.data() + 3 * i));
  for (std::size_t i = 0; i < t.shape(0); ++i) {
    const Eigen::Map<const Eigen::Vector3d> of(t.data() + 3 * i);
    for (int k = 0; k < 3; ++k)
      if (of[k] != std::floor(of[k]) || of[k] < 0.0 || of[k] >= static_cast<double>(v.shape(0)))
        refuse("triangles[" + std::to_string(i) + "]", nb::cast(of[k]),
               "an index of a vertex, 0 to " + std::to_string(v.shape(0) - 1));
    mesh.triangles.emplace_back(of.cast<int>());
  }
  const nb::gil_scoped_release no_gil;
  return std::make_shared<Canvas>(std::move(mesh));
}

struct CanvasScenario {
  CanvasSettings canvas;
};

void describe(Fields& f, CanvasScenario& s) { f.field("canvas", s.canvas, "The canvas."); }

std::shared_ptr<Canvas> canvas_of_settings(const std::vector<std::string>& assignments) {
  CanvasScenario scenario;
  read_settings(scenario, {}, assignments);
  const nb::gil_scoped_release no_gil;
  return std::make_shared<Canvas>(make_mesh(scenario.canvas));
}

}  // namespace

void bind_simulation(nb::module_& m) {
  nb::enum_<VelocityReading>(m, "VelocityReading", "How joint velocities are read.")
      .value("exact", VelocityReading::exact)
      .value("difference", VelocityReading::difference)
      .value("none", VelocityReading::none);
  Record<TipMaterial>(m, "TipMaterial", "The pen tip in the simulated world.")
      .field("radius", &TipMaterial::radius, "of the tip sphere [m], 0.00001 to 0.05")
      .field("stiffness", &TipMaterial::stiffness, "[N/m], 10 to 1e7")
      .field("damping", &TipMaterial::damping, "[N s/m], 0 to 1e5")
      .field("friction", &TipMaterial::friction, "μ, 0 to 3")
      .done();
  using E = ModelErrors;
  Record<E>(m, "ModelErrors", "Differences of the simulated arm from its URDF.")
      .field("mass_scale", &E::mass_scale, "of mass and inertia of every link, 0.1 to 10")
      .field("centre_shift", &E::centre_shift, "[m]")
      .field("viscous_friction", &E::viscous_friction, "every joint [Nm s/rad]")
      .field("rotor_inertia", &E::rotor_inertia,
             "true, one for all joints or one each; empty: as the URDF says [kg m²]")
      .field("torque_ripple", &E::torque_ripple, "every joint [Nm]")
      .field("torque_quantum", &E::torque_quantum, "resolution; 0: continuous [Nm]")
      .field("loop_delay", &E::loop_delay, "[s]")
      .field("pen_longer", &E::pen_longer, "[m]")
      .done();
  using J = JointSensorSettings;
  Record<J>(m, "JointSensorSettings", "What the joints' sensors give.")
      .field("quantum", &J::quantum, "resolution of the position; 0: continuous [rad]")
      .field("position_noise", &J::position_noise, "standard deviation [rad]")
      .field("velocity_noise", &J::velocity_noise, "standard deviation [rad/s]")
      .field("delay", &J::delay, "rounded to samples, 0 to 0.03 [s]")
      .field("velocity", &J::velocity, "how the velocity is read")
      .field("velocity_bandwidth", &J::velocity_bandwidth, "of its low-pass; 0: none [rad/s]")
      .done();
  nb::class_<OwnedSensor>(m, "JointSensor",
                          "Reads joint positions and velocities as the joints' sensors give them.\n"
                          "A seed fixes the noise to the last bit.")
      .def(nb::init<const JointSensorSettings&, int, double, std::uint64_t>(), nb::arg("settings"),
           nb::arg("joints"), nb::arg("dt") = 1e-3, nb::arg("seed") = 1,
           "dt: between samples [s]. Raises ValueError for a setting out of range.")
      .def(
          "read",
          [](OwnedSensor& s, nb::handle q, nb::handle v) {
            const JointReading read = s.sensor.sample(s.vector(q, "q"), s.vector(v, "v"));
            return nb::make_tuple(array(read.q, nb::handle()), array(read.v, nb::handle()));
          },
          nb::arg("q"), nb::arg("v"),
          nb::sig("def read(self, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike) -> "
                  "tuple[numpy.typing.NDArray[numpy.float64], "
                  "numpy.typing.NDArray[numpy.float64]]"),
          "The reading of the next sample: q [rad] and v [rad/s], shapes (n,).");
  using W = WorldSettings;
  Record<W>(m, "WorldSettings", "Settings of the simulated world.")
      .field("dt", &W::dt, "of a control step, over which the torque is held [s]")
      .field("substeps", &W::substeps, "integration steps in each, 1 to 100")
      .field("tip", &W::tip, "the pen tip")
      .field("joint_friction", &W::joint_friction, "dry friction, every joint: ± [Nm]")
      .field("gravity", &W::gravity, "along −z [m/s²]")
      .field("errors", &W::errors, "differences from the URDF")
      .field("joint_sensor", &W::joint_sensor, "of the arm that draw() simulates; see JointSensor")
      .field("flange_sensor", &W::flange_sensor, "enables flange_wrench")
      .done();
  Record<TipContact>(m, "TipContact", "Contact over the last step.")
      .field("touching", &TipContact::touching, "the tip touches the canvas")
      .field("f_W", &TipContact::f_W, "mean force of the canvas on the tip, shape (3,) [N]")
      .field("p_WC", &TipContact::p_WC, "on the canvas, shape (3,) [m]")
      .field("n_W", &TipContact::n_W, "outward normal there, shape (3,)")
      .done();
  Record<WorldState>(m, "WorldState", "State of the simulated world.")
      .field("time", &WorldState::time, "[s]")
      .field("q", &WorldState::q, "shape (n,) [rad]")
      .field("v", &WorldState::v, "shape (n,) [rad/s]")
      .field("X_WE", &WorldState::X_WE, "pen tip, true")
      .field("V_WE", &WorldState::V_WE, "its velocity, linear first, shape (6,)")
      .done();
  Record<SurfacePoint>(m, "SurfacePoint", "The point of a canvas closest to another.")
      .field("p_W", &SurfacePoint::p_W, "shape (3,) [m]")
      .field("n_W", &SurfacePoint::n_W, "outward unit normal, shape (3,)")
      .field("distance", &SurfacePoint::distance, "[m], > 0 on the drawing side")
      .field("triangle", &SurfacePoint::triangle, "index")
      .field("on_edge", &SurfacePoint::on_edge, "on the canvas's boundary")
      .from({Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()})
      .done();
  nb::class_<Canvas>(m, "Canvas", "A drawing surface as exact triangles. Thread-safe.")
      .def_static("from_mesh", &canvas_of_mesh, nb::arg("vertices"), nb::arg("triangles"),
                  nb::sig("def from_mesh(vertices: numpy.typing.ArrayLike, triangles: "
                          "numpy.typing.ArrayLike) -> Canvas"),
                  "vertices: shape (N, 3), W [m]; triangles: (M, 3), indices, wound so that the\n"
                  "right-hand normal points to the drawing side. Raises ValueError naming the\n"
                  "vertex or triangle at fault.")
      .def(
          "closest",
          [](const Canvas& c, nb::handle p_W) {
            Eigen::Vector3d p;
            assign(p_W, p, "p_W");
            if (!p.allFinite()) refuse("p_W", p_W, "finite");
            return c.closest(p);
          },
          nb::arg("p_W"), nb::sig("def closest(self, p_W: numpy.typing.ArrayLike) -> SurfacePoint"),
          "The point closest to p_W, shape (3,) [m].");
  m.def(
      "canvas_of_settings",
      [](const std::vector<std::string>& assignments) { return canvas_of_settings(assignments); },
      nb::arg("assignments"), "The canvas of settings as --set takes them: canvas.kind=bowl.");
  nb::class_<OwnedWorld>(m, "World",
                         "Simulated world: a torque-controlled arm whose pen touches a canvas.\n"
                         "Threads may run separate worlds at once.")
      .def(nb::init<const std::filesystem::path&, std::shared_ptr<const Canvas>,
                    const WorldSettings&>(),
           nb::arg("urdf"), nb::arg("canvas").none() = nb::none(),
           nb::arg("settings") = WorldSettings(),
           nb::sig("def __init__(self, urdf: str | os.PathLike[str], canvas: Canvas | None = None, "
                   "settings: WorldSettings = ...) -> None"))
      .def_prop_ro("joints", [](const OwnedWorld& w) { return w.world.joints(); })
      .def(
          "set_state",
          [](OwnedWorld& w, nb::handle q, nb::handle v) {
            const JointVector at = w.vector(q, "q");
            w.world.set_state(
                at, v.is_none() ? JointVector(JointVector::Zero(at.size())) : w.vector(v, "v"));
          },
          nb::arg("q"), nb::arg("v").none() = nb::none(),
          nb::sig("def set_state(self, q: numpy.typing.ArrayLike, v: numpy.typing.ArrayLike | None "
                  "= None) -> None"),
          "At time 0; q: shape (n,) [rad]; v: shape (n,) [rad/s], default 0.")
      .def_prop_ro("state", [](const OwnedWorld& w) { return WorldState(w.world.state()); })
      .def(
          "step",
          [](OwnedWorld& w, nb::handle tau, nb::handle push) {
            const JointVector torque = w.vector(tau, "tau");
            Eigen::Vector3d f = Eigen::Vector3d::Zero();
            if (!push.is_none()) assign(push, f, "f_push_W");
            if (!f.allFinite()) refuse("f_push_W", push, "finite");
            const nb::gil_scoped_release no_gil;
            return TipContact(w.world.step(torque, f));
          },
          nb::arg("tau"), nb::arg("f_push_W").none() = nb::none(),
          nb::sig("def step(self, tau: numpy.typing.ArrayLike, f_push_W: numpy.typing.ArrayLike | "
                  "None = None) -> TipContact"),
          "Advances by dt under torque tau, shape (n,) [Nm], and a push on the pen at E, shape\n"
          "(3,), W [N]. Returns the contact that acted.")
      .def_prop_ro(
          "flange_wrench",
          [](const OwnedWorld& w) { return array(w.world.flange_wrench(), nb::handle()); },
          nb::for_getter(
              nb::sig("def flange_wrench(self, /) -> numpy.typing.NDArray[numpy.float64]")),
          "[f; m] of pen and environment on link `flange`, shape (6,) [N, Nm]")
      .def_prop_ro(
          "applied_torque",
          [](const OwnedWorld& w) { return array(w.world.applied_torque(), nb::handle()); },
          nb::for_getter(
              nb::sig("def applied_torque(self, /) -> numpy.typing.NDArray[numpy.float64]")),
          "τ_a over the last step, shape (n,) [Nm]")
      .def_prop_ro(
          "failure", [](const OwnedWorld& w) { return w.world.failure(); },
          "Why the motion is no longer valid; None while it is.")
      .def_prop_ro(
          "touching_link", [](const OwnedWorld& w) { return w.world.touching_link(); },
          "Link whose body touches the canvas; empty if none does.")
      .def(
          "_time_steps",
          [](OwnedWorld& w, nb::handle tau, int steps) {
            const JointVector torque = w.vector(tau, "tau");
            const double start = processor_seconds();
            for (int i = 0; i < steps; ++i)
              w.world.step(torque, Eigen::Vector3d(Eigen::Vector3d::Zero()));
            return (processor_seconds() - start) / steps;
          },
          "Processor seconds of a step called from C++, for comparison with calls from Python.");
}

}  // namespace impedraw::python
