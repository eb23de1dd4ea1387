#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>

#include <memory>

#include "impedraw/experiment/height_sources.h"
#include "impedraw/planning/path/tip_planner.h"
#include "module.h"
#include "planning.h"

namespace impedraw::python {

std::vector<PlacedStroke> strokes_of(nb::handle strokes) {
  if (!nb::isinstance<nb::sequence>(strokes)) refuse("strokes", strokes, "a sequence of arrays");
  std::vector<PlacedStroke> placed;
  for (const nb::handle stroke : strokes) {
    const std::string name = "strokes[" + std::to_string(placed.size()) + "]";
    const DoubleArray p = doubles_of(stroke, name);
    require_shape(p, name, {-1, 2});
    PlacedStroke one;
    for (std::size_t i = 0; i < p.shape(0); ++i) {
      const Eigen::Vector2d at(p.data()[2 * i], p.data()[2 * i + 1]);
      if (!at.allFinite()) refuse(name, stroke, "finite");
      one.p_P.push_back(at);
      one.page.push_back(1e3 * at);
    }
    if (one.p_P.empty()) refuse(name, stroke, "at least one point");
    one.number = static_cast<int>(placed.size());
    placed.push_back(std::move(one));
  }
  return placed;
}

SurfaceHeight height_of(nb::handle surface, const Pose& X_WP) {
  std::shared_ptr<SurfaceEstimator> seen;
  if (nb::try_cast(surface, seen) && seen)
    return perceived_height(std::shared_ptr<const SurfaceEstimator>(seen), X_WP);
  std::shared_ptr<Canvas> canvas;
  if (nb::try_cast(surface, canvas) && canvas) return canvas_height(canvas, X_WP);
  return level_surface(number_of(surface, "surface"));
}

namespace {

TipPath plan_path(nb::handle strokes, nb::handle surface, const PathSettings& settings) {
  const std::vector<PlacedStroke> placed = strokes_of(strokes);
  const SurfaceHeight height = height_of(surface, settings.X_WP);
  const nb::gil_scoped_release no_gil;
  return plan_tip_path(placed, height, settings);
}

}  // namespace

void bind_planning(nb::module_& m) {
  nb::enum_<Phase>(m, "Phase", "What a path does at an instant.")
      .value("travel", Phase::travel)
      .value("approach", Phase::approach)
      .value("draw", Phase::draw)
      .value("lift", Phase::lift)
      .value("done", Phase::done);
  using S = PathSettings;
  Record<S>(m, "PathSettings", "Speeds, accelerations and heights of a tip path.")
      .field("X_WP", &S::X_WP, "drawing frame P, z out of the drawing plane")
      .field("start_p_WE", &S::start_p_WE, "tip at t = 0, shape (3,) [m]")
      .field("start_n_W", &S::start_n_W, "−z_E at t = 0, unit, shape (3,)")
      .field("start_hold", &S::start_hold, "rest at the start [s], 0 to 120")
      .field("hover_height", &S::hover_height, "start of the approach, along n [m]")
      .field("approach_speed", &S::approach_speed, "[m/s]")
      .field("settle_time", &S::settle_time, "rest at the first point [s]")
      .field("draw_speed", &S::draw_speed, "[m/s]")
      .field("draw_acceleration", &S::draw_acceleration, "[m/s²]")
      .field("end_hold", &S::end_hold, "rest at the last point [s]")
      .field("dot_time", &S::dot_time, "of a dot, besides settle_time [s]")
      .field("travel_speed", &S::travel_speed, "[m/s]")
      .field("travel_acceleration", &S::travel_acceleration, "[m/s²]")
      .field("turn_speed", &S::turn_speed, "of n during travel [rad/s]")
      .field("turn_acceleration", &S::turn_acceleration, "[rad/s²]")
      .field("safe_height", &S::safe_height, "travel above the surface's highest point [m]")
      .field("highest_z", &S::highest_z,
             "the surface's highest point [m]; None: the highest that the strokes touch")
      .field("smoothing_time", &S::smoothing_time, "over which an acceleration builds up [s]")
      .field("corner_angle_deg", &S::corner_angle_deg, "a larger turn is a corner [deg]")
      .field("tolerance", &S::tolerance, "of the line against the strokes [m]")
      .field("rounding", &S::rounding, "beside bends made of straight lines [m]")
      .field("knot_spacing", &S::knot_spacing, "largest between surface queries [m]")
      .field("normal_smoothing", &S::normal_smoothing, "length over which normals are averaged [m]")
      .field("tilt_allowance_deg", &S::tilt_allowance_deg,
             "by which n may leave the normal to turn slower [deg]")
      .field("lean_deg", &S::lean_deg, "of n towards the drawing's axis, at most [deg]")
      .field("tilt_speed", &S::tilt_speed, "of n along a stroke [rad/s]")
      .field("tilt_acceleration", &S::tilt_acceleration, "[rad/s²]")
      .field("normal_acceleration", &S::normal_acceleration, "across the surface [m/s²]")
      .field("normal_speed", &S::normal_speed, "the normal's error times the speed [m/s]")
      .field("joint_speed_share", &S::joint_speed_share, "of the arm's joint speeds, 0.01 to 1")
      .field("joint_acceleration", &S::joint_acceleration, "of each joint [rad/s²]")
      .field("joint_torque_share", &S::joint_torque_share,
             "of the torque that the controller may use, 0.01 to 1")
      .field("vertical_pen", &S::vertical_pen, "n = +z always")
      .field("sink", &S::sink, "of the desired point below the surface [m]")
      .done();
  Record<PathSample>(m, "PathSample", "A tip path at one instant.")
      .field("reference", &PathSample::reference, "planned motion of the tip")
      .field("stroke", &PathSample::stroke, "number of the stroke; −1 between strokes")
      .field("along", &PathSample::along, "position on it [m]")
      .field("phase", &PathSample::phase, "what the path does")
      .done();
  nb::class_<TipPath>(m, "TipPath", "The pen tip's motion in time, for a whole drawing.")
      .def_prop_ro("duration", &TipPath::duration, "[s]")
      .def_prop_ro("pen_down_length", &TipPath::pen_down_length, "on the surface [m]")
      .def("at", &TipPath::at, nb::arg("t"), "At t [s], held within 0 and the duration.");
  m.def(
      "plan_tip_path", &plan_path, nb::arg("strokes"), nb::arg("surface"),
      nb::arg("settings") = PathSettings(),
      nb::sig(
          "def plan_tip_path(strokes: collections.abc.Sequence[numpy.typing.ArrayLike], "
          "surface: SurfaceEstimator | Canvas | float, settings: PathSettings = ...) -> TipPath"),
      "Plans the tip's motion along strokes, each of shape (N, 2) in the drawing plane P [m].\n"
      "surface: an estimator, a canvas, or the height of a level plane in P [m]. ValueError for a\n"
      "setting out of range or a stroke point without surface.");
}

}  // namespace impedraw::python
