#include "impedraw/experiment/place_auto.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/common/errors.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/start_posture.h"
#include "impedraw/planning/stroke_ruler.h"

namespace impedraw {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kCoarse = 24, kFine = 90;  // points of the drawing that are asked
constexpr int kCandidates = 8;           // that go on from the grid

struct Candidate {
  Vector2d move = Vector2d::Zero();
  double turn_deg = 0.0, margin = -std::numeric_limits<double>::infinity();
};

struct Point {
  Vector3d p_W, n_W;
};

// Points spaced about evenly along the drawing, where there is a surface.
std::vector<Point> points_of(const PlannedDrawing& e, int count) {
  SurfaceHeight::Sample last;
  double length = 0.0;
  for (const PlacedStroke& stroke : e.plan.requested) length += plane_length(stroke);
  const double step = std::max(length / count, 1e-3);
  std::vector<Point> points;
  for (const PlacedStroke& stroke : e.plan.requested) {
    const StrokeRuler ruler(stroke);
    const double own = ruler.length();
    const int pieces = std::max(1, static_cast<int>(std::lround(own / step)));
    for (int i = 0; i <= pieces; ++i) {
      const Vector2d p = ruler.at(own * i / pieces).p_P;
      if (const auto sample = e.surface()(p.x(), p.y(), last))
        points.push_back(
            {sample->p_P, e.scene.perception ? sample->n_P : Vector3d(Vector3d::UnitZ())});
    }
  }
  while (static_cast<int>(points.size()) > 2 * count) {  // many short strokes: every second one
    for (std::size_t i = 0; 2 * i < points.size(); ++i) points[i] = points[2 * i];
    points.resize((points.size() + 1) / 2);
  }
  return points;
}

class Search {
 public:
  explicit Search(PlannedDrawing& e)
      : e_(e),
        terms_(e.scene.arm.joints()),
        centre_(e.scenario.drawing.placement.centre_m),
        coarse_(points_of(e, kCoarse)),
        fine_(points_of(e, kFine)) {
    if (fine_.empty()) throw InputError("--place auto: no part of the drawing lies on the canvas");
  }

  // The margin of a pose. Stops early once it is below `least`.
  double margin(const Candidate& c, bool fine,
                double least = -std::numeric_limits<double>::infinity()) {
    const Eigen::Matrix3d R =
        Eigen::AngleAxisd(c.turn_deg * std::numbers::pi / 180.0, Vector3d::UnitZ())
            .toRotationMatrix();
    const Vector3d pivot(centre_.x(), centre_.y(), 0.0), shift(c.move.x(), c.move.y(), 0.0);
    IkSettings settings;
    settings.position_tolerance = settings.axis_tolerance = 1e-4;
    settings.max_steps = 60;
    JointVector q = e_.scene.start_q;
    double worst = 1.0;
    for (const Point& point : fine ? fine_ : coarse_) {
      const Vector3d p_WE = R * (point.p_W - pivot) + pivot + shift;
      const IkResult posture = find_posture(e_.scene.arm, {p_WE, -(R * point.n_W)}, q, settings);
      if (posture.reached) {
        q = posture.q;
        worst = std::min(worst, posture_margin(e_.scene.arm, &terms_, q));
      } else {
        worst = std::min(worst, -posture.position_error - kMarginLength * posture.axis_error);
      }
      if (worst < least) return worst;
    }
    return worst;
  }

  std::vector<Candidate> grid(const std::function<void(double)>& progress) {
    std::vector<Candidate> best;
    constexpr int kAlong = 10, kAcross = 9, kTurns = 4;
    for (int i = 0; i < kAlong; ++i) {
      if (progress) progress(0.6 * i / kAlong);
      for (int j = 0; j < kAcross; ++j) {
        for (int k = 0; k < kTurns; ++k) {
          Candidate c{Vector2d(0.30 + 0.05 * i, -0.4 + 0.1 * j) - centre_, 90.0 * k};
          const double least = best.size() < kCandidates ? -std::numeric_limits<double>::infinity()
                                                         : best.back().margin;
          c.margin = margin(c, false, least);
          best.push_back(c);
          std::sort(best.begin(), best.end(),
                    [](const Candidate& a, const Candidate& b) { return a.margin > b.margin; });
          if (best.size() > kCandidates) best.pop_back();
        }
      }
    }
    best.push_back({});  // where it stands is a candidate, too
    return best;
  }

  // Steps along x, y and turn, halved where none is better.
  Candidate refined(Candidate c) {
    c.margin = margin(c, true);
    double way = 0.04, angle = 30.0;
    while (way > 0.003) {
      bool better = false;
      for (int axis = 0; axis < 3; ++axis) {
        for (double sign : {-1.0, 1.0}) {
          Candidate next = c;
          if (axis < 2)
            next.move[axis] += sign * way;
          else
            next.turn_deg += sign * angle;
          next.margin = margin(next, true, c.margin);
          if (next.margin > c.margin + 1e-6) c = next, better = true;
        }
      }
      if (!better) way /= 2, angle /= 2;
    }
    c.turn_deg = std::remainder(c.turn_deg, 360.0);
    return c;
  }

 private:
  PlannedDrawing& e_;
  ArmTerms terms_;
  Vector2d centre_;
  std::vector<Point> coarse_, fine_;
};

double not_drawable(const PlannedDrawing& e) {
  double sum = 0.0;
  for (const Finding& f : e.plan.preflight.findings) sum += f.part.length() + 1e-6;
  return sum;
}

}  // namespace

Scenario moved(const Scenario& given, const Vector2d& move, double turn_deg) {
  Scenario s = given;
  const Vector2d centre = s.drawing.placement.centre_m;
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(turn_deg * std::numbers::pi / 180.0, Vector3d::UnitZ()).toRotationMatrix();
  const Vector3d pivot(centre.x(), centre.y(), 0.0), shift(move.x(), move.y(), 0.0);
  const auto to = [&](const Vector3d& p) -> Vector3d { return R * (p - pivot) + pivot + shift; };
  s.canvas.move = to(s.canvas.move);
  s.canvas.turn_deg = std::remainder(s.canvas.turn_deg + turn_deg, 360.0);
  CanvasMotionSettings& motion = s.canvas.motion;
  motion.centre = to(motion.centre);
  for (Vector3d* direction : {&motion.velocity, &motion.turn_axis, &motion.sway, &motion.roll_axis})
    *direction = R * *direction;
  for (Fiducial& mark : s.perception.fiducials.points) mark.p_K = to(mark.p_K);
  s.drawing.placement.centre_m = centre + move;
  s.drawing.placement.rotate_deg = std::remainder(s.drawing.placement.rotate_deg + turn_deg, 360.0);
  for (CameraSettings& camera : s.perception.cameras) {
    camera.p_WC = to(camera.p_WC);
    camera.target_W = to(camera.target_W);
  }
  const Vector3d middle = (s.perception.region_lower + s.perception.region_upper) / 2;
  const Vector3d by = to(middle) - middle;
  s.perception.region_lower += by;
  s.perception.region_upper += by;
  return s;
}

PlacedCanvas place_automatically(const Scenario& scenario, const Places& places,
                                 const std::function<void(double)>& progress) {
  if (!scenario.drawing.tilt_deg.isZero())
    throw InputError("--place auto needs a level drawing plane: drawing.tilt must be [0, 0, 0]");
  if (!scenario.canvas.motion.file.empty())
    throw InputError(
        "--place auto cannot move a recorded motion: canvas.motion.file must be empty");
  PlannedDrawing e = prepare_plan(scenario, places, Unreachable::tell);
  // The place of a mesh that nobody has placed.
  Scenario given = scenario;
  given.canvas.move = e.scenario.canvas.move;
  Search search(e);
  const double before = search.margin({}, true);
  std::vector<Candidate> found;
  const std::vector<Candidate> begun = search.grid(progress);
  for (std::size_t i = 0; i < begun.size(); ++i) {
    if (progress) progress(0.6 + 0.3 * static_cast<double>(i) / static_cast<double>(begun.size()));
    found.push_back(search.refined(begun[i]));
  }
  std::sort(found.begin(), found.end(),
            [](const Candidate& a, const Candidate& b) { return a.margin > b.margin; });

  PlacedCanvas best;
  double least = std::numeric_limits<double>::infinity();
  for (const Candidate& c : found) {
    const Scenario there = moved(given, c.move, c.turn_deg);
    double lost = std::numeric_limits<double>::infinity();
    try {
      lost = not_drawable(prepare_plan(there, places, Unreachable::tell));
    } catch (const InputError&) {  // for example, out of the cameras' view
    }
    if (!(lost < least)) continue;
    least = lost;
    best = {there, c.move, c.turn_deg, c.margin, before, lost == 0.0};
    if (best.passes) break;
  }
  if (!std::isfinite(least))
    throw InputError("--place auto: the drawing cannot be drawn at any place that was tried");
  return best;
}

}  // namespace impedraw
