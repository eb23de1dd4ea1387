#include "impedraw/experiment/experiment.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/common/errors.h"
#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/snapshot.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/planning/wrap/wrap.h"
#include "impedraw/settings/setting_error.h"

namespace impedraw {

namespace {

// one-sidedness: 2 mm within the rim of the standard bowl; the controller's 0.66 is 1 mm beyond it
constexpr double kEdgeOfPlanning = 0.5;

std::filesystem::path urdf_of(const ArmSettings& s) {
  return s.urdf.empty() ? std::filesystem::path(IMPEDRAW_ROOT) / "models/iiwa14_pen.urdf" : s.urdf;
}

std::string joint_text(const JointVector& q) {
  std::string text;
  for (double x : q) text += fmt::format("{}{:.2f}", text.empty() ? "" : ", ", x);
  return text;
}

// What the controller's checks look at, the likeliest culprit first.
std::vector<std::string> control_settings() {
  std::vector<std::string> names;
  for (const char* name :
       {"wrench", "inertia", "mass_normal", "mass_tangent", "rotational_inertia_tangent",
        "rotational_inertia_normal", "contact.leave_distance", "contact.enter_distance",
        "contact_stiffness_max", "natural_mass_max", "damping_ratio", "stiffness_normal",
        "stiffness_tangent"})
    names.push_back(std::string("control.") + name);
  names.push_back("control");
  return names;
}

// The pre-flight's settings, completed from the rest of the scenario.
PreflightSettings preflight_settings(const Experiment& e) {
  PreflightSettings s = e.scenario.preflight;
  s.X_WP = e.X_WP;
  s.vertical_pen = !e.perception;
  s.normal_force = e.scenario.control.normal_force;
  s.torque_share = e.scenario.control.torque_share;
  s.friction = e.scenario.control.friction.coefficient;
  s.normal_smoothing = e.scenario.path.normal_smoothing;
  s.space = e.scenario.control.operational_space;
  s.rest_q = e.control.null_space.q_0;
  return s;
}

// Each with a number of its own, in their order; `source`: of which stroke of the artwork each is.
std::vector<PlacedStroke> renumbered(std::vector<PlacedStroke> strokes, std::vector<int>* source) {
  source->clear();
  for (PlacedStroke& stroke : strokes) {
    source->push_back(stroke.number);
    stroke.number = static_cast<int>(source->size()) - 1;
    stroke.start = 0.0;
  }
  return strokes;
}

// What the wrap has no surface for.
Finding off_patch(const std::vector<PlacedStroke>& flat, const StrokePart& part, const Pose& X_WP) {
  const StrokePlace middle =
      place_on(flat[static_cast<std::size_t>(part.stroke)], (part.from + part.to) / 2);
  return {part, Problem::off_canvas, "off the patch of the surface that the wrap lays flat",
          middle.page, X_WP * Eigen::Vector3d(middle.p_P.x(), middle.p_P.y(), 0.0)};
}

// What is promised, from what the pre-flight leaves of the whole; throws or notes what it does not,
// as `unreachable` says.
void promise(Experiment& e, Unreachable unreachable) {
  e.notes.erase(std::remove_if(e.notes.begin(), e.notes.end(),
                               [](const std::string& n) { return n.starts_with("not drawn: "); }),
                e.notes.end());
  const std::vector<Finding>& findings = e.preflight.findings;
  if (!findings.empty() && unreachable != Unreachable::tell) {
    const std::string first = refusal_text(findings.front(), e.perception.has_value());
    const std::string more =
        findings.size() == 1 ? "" : fmt::format(", and {} more such places", findings.size() - 1);
    if (unreachable == Unreachable::refuse)
      throw InputError(
          fmt::format("{}{}; ./impedraw plan shows all of them, --skip-unreachable draws the rest",
                      first, more));
    if (e.preflight.drawable.empty())
      throw InputError(fmt::format("nothing can be drawn: {}{}; ./impedraw plan shows all of them",
                                   first, more));
    for (const Finding& f : findings) e.notes.push_back("not drawn: " + finding_text(f));
  }
  e.strokes.clear();
  for (const StrokePart& part : e.preflight.drawable) {
    PlacedStroke stroke =
        part_of(e.whole[static_cast<std::size_t>(part.stroke)], part.from, part.to);
    stroke.number = static_cast<int>(e.strokes.size());
    stroke.start = 0.0;
    e.strokes.push_back(std::move(stroke));
  }
}

// Takes a point that turned out to have no surface, and a little on both sides of it, out of what
// is drawn.
void leave_out(Experiment& e, const OffSurface& off) {
  constexpr double kAbout = 3e-3;  // [m]
  const PlacedStroke& stroke = e.strokes[static_cast<std::size_t>(off.stroke)];
  double along = 0.0, nearest = std::numeric_limits<double>::infinity(), before = 0.0;
  for (std::size_t i = 0; i < stroke.p_P.size(); ++i) {
    if (i > 0) before += (stroke.p_P[i] - stroke.p_P[i - 1]).norm();
    const Eigen::Vector2d a = stroke.p_P[i], way = i + 1 < stroke.p_P.size()
                                                       ? Eigen::Vector2d(stroke.p_P[i + 1] - a)
                                                       : Eigen::Vector2d::Zero();
    const double share = way.squaredNorm() > 0.0
                             ? std::clamp((off.p - a).dot(way) / way.squaredNorm(), 0.0, 1.0)
                             : 0.0;
    const double distance = (a + share * way - off.p).norm();
    if (distance < nearest) nearest = distance, along = before + share * way.norm();
  }
  std::vector<StrokePart>& drawable = e.preflight.drawable;
  const StrokePart whole = drawable[static_cast<std::size_t>(off.stroke)];
  StrokePart gone{whole.stroke, whole.from + std::max(0.0, along - kAbout),
                  std::min(whole.to, whole.from + along + kAbout)};
  std::vector<StrokePart> left;
  for (const StrokePart& part : {StrokePart{whole.stroke, whole.from, gone.from},
                                 StrokePart{whole.stroke, gone.to, whole.to}}) {
    if (part.length() > e.scenario.preflight.shortest)
      left.push_back(part);
    else
      (part.from == whole.from ? gone.from : gone.to) =
          part.from == whole.from ? part.from : part.to;
  }
  drawable.erase(drawable.begin() + off.stroke);
  drawable.insert(drawable.begin() + off.stroke, left.begin(), left.end());
  const StrokePlace place = place_on(stroke, along);
  gone.stroke = e.source[static_cast<std::size_t>(whole.stroke)];
  e.preflight.findings.push_back({gone, Problem::off_canvas, "at an edge of the canvas", place.page,
                                  e.X_WP * Eigen::Vector3d(off.p.x(), off.p.y(), 0.0)});
}

// Plans the path, and leaves out what no way leads to.
void plan_path(Experiment& e, Unreachable unreachable) {
  while (!e.strokes.empty()) {  // each round leaves out at least one
    e.path = plan_from(e, e.strokes, e.scenario.arm.start_p_WE, e.X_WP.R.col(2),
                       e.path_settings.start_hold);
    if (!e.scenario.preflight.arm) return;
    const std::vector<Finding> ways = check_transitions(e.path, e.strokes, e.arm, e.canvas.get(),
                                                        e.start_q, preflight_settings(e));
    if (ways.empty()) return;
    // Findings are about the numbers of the path; a stroke whose way is barred is one that cannot
    // be drawn.
    std::vector<StrokePart> left;
    for (std::size_t i = 0; i < e.preflight.drawable.size(); ++i) {
      const auto barred = std::find_if(ways.begin(), ways.end(), [&](const Finding& f) {
        return f.part.stroke == static_cast<int>(i);
      });
      if (barred == ways.end()) {
        left.push_back(e.preflight.drawable[i]);
      } else {
        Finding f = *barred;
        f.part = e.preflight.drawable[i];
        f.part.stroke = e.source[static_cast<std::size_t>(f.part.stroke)];
        e.preflight.findings.push_back(std::move(f));
      }
    }
    if (left.size() == e.preflight.drawable.size()) throw InputError(finding_text(ways.front()));
    e.preflight.drawable = std::move(left);
    promise(e, unreachable);
  }
  e.path = TipPath();
}

// The rest posture of the null space.
JointVector rest_posture(Experiment& e, const SettingErrors& setting_errors) {
  const Scenario& s = e.scenario;
  const int n = e.arm.joints();
  if (!s.arm.q_0.empty()) {
    if (static_cast<int>(s.arm.q_0.size()) != n)
      setting_errors.raise({"arm.q_0"}, fmt::format("arm.q_0 has {} entries, the arm {} joints",
                                                    s.arm.q_0.size(), n));
    const JointVector q_0 = Eigen::Map<const Eigen::VectorXd>(s.arm.q_0.data(), n);
    if (((q_0 - JointVector(e.arm.limits().lower)).array() < 0.0).any() ||
        ((JointVector(e.arm.limits().upper) - q_0).array() < 0.0).any())
      setting_errors.raise(
          {"arm.q_0"},
          fmt::format("arm.q_0 ({}) rad lies beyond the joint ranges, ({}) to ({}) rad",
                      joint_text(q_0), joint_text(e.arm.limits().lower),
                      joint_text(e.arm.limits().upper)));
    return q_0;
  }
  const Eigen::Vector2d c = s.drawing.placement.centre_m;
  const SurfaceHeight surface = e.surface();
  auto middle = surface(c.x(), c.y());
  for (std::size_t i = 0; i < e.whole.size() && !middle; ++i) {
    const Eigen::Vector2d p = e.whole[i].p_P[e.whole[i].p_P.size() / 2];
    middle = surface(p.x(), p.y());
  }
  const Eigen::Vector3d p_WE = middle ? e.X_WP * middle->p_P : s.arm.start_p_WE;
  return find_posture(e.arm, {p_WE, -e.X_WP.R.col(2)}, e.start_q).q;
}

void complete_control(Experiment& e, double wrench_delay, const SettingErrors& setting_errors) {
  const Scenario& s = e.scenario;
  const int n = e.arm.joints();
  const JointVector q_0 = e.control.null_space.q_0;
  ImpedanceSettings& control = e.control;
  control = s.control;
  control.timing.dt = s.world.dt;
  control.wrench =
      s.control.source == WrenchSource::none ? WrenchFeedback::none : WrenchFeedback::measured;
  control.timing.wrench_delay = wrench_delay;
  if (s.control.torque_delay)
    control.timing.loop_delay =
        std::max(control.timing.loop_delay, *s.control.torque_delay + control.timing.dt);
  control.surface.drawing_axis_W = e.X_WP.R.col(2);
  control.limits.torque = s.control.torque_share * e.arm.limits().torque;
  control.limits.torque_rate = Eigen::VectorXd::Constant(n, s.control.torque_rate);
  control.joint_range.lower = e.arm.limits().lower;
  control.joint_range.upper = e.arm.limits().upper;
  control.null_space.q_0 = q_0;
  setting_errors.locate(control_settings(), [&] {
    ImpedanceController(control, n);
  });  // its checks, before anything is written
}

}  // namespace

SurfaceHeight Experiment::surface() const {
  if (planning) return perceived_height(*planning, X_WP);
  if (scenario.blind.height == BlindHeight::canvas) return canvas_height(*canvas, X_WP);
  return [z = scenario.blind.plane_z](double x, double y) {
    return SurfaceSample{{x, y, z}, Eigen::Vector3d::UnitZ()};
  };
}

Pose drawing_frame(const DrawingSettings& drawing) {
  const Eigen::Vector3d a = drawing.tilt_deg * std::numbers::pi / 180.0;
  return {Eigen::Vector3d::Zero(), (Eigen::AngleAxisd(a.z(), Eigen::Vector3d::UnitZ()) *
                                    Eigen::AngleAxisd(a.y(), Eigen::Vector3d::UnitY()) *
                                    Eigen::AngleAxisd(a.x(), Eigen::Vector3d::UnitX()))
                                       .toRotationMatrix()};
}

std::string refusal_text(const Finding& f, bool seen) {
  const auto words = [&f]() -> const char* {
    switch (f.problem) {
      case Problem::off_canvas:
        return "leaves the canvas";
      case Problem::fold:
        return "crosses a fold of the surface";
      case Problem::too_steep:
        return "lies on too steep a slope";
      case Problem::out_of_reach:
        return "leaves the arm's reach";
      case Problem::joint_limit:
        return "brings a joint to its limit";
      case Problem::near_singular:
        return "brings the arm near a singular posture";
      case Problem::torque:
        return "asks for too much torque";
      case Problem::arm_collision:
        return "brings the arm against canvas or table";
      case Problem::pen_collision:
        return "brings the pen's shaft against canvas or table";
      case Problem::joint_jump:
        return "cannot be followed without a jump of the joints";
      case Problem::too_short:
        return "has too short a rest";
    }
    return "fails";
  };
  return fmt::format(
      "stroke {} {}{}: {}, farthest at page ({:.1f}, {:.1f}) mm, world ({:.4f}, {:.4f}, {:.4f}) m",
      f.part.stroke, words(),
      seen && f.problem == Problem::off_canvas ? ", as the cameras see it" : "", f.text,
      f.page_mm.x(), f.page_mm.y(), f.p_W.x(), f.p_W.y(), f.p_W.z());
}

std::string finding_text(const Finding& f) {
  return fmt::format(
      "stroke {}, {:.1f} to {:.1f} mm of it: {}: {}; worst at page ({:.1f}, {:.1f}) mm, world "
      "({:.3f}, {:.3f}, {:.3f}) m",
      f.part.stroke, 1e3 * f.part.from, 1e3 * f.part.to, name_of(f.problem), f.text, f.page_mm.x(),
      f.page_mm.y(), f.p_W.x(), f.p_W.y(), f.p_W.z());
}

TipPath plan_from(const Experiment& e, const std::vector<PlacedStroke>& strokes,
                  const Eigen::Vector3d& p_WE, const Eigen::Vector3d& n_W, double hold) {
  PathSettings settings = e.path_settings;
  settings.start_p_WE = p_WE;
  settings.start_n_W = n_W;
  settings.start_hold = hold;
  return plan_tip_path(strokes, e.surface(), settings);
}

Experiment prepare(const Scenario& given, const Places& places, Unreachable unreachable,
                   const PrepareProgress& progress) {
  const auto tell = [&progress](const char* what, double share) {
    if (progress) progress(what, share);
  };
  tell("reading and ordering the artwork", 0.0);
  const SettingErrors setting_errors(places);
  if (unreachable == Unreachable::refuse && given.drawing.skip_unreachable)
    unreachable = Unreachable::skip;
  Scenario s = given;
  const bool seen = s.perception.enabled;

  s.drawing.placement = placement_settings(s.drawing);
  Shape artwork = make_artwork(s.drawing, setting_errors);
  const std::vector<std::string> where_drawn = {"drawing.placement.scale",
                                                "drawing.placement.width",
                                                "drawing.placement.height",
                                                "drawing.placement.fit_width",
                                                "drawing.placement.fit_height",
                                                "drawing.placement.fit_radius",
                                                "drawing.placement.centre",
                                                "drawing.placement",
                                                "canvas",
                                                "drawing"};
  const Placement placement =
      setting_errors.locate(where_drawn, [&] { return place(artwork.drawn, s.drawing.placement); });

  std::vector<std::string> notes = artwork.drawn.warnings;
  auto owned_canvas = setting_errors.locate(
      {"canvas"}, [&] { return std::make_unique<Canvas>(make_mesh(s.canvas, &notes)); });
  const Canvas& canvas = *owned_canvas;

  // A sensor is tared at rest before anything moves.
  const bool sensed = has_sensor(s.control.source);
  s.world.flange_sensor = sensed;
  const WrenchSensorSettings sensor = s.control.source == WrenchSource::realistic
                                          ? WrenchSensorSettings::realistic()
                                          : s.wrench_sensor;
  const WrenchEstimatorSettings estimator =
      estimator_settings(s.control.sensing, sensor, s.world.dt, s.world.gravity);
  double wrench_delay = s.world.dt;
  setting_errors.locate({"control.sensing", "wrench_sensor", "control.wrench"}, [&] {
    WrenchInput(s.control.source, estimator, sensor, s.world.dt, 0);
    if (sensed) wrench_delay += WrenchEstimator(estimator).group_delay();
  });

  // The world first: its reader of URDF says what is wrong, the arm model's prints lines of its
  // own.
  auto world = setting_errors.locate(
      {"arm.urdf"}, [&] { return std::make_unique<World>(urdf_of(s.arm), &canvas, s.world); });
  Experiment e{
      .scenario = std::move(s),
      .notes = std::move(notes),
      .artwork = std::move(artwork),
      .placement = placement,
      .X_WP = drawing_frame(given.drawing),
      .canvas = std::move(owned_canvas),
      .arm = setting_errors.locate({"arm.urdf"}, [&] { return ArmModel(urdf_of(given.arm)); }),
      .sensor = sensor,
      .estimator = estimator,
      .world = std::move(world)};
  const Scenario& sc = e.scenario;
  const Eigen::Vector3d z_WP = e.X_WP.R.col(2);
  if (sc.arm.posture_seed.size() != e.arm.joints())
    setting_errors.raise({"arm.posture_seed", "arm.urdf"},
                         fmt::format("arm.posture_seed has {} entries, the arm {} joints",
                                     sc.arm.posture_seed.size(), e.arm.joints()));
  const IkResult start =
      find_posture(e.arm, {sc.arm.start_p_WE, -z_WP}, JointVector(sc.arm.posture_seed));
  if (!start.reached)
    setting_errors.raise(
        {"arm.start", "arm"},
        fmt::format("arm.start ({:.3f}, {:.3f}, {:.3f}) m is out of the arm's reach by {:.0f} mm",
                    sc.arm.start_p_WE.x(), sc.arm.start_p_WE.y(), sc.arm.start_p_WE.z(),
                    1e3 * start.position_error));
  e.start_q = start.q;
  e.world->set_state(start.q, JointVector::Zero(e.arm.joints()));

  const std::vector<std::string> how_seen = {"perception.region_lower",
                                             "perception.region_upper",
                                             "perception.cameras",
                                             "perception.voxel",
                                             "perception.noise",
                                             "perception",
                                             "canvas"};
  if (seen) {
    tell("looking at the canvas", 0.3);
    setting_errors.locate(how_seen, [&] {
      e.perception.emplace(take_snapshot(sc, canvas, *e.world, e.arm, start.q));
    });
    NormalSettings cautious = sc.perception.normals;
    cautious.max_one_sidedness = std::min(cautious.max_one_sidedness, kEdgeOfPlanning);
    e.planning.emplace(PointCloud(e.perception->cloud()), cautious);
  }

  // Blind, the desired point lies beneath the surface: the stiffness makes the push.
  PathSettings& path = e.path_settings;
  path = sc.path;
  path.X_WP = e.X_WP;
  if (sensed) path.start_hold = std::max(path.start_hold, sc.control.sensing.tare_time + 1.0);
  if (!seen) {
    path.vertical_pen = true;
    if (!(sc.control.stiffness.linear.normal > 0.0))
      setting_errors.raise(
          {"control.stiffness_normal"},
          "control.stiffness_normal is 0 N/m: blind, it makes the push; valid is more than 0 N/m");
    if (sc.blind.height == BlindHeight::canvas)
      path.sink = sc.control.normal_force / sc.control.stiffness.linear.normal;
    double highest = -1e9;
    for (const Eigen::Vector3d& v_W : canvas.mesh().vertices)
      highest = std::max(highest, z_WP.dot(v_W - e.X_WP.p));
    path.highest_z = highest;
  }
  e.start_hold = path.start_hold;

  const bool wraps = sc.drawing.mapping == Mapping::wrap;
  const std::vector<PlacedStroke> flat = placed_strokes(e.artwork.drawn, placement);
  WrappedStrokes laid{flat, {}};
  if (wraps) {
    laid = setting_errors.locate({"drawing.wrap", "drawing.mapping", "drawing"}, [&] {
      e.wrap.emplace(e.surface(), sc.drawing.placement.centre_m, flat, sc.drawing.wrap);
      return e.wrap->wrap(flat);
    });
  }
  e.whole = renumbered(std::move(laid.strokes), &e.source);
  e.control.null_space.q_0 = rest_posture(e, setting_errors);
  e.preflight = setting_errors.locate({"preflight"}, [&] {
    return check_strokes(e.whole, e.surface(), e.arm, e.canvas.get(), start.q,
                         preflight_settings(e),
                         [&](double share) { tell("checking the strokes", 0.4 + 0.4 * share); });
  });
  for (Finding& f : e.preflight.findings)
    f.part.stroke = e.source[static_cast<std::size_t>(f.part.stroke)];
  for (const StrokePart& part : laid.lost)
    e.preflight.findings.push_back(off_patch(flat, part, e.X_WP));
  // What ought to come out lies on the true canvas, wherever the cameras saw it.
  const SurfaceHeight truth = canvas_height(canvas, e.X_WP);
  const auto true_target = [&] {
    std::vector<PlacedStroke> desired = e.strokes;
    if (e.preflight.findings.empty() && !wraps) {
      desired = placed_strokes(e.artwork.target, placement);
    } else if (wraps && seen) {
      for (PlacedStroke& stroke : desired)
        for (std::size_t i = 0; i < stroke.page.size(); ++i)
          stroke.p_P[i] = placement.to_plane(stroke.page[i]);
      desired = Wrap(truth, sc.drawing.placement.centre_m, desired, sc.drawing.wrap)
                    .wrap(desired)
                    .strokes;
    }
    return project_target(desired, truth);
  };
  for (bool done = false; !done;) {
    setting_errors.locate(where_drawn, [&] { promise(e, unreachable); });
    try {
      tell("planning the path", 0.8);
      plan_path(e, unreachable);
      e.target = true_target();
      done = true;
    } catch (const OffSurface& off) {
      leave_out(e, off);  // an edge that lies finer than the pre-flight looked
    } catch (const InputError& error) {
      setting_errors.raise({"path"}, error.what());
    }
  }
  for (Eigen::Vector3d& p : e.target.points) p = e.X_WP * p;

  complete_control(e, wrench_delay, setting_errors);
  return e;
}

}  // namespace impedraw
