#include "impedraw/planning/preflight/preflight.h"

#include <nanobind/stl/vector.h>

#include "arm.h"
#include "module.h"
#include "planning.h"

namespace impedraw::python {

namespace {

Preflight checked(nb::handle strokes, nb::handle surface, Arm& arm, nb::handle start_q,
                  const PreflightSettings& settings, const Canvas* obstacle) {
  const std::vector<PlacedStroke> placed = strokes_of(strokes);
  const SurfaceHeight height = height_of(surface, settings.X_WP);
  const JointVector q = arm.vector(start_q, "start_q");
  const nb::gil_scoped_release no_gil;
  return check_strokes(placed, height, arm.model, obstacle, q, settings);
}

std::vector<Finding> checked_moves(const TipPath& path, nb::handle strokes, Arm& arm,
                                   nb::handle start_q, const PreflightSettings& settings,
                                   const Canvas* obstacle) {
  const std::vector<PlacedStroke> placed = strokes_of(strokes);
  const JointVector q = arm.vector(start_q, "start_q");
  const nb::gil_scoped_release no_gil;
  return check_transitions(path, placed, arm.model, obstacle, q, settings);
}

}  // namespace

void bind_preflight(nb::module_& m) {
  nb::enum_<Problem>(m, "Problem", "Why a part of a stroke cannot be drawn.")
      .value("off_canvas", Problem::off_canvas)
      .value("fold", Problem::fold)
      .value("crease", Problem::crease)
      .value("too_rough", Problem::too_rough)
      .value("too_steep", Problem::too_steep)
      .value("out_of_reach", Problem::out_of_reach)
      .value("joint_limit", Problem::joint_limit)
      .value("near_singular", Problem::near_singular)
      .value("torque", Problem::torque)
      .value("arm_collision", Problem::arm_collision)
      .value("pen_collision", Problem::pen_collision)
      .value("joint_jump", Problem::joint_jump)
      .value("crawls", Problem::crawls)
      .value("too_short", Problem::too_short);
  Record<StrokePart>(m, "StrokePart", "The interval [start, end] of a stroke, along its line.")
      .field("stroke", &StrokePart::stroke, "number of the stroke, from 0")
      .field("start", &StrokePart::from, "from its first point [m]")
      .field("end", &StrokePart::to, "from its first point [m]")
      .done();
  Record<Finding>(m, "Finding", "A part of a stroke that cannot be drawn, and why.")
      .field("part", &Finding::part, "which")
      .field("problem", &Finding::problem, "why")
      .field("text", &Finding::text, "the problem and its size at the worst point")
      .field("page_mm", &Finding::page_mm, "the worst point, shape (2,) [mm]")
      .field("p_W", &Finding::p_W, "the worst point, shape (3,) [m]")
      .done();
  using M = PreflightMargins;
  Record<M>(m, "PreflightMargins", "Worst values over the drawable parts.")
      .field("joint", &M::joint, "to the nearest joint limit [rad]")
      .field("torque_share", &M::torque_share, "of the arm's limits")
      .field("effective_mass", &M::effective_mass, "the tip's greatest [kg]")
      .field("clearance", &M::clearance, "of the arm without its pen [m]")
      .field("slope_deg", &M::slope_deg, "[deg]")
      .done();
  Record<Preflight>(m, "Preflight", "What can be drawn. Parts and findings cover each stroke.")
      .field("findings", &Preflight::findings, "by stroke, then along it")
      .field("drawable", &Preflight::drawable, "in the same order")
      .field("margins", &Preflight::margins, "over the drawable parts")
      .done();
  using S = PreflightSettings;
  Record<S>(m, "PreflightSettings", "What a stroke must keep to be drawn.")
      .field("X_WP", &S::X_WP, "drawing frame P of strokes and surface")
      .field("vertical_pen", &S::vertical_pen, "pen along −z_P, else along −n")
      .field("rest_q", &S::rest_q, "to which the null space pulls, shape (n,) [rad]; None: start_q")
      .field("arm", &S::arm, "False: only the surface is checked")
      .field("step", &S::step, "between postures, along a stroke [m]")
      .field("surface_step", &S::surface_step, "largest between surface samples [m]")
      .field("edge_tolerance", &S::edge_tolerance, "of the ends of parts [m]")
      .field("edge_margin", &S::edge_margin, "kept from edges and holes [m]")
      .field("shortest", &S::shortest, "part worth lowering the pen for [m]")
      .field("least_speed", &S::least_speed, "below which a stretch is left out [m/s]; 0: never")
      .field("roughest", &S::roughest, "misfit beyond which a place is not drawn on [m]")
      .field("max_slope_deg", &S::max_slope_deg, "of the surface against z_P [deg]")
      .field("fold_height", &S::fold_height, "the tip rides over lower steps [m]")
      .field("normal_smoothing", &S::normal_smoothing, "as in PathSettings [m]")
      .field("lean_deg", &S::lean_deg, "as in PathSettings")
      .field("joint_margin", &S::joint_margin, "inside each joint's range [rad]")
      .field("max_joint_step", &S::max_joint_step, "of any joint per step [rad]")
      .field("space", &S::space, "the controller's")
      .field("torque_share", &S::torque_share, "usable share of the arm's limits")
      .field("normal_force", &S::normal_force, "F [N]")
      .field("friction", &S::friction, "of the tip")
      .field("clearance", &S::clearance, "of arm and pen from canvas and table [m]")
      .field("table_z", &S::table_z, "height of an infinite table [m]; None: no table")
      .done();
  m.def("check_strokes", &checked, nb::arg("strokes"), nb::arg("surface"), nb::arg("arm"),
        nb::arg("start_q"), nb::arg("settings") = PreflightSettings(),
        nb::arg("obstacle").none() = nb::none(),
        nb::sig("def check_strokes(strokes: collections.abc.Sequence[numpy.typing.ArrayLike], "
                "surface: SurfaceEstimator | Canvas | float, arm: ArmModel, start_q: "
                "numpy.typing.ArrayLike, settings: PreflightSettings = ..., obstacle: Canvas | "
                "None = None) -> Preflight"),
        "Checks, before anything moves, which parts of strokes can be drawn. strokes: each of\n"
        "shape (N, 2) in the drawing plane P [m]. start_q: the arm's posture before it moves,\n"
        "shape (n,) [rad]. obstacle: what the arm must not touch. Raises ValueError for a setting\n"
        "out of range.");
  m.def("check_transitions", &checked_moves, nb::arg("path"), nb::arg("strokes"), nb::arg("arm"),
        nb::arg("start_q"), nb::arg("settings") = PreflightSettings(),
        nb::arg("obstacle").none() = nb::none(),
        nb::sig("def check_transitions(path: TipPath, strokes: "
                "collections.abc.Sequence[numpy.typing.ArrayLike], arm: ArmModel, start_q: "
                "numpy.typing.ArrayLike, settings: PreflightSettings = ..., obstacle: Canvas | "
                "None = None) -> list[Finding]"),
        "Checks the motions between the strokes of a path that was planned from them.");
}

}  // namespace impedraw::python
