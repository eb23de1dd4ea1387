#include "impedraw/experiment/place_auto.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/arm/inverse_kinematics.h"
#include "impedraw/experiment/plan.h"
#include "impedraw/experiment/prepare.h"
#include "impedraw/experiment/start_posture.h"
#include "impedraw/planning/stroke_ruler.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kCoarse = 24, kFine = 90;  // points of the drawing that are asked
constexpr int kCandidates = 8;           // that go on from the grid
constexpr int kPlanned = 2;              // of these, that are planned as a whole
// Distances of start and canvas from the base, over the usual ones: a large arm cannot fold up to
// these.
constexpr double kFarther[] = {1.5, 2.2, 3.2, 4.5};

struct Candidate {
  Vector2d move = Vector2d::Zero();
  double turn_deg = 0.0, margin = -std::numeric_limits<double>::infinity();
  double lost = std::numeric_limits<double>::infinity();  // that cannot be drawn [m]
};

// Turns about the vertical through `centre`, then moves.
Pose turned_about(const Vector2d& centre, const Vector2d& move, double turn_deg) {
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(turn_deg * std::numbers::pi / 180.0, Vector3d::UnitZ()).toRotationMatrix();
  const Vector3d pivot(centre.x(), centre.y(), 0.0);
  return {pivot + Vector3d(move.x(), move.y(), 0.0) - R * pivot, R};
}

struct Point {
  Vector3d p_W, n_W;
};

// Points spaced about evenly along the drawing, where there is a surface.
std::vector<Point> points_of(const PlannedDrawing& e, int count) {
  SurfaceHeight::Sample last;
  double length = 0.0;
  for (const PlacedStroke& stroke : e.plan.requested(e.artwork)) length += plane_length(stroke);
  const double step = std::max(length / count, 1e-3);
  std::vector<Point> points;
  for (const PlacedStroke& stroke : e.plan.requested(e.artwork)) {
    const StrokeRuler ruler(stroke);
    const double own = ruler.length();
    const int pieces = std::max(1, static_cast<int>(std::lround(own / step)));
    for (int i = 0; i <= pieces; ++i) {
      const Vector2d p = ruler.at(own * i / pieces).p_P;
      if (const auto sample = e.surface()(p.x(), p.y(), last))
        points.push_back(
            {sample->p_P, e.belief.perception ? sample->n_P : Vector3d(Vector3d::UnitZ())});
    }
  }
  while (static_cast<int>(points.size()) > 2 * count) {  // many short strokes: every second one
    for (std::size_t i = 0; 2 * i < points.size(); ++i) points[i] = points[2 * i];
    points.resize((points.size() + 1) / 2);
  }
  return points;
}

double not_drawable(const std::vector<Finding>& findings) {
  double sum = 0.0;
  for (const Finding& f : findings) sum += f.part.length() + 1e-6;
  return sum;
}

class Search {
 public:
  explicit Search(const PlannedDrawing& e)
      : e_(e),
        arm_(e.belief.arm),
        terms_(e.belief.arm.joints()),
        centre_(e.scenario.drawing.placement.centre_m),
        coarse_(points_of(e, kCoarse)),
        fine_(points_of(e, kFine)) {
    if (fine_.empty()) throw InputError("--place auto: no part of the drawing lies on the canvas");
  }

  // The margin of a pose. Stops early once it is below `least`.
  double margin(const Candidate& c, bool fine,
                double least = -std::numeric_limits<double>::infinity()) {
    const Pose X = motion(c);
    IkSettings settings;
    settings.position_tolerance = settings.axis_tolerance = 1e-4;
    settings.max_steps = 60;
    JointVector q = e_.belief.start_q;
    double worst = 1.0;
    for (const Point& point : fine ? fine_ : coarse_) {
      const IkResult posture = find_posture(arm_, {X * point.p_W, -(X.R * point.n_W)}, q, settings);
      if (posture.reached) {
        q = posture.q;
        worst = std::min(worst, posture_margin(arm_, &terms_, q));
      } else {
        worst = std::min(worst, -posture.position_error - kMarginLength * posture.axis_error);
      }
      if (worst < least) return worst;
    }
    return worst;
  }

  // Length that the pre-flight finds impossible, with the canvas moved and nothing in the arm's way
  // [m].
  double lost(const Candidate& c) {
    const Pose X = motion(c);
    const Scenario& s = e_.scenario;
    const Vector2d& centre = e_.artwork.placement.centre_m;
    const auto middle = e_.surface()(centre.x(), centre.y());
    JointVector rest_q = e_.plan.rest_q;
    if (s.arm.q_0.empty() && middle)
      rest_q = find_posture(arm_, {X * middle->p_P, -Vector3d::UnitZ()}, e_.belief.start_q).q;
    return not_drawable(
        check_strokes(
            e_.plan.requested(e_.artwork), e_.surface(), e_.belief.arm, nullptr, e_.belief.start_q,
            preflight_settings(s, X * e_.artwork.X_WP, e_.belief.perception != nullptr, rest_q))
            .findings);
  }

  std::vector<Candidate> grid(const std::function<void(double)>& progress) {
    std::vector<Candidate> best;
    for_places(1.0, [&](Candidate c, double done) {
      if (progress) progress(0.6 * done);
      const double least =
          best.size() < kCandidates ? -std::numeric_limits<double>::infinity() : best.back().margin;
      c.margin = margin(c, false, least);
      best.push_back(c);
      std::sort(best.begin(), best.end(),
                [](const Candidate& a, const Candidate& b) { return a.margin > b.margin; });
      if (best.size() > kCandidates) best.pop_back();
      return true;
    });
    best.push_back({});  // where it stands is a candidate, too
    return best;
  }

  // True if some place `by` times as far away has a larger margin than `least`.
  bool has_better(double by, double least) {
    bool better = false;
    for_places(by, [&](const Candidate& c, double) {
      better = margin(c, false, least) > least;
      return !better;
    });
    return better;
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
  // Calls take(candidate, share done) for places before the arm, `by` times as far away as usual,
  // in four turns, as long as it returns true.
  template <class Take>
  void for_places(double by, Take&& take) const {
    constexpr int kAlong = 10, kAcross = 9, kTurns = 4;
    const double scale =
        by * std::max(1.0, e_.scenario.arm.start_p_WE.x() / ArmSettings().start_p_WE.x());
    for (int i = 0; i < kAlong; ++i)
      for (int j = 0; j < kAcross; ++j)
        for (int k = 0; k < kTurns; ++k)
          if (!take(
                  Candidate{scale * Vector2d(0.30 + 0.05 * i, -0.4 + 0.1 * j) - centre_, 90.0 * k},
                  static_cast<double>(i) / kAlong))
            return;
  }

  Pose motion(const Candidate& c) const { return turned_about(centre_, c.move, c.turn_deg); }

  const PlannedDrawing& e_;
  ArmModel arm_;
  ArmTerms terms_;
  Vector2d centre_;
  std::vector<Point> coarse_, fine_;
};

}  // namespace

Scenario moved(const Scenario& given, const Vector2d& move, double turn_deg) {
  Scenario s = given;
  const Vector2d centre = s.drawing.placement.centre_m;
  const Pose X = turned_about(centre, move, turn_deg);
  const auto to = [&X](const Vector3d& p) -> Vector3d { return X * p; };
  s.canvas.move = to(s.canvas.move);
  s.canvas.turn_deg = std::remainder(s.canvas.turn_deg + turn_deg, 360.0);
  CanvasMotionSettings& motion = s.canvas.motion;
  motion.centre = to(motion.centre);
  for (Vector3d* direction : {&motion.velocity, &motion.turn_axis, &motion.sway, &motion.roll_axis})
    *direction = X.R * *direction;
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

namespace {

// About the place where the canvas is. `farther`: loses distances where no posture is better.
PlacedCanvas place_about(const Scenario& scenario, const Places& places,
                         const std::function<void(double)>& progress,
                         std::vector<double>* farther = nullptr) {
  PreparedPlan e = prepare_plan(scenario, places, Unreachable::tell);
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
    found.back().lost = search.lost(found.back());
  }
  std::sort(found.begin(), found.end(), [](const Candidate& a, const Candidate& b) {
    return a.lost != b.lost ? a.lost < b.lost : a.margin > b.margin;
  });

  if (farther && found.front().lost > 0.0)
    std::erase_if(*farther,
                  [&](double by) { return !search.has_better(by, begun.front().margin); });

  // The whole pre-flight, of the best ones: what is lost without obstacles is lost with them.
  PlacedCanvas best;
  double least = std::numeric_limits<double>::infinity();
  int planned = 0;
  std::string why;
  for (const Candidate& c : found) {
    if (!(c.lost < least) || planned == kPlanned) break;
    const Scenario there = moved(given, c.move, c.turn_deg);
    double lost = std::numeric_limits<double>::infinity();
    try {
      lost = not_drawable(prepare_plan(there, places, Unreachable::tell).plan.preflight.findings);
      ++planned;
    } catch (const InputError& error) {  // for example, out of the cameras' view
      if (why.empty()) why = fmt::format(", at the best one by this: {}", error.what());
    }
    if (!(lost < least)) continue;
    least = lost;
    best = {there, c.turn_deg, c.margin, before, lost == 0.0};
    if (best.passes) break;
  }
  if (!std::isfinite(least))
    throw InputError(fmt::format(
        "--place auto: the drawing cannot be drawn at any place that was tried{}; --place surface "
        "keeps the object where it is, and looks for a place on it",
        why));
  return best;
}

// The first of these larger distances at which the drawing passes, for an arm too large for the
// usual place.
std::optional<PlacedCanvas> place_farther(const Scenario& scenario, const Places& places,
                                          const std::vector<double>& farther,
                                          const std::function<void(double)>& progress) {
  if (scenario.arm.start_p_WE != ArmSettings().start_p_WE) return {};  // a start that was asked for
  for (std::size_t i = 0; i < farther.size(); ++i) {
    const double by = farther[i];
    Scenario far = moved(scenario, (by - 1.0) * scenario.drawing.placement.centre_m, 0.0);
    far.arm.start_p_WE *= by;
    if (far.fence.low == FenceSettings().low) far.fence.low *= by;
    if (far.fence.high == FenceSettings().high) far.fence.high *= by;
    const auto tell = [&](double share) {
      progress((static_cast<double>(i) + share) / static_cast<double>(farther.size()));
    };
    try {
      const PlacedCanvas found = place_about(far, places, tell);
      if (found.passes) return found;
    } catch (const InputError&) {  // what is wrong is told of the usual place
    }
  }
  return {};
}

}  // namespace

PlacedCanvas place_automatically(const Scenario& scenario, const Places& places,
                                 const std::function<void(double)>& progress) {
  if (!scenario.drawing.tilt_deg.isZero())
    throw InputError("--place auto needs a level drawing plane: drawing.tilt must be [0, 0, 0]");
  if (!scenario.canvas.motion.file.empty())
    throw InputError(
        "--place auto cannot move a recorded motion: canvas.motion.file must be empty");
  if (scenario.canvas.kind == CanvasKind::seen)
    throw InputError(
        "--place auto moves the canvas, and one of kind seen stands where it was seen; valid is "
        "--place surface, which looks for a place on it");
  const auto half = [&](double from) {
    return [&progress, from](double share) {
      if (progress) progress(from + 0.5 * share);
    };
  };
  std::vector<double> farther(std::begin(kFarther), std::end(kFarther));
  try {
    const PlacedCanvas near = place_about(scenario, places, half(0.0), &farther);
    return near.passes ? near : place_farther(scenario, places, farther, half(0.5)).value_or(near);
  } catch (const InputError&) {
    if (const auto far = place_farther(scenario, places, farther, half(0.5))) return *far;
    throw;
  }
}

}  // namespace impedraw
