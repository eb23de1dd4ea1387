#include "impedraw/judge/force_case.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "impedraw/common/minimum_jerk.h"

namespace impedraw {
namespace {

constexpr double kRadius = 0.30, kHalf = 0.18;  // of the bowl's sphere; of the sheets [m]
constexpr double kRound = 2e-3;                 // of the believed edge [m]
const double kFall = std::tan(10.0 * std::numbers::pi / 180.0);

// A sheet that falls from x = 0 to either side. Its strips beside the edge keep the other normals
// from being smoothed across it.
TriangleMesh strips(const Eigen::Vector3d& p_W, double fall) {
  constexpr double kStrip = 5e-4;  // [m]
  TriangleMesh mesh;
  for (const double x : {-kHalf, -kStrip, 0.0, kStrip, kHalf})
    for (const double y : {-kHalf, kHalf})
      mesh.vertices.push_back(p_W + Eigen::Vector3d(x, y, -fall * std::abs(x)));
  for (int i = 0; i < 8; i += 2) {
    mesh.triangles.emplace_back(i, i + 2, i + 3);
    mesh.triangles.emplace_back(i, i + 3, i + 1);
  }
  return mesh;
}

// Height over the middle and slope, of the believed sheet.
struct Height {
  double z, slope;
};

Height height(Workpiece::Shape shape, double x) {
  if (shape == Workpiece::Shape::flat) return {0.0, 0.0};
  const double round = std::sqrt(x * x + kRound * kRound);
  return {-kFall * (round - kRound), -kFall * x / round};
}

}  // namespace

TriangleMesh Workpiece::mesh() const {
  if (shape != Shape::bowl) return strips(p_W, shape == Shape::roof ? kFall : 0.0);
  CapSettings cap;
  cap.radius = kRadius;
  cap.centre = p_W + kRadius * Eigen::Vector3d::UnitZ();
  cap.opening_radius = kHalf;
  return make_bowl(cap);
}

Workpiece::Place Workpiece::at(double x, double y) const noexcept {
  Place place;
  if (shape == Shape::bowl) {
    place.p_W = {x, y, kRadius - std::sqrt(kRadius * kRadius - x * x - y * y)};
    place.n_W = (kRadius * Eigen::Vector3d::UnitZ() - place.p_W) / kRadius;
  } else {
    const Height h = height(shape, x);
    place.p_W = {x, y, h.z};
    place.n_W = Eigen::Vector3d(-h.slope, 0.0, 1.0).normalized();
  }
  return {p_W + X_WB * place.p_W, X_WB.R * place.n_W};
}

SurfaceEstimate Workpiece::estimate(const Eigen::Vector3d& q_W) const noexcept {
  const Eigen::Vector3d q = X_WB.inverse() * (q_W - p_W);
  SurfaceEstimate found;
  found.status = SurfaceStatus::ok;
  if (shape == Shape::bowl) {
    const Eigen::Vector3d inward = kRadius * Eigen::Vector3d::UnitZ() - q;
    found.distance = kRadius - inward.norm();
    found.n_W = X_WB.R * inward.normalized();
  } else {
    const Height h = height(shape, q.x());
    const Eigen::Vector3d n = Eigen::Vector3d(-h.slope, 0.0, 1.0).normalized();
    found.distance = (q.z() - h.z) * n.z();
    found.n_W = X_WB.R * n;
  }
  return found;
}

namespace {

constexpr double kTravelSpeed = 0.08, kLeastTravel = 0.3;  // [m/s], mean; [s]
constexpr double kRise = 0.04;                             // of the press, first order [s]
constexpr double kSteady = 0.4;                            // judged at the end of a plateau [s]

std::vector<ForceCase> contacts() {
  std::vector<ForceCase> cases;
  for (const int speed : {10, 30, 100}) {
    ForceCase c;
    c.name = fmt::format("contact-{}", speed);
    c.text = fmt::format("from free air at {} mm/s, then 5 N", speed);
    c.approach_speed = 1e-3 * speed;
    c.duration = 1.0;
    c.judge_contact = true;
    cases.push_back(c);
  }
  return cases;
}

std::vector<ForceCase> commands() {
  ForceCase steps;
  steps.name = "steps";
  steps.text = "steps 5, 10, 5, 2 N";
  steps.duration = 6.0;
  steps.command = {{0, 5}, {1, 5}, {1, 10}, {2.5, 10}, {2.5, 5}, {4, 5}, {4, 2}, {6, 2}};
  ForceCase ramps;
  ramps.name = "ramps";
  ramps.text = "ramps to 15 N and back, at 10 and 50 N/s";
  ramps.duration = 6.0;
  ramps.command = {{0, 5}, {1, 5}, {2, 15}, {3, 15}, {3.2, 5}, {4.2, 5}, {4.4, 15}, {6, 15}};
  ForceCase sweep;
  sweep.name = "sweep";
  sweep.text = "sine of 2 N about 6 N, 0.5 to 50 Hz";
  sweep.sweep.emplace();
  sweep.duration = sweep.sweep->duration;
  return {steps, ramps, sweep};
}

std::vector<ForceCase> holdings() {
  std::vector<ForceCase> cases(4);
  for (ForceCase& c : cases) c.shape = Workpiece::Shape::flat;
  cases[0].shape = Workpiece::Shape::bowl;
  cases[0].name = "hold-still";
  cases[0].text = "5 N on a workpiece that stands";
  cases[1].name = "hold-sliding";
  cases[1].text = "5 N on one that slides by ±40 mm at 0.5 Hz";
  cases[1].motion.emplace();
  cases[1].motion->sway = {0.04, 0.0, 0.0};
  cases[2].name = "hold-tilting";
  cases[2].text = "5 N on one that tilts by ±2° at 0.4 Hz, 50 mm beside its axis";
  cases[2].motion.emplace();
  cases[2].motion->centre = {-0.05, 0.0, 0.0};
  cases[2].motion->roll_axis = Eigen::Vector3d::UnitY();
  cases[2].motion->roll = 2.0 * std::numbers::pi / 180.0;
  cases[2].motion->roll_frequency = 0.4;
  cases[3].name = "hold-stiffening";
  cases[3].text = "5 N while the surface stiffens from 1 kN/m to 1 MN/m";
  cases[3].stiffness = Eigen::Vector2d(1e3, 1e6);
  for (ForceCase& c : cases) c.duration = 5.0;
  return cases;
}

std::vector<ForceCase> paths() {
  struct Kind {
    const char *name, *text;
    Workpiece::Shape shape;
    double length;
    int slow, fast;  // [mm/s]
  };
  std::vector<ForceCase> cases;
  for (const Kind& kind :
       {Kind{"straight", "along a plane", Workpiece::Shape::flat, 0.15, 50, 150},
        Kind{"curved", "through a bowl of 0.3 m", Workpiece::Shape::bowl, 0.15, 50, 150},
        Kind{"edged", "over an edge of 20°", Workpiece::Shape::roof, 0.10, 25, 75}})
    for (const int speed : {kind.slow, kind.fast}) {
      ForceCase c;
      c.name = fmt::format("{}-{}", kind.name, speed);
      c.text = fmt::format("5 N {} at {} mm/s", kind.text, speed);
      c.shape = kind.shape;
      c.path_length = kind.length;
      c.path_speed = 1e-3 * speed;
      c.duration = 1.0 + 1.875 * c.path_length / c.path_speed;  // least jerk; half a second of rest
      cases.push_back(c);
    }
  return cases;
}

std::vector<ForceCase> hands() {
  ForceCase across, lifting;
  across.name = "hand-across";
  across.text = "a hand pushes the pen across by 10 N for a second";
  across.hand.emplace();
  across.hand->direction_W = Eigen::Vector3d::UnitY();
  lifting.name = "hand-lifting";
  lifting.text = "a hand lifts the pen by 3 N for a second";
  lifting.hand.emplace();
  lifting.hand->force = 0.0;
  lifting.hand->lift = 3.0;
  for (ForceCase* c : {&across, &lifting}) c->shape = Workpiece::Shape::flat;
  return {across, lifting};
}

}  // namespace

std::vector<ForceCase> force_cases() {
  std::vector<ForceCase> all;
  for (const auto& some : {contacts(), commands(), holdings(), paths(), hands()})
    all.insert(all.end(), some.begin(), some.end());
  return all;
}

std::vector<ForceCase> force_cases(const std::vector<std::string>& names) {
  std::vector<ForceCase> all = force_cases(), kept;
  std::vector<std::string> known;
  for (const ForceCase& c : all) known.push_back(c.name);
  for (const std::string& name : names)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw InputError("--cases: " + not_among(name, known));
  for (ForceCase& c : all)
    if (names.empty() || std::find(names.begin(), names.end(), c.name) != names.end())
      kept.push_back(std::move(c));
  return kept;
}

ForceProgramme::ForceProgramme(const ForceCase& c, const Workpiece& believed,
                               const Eigen::Vector3d& p_WE, const Eigen::Vector3d& n_W)
    : c_(c), believed_(believed), p_0_(p_WE), n_0_(n_W) {
  const Workpiece::Place first = believed_.at(-0.5 * c_.path_length, 0.0);
  const double way = (first.p_W + kHover * first.n_W - p_0_).norm();
  travel_ = std::max(kLeastTravel, way / kTravelSpeed);
  descend_ = travel_ + kRest;
  touch_ = descend_ + kHover / c_.approach_speed;
  start_ = touch_ + kSettle;
  if (c_.sweep) c_.sweep->start = start_;
}

double ForceProgramme::share(double t) const noexcept {
  return std::clamp((t - start_) / c_.duration, 0.0, 1.0);
}

// Place on the path [m]: from rest to rest, its greatest speed is path_speed.
double ForceProgramme::along(double t) const noexcept {
  if (c_.path_length == 0.0) return 0.0;
  const double duration = 1.875 * c_.path_length / c_.path_speed;
  const double u = std::clamp((t - start_ - 0.5) / duration, 0.0, 1.0);
  return (MinimumJerk::at(u, duration).share - 0.5) * c_.path_length;
}

ForceProgramme::Point ForceProgramme::point(double t) const noexcept {
  const Workpiece::Place on = believed_.at(along(t), 0.0);
  const double lift = std::clamp((t - end()) / kLeave, 0.0, 1.0);
  const double down = std::clamp((t - descend_) / (touch_ - descend_), 0.0, 1.0);
  const double height = kHover * (1.0 - down + MinimumJerk::at(lift, kLeave).share);
  const Eigen::Vector3d p = on.p_W + height * on.n_W;
  if (t >= travel_) return {p, on.n_W};
  const double s = MinimumJerk::at(std::max(0.0, t) / travel_, travel_).share;
  return {p_0_ + s * (p - p_0_), (n_0_ + s * (on.n_W - n_0_)).normalized()};
}

double ForceProgramme::asked(double t, double* rate) const noexcept {
  *rate = 0.0;
  const double u = t - start_;
  if (c_.sweep) {
    if (u < 0.0 || u > c_.duration) return c_.sweep->mean;
    *rate = c_.sweep->rate(t);
    return c_.sweep->at(t);
  }
  const auto& knots = c_.command;
  if (u < knots.front().time) return knots.front().force;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    if (u >= knots[i].time) continue;
    *rate = (knots[i].force - knots[i - 1].force) / (knots[i].time - knots[i - 1].time);
    return knots[i - 1].force + *rate * (u - knots[i - 1].time);
  }
  return knots.back().force;
}

ForceCommand ForceProgramme::at(double t) const noexcept {
  constexpr double kStep = 5e-4;  // of the central differences [s]
  const Point before = point(t - kStep), now = point(t), after = point(t + kStep);
  ForceCommand command;
  TipReference& r = command.reference;
  r.p_WD = now.p;
  r.n_WD = now.n;
  r.v_WD = (after.p - before.p) / (2.0 * kStep);
  r.w_WD = now.n.cross((after.n - before.n) / (2.0 * kStep));
  // The descent begins and ends with a step of the speed, which nothing should follow.
  if (t < descend_ - kStep || t > touch_ + kStep) {
    r.a_WD = (after.p - 2.0 * now.p + before.p) / (kStep * kStep);
    r.alpha_WD = now.n.cross((after.n - 2.0 * now.n + before.n) / (kStep * kStep));
  }
  r.pen_down = t >= descend_ && t < end();
  double rate = 0.0;
  command.asked = asked(t, &rate);
  if (r.pen_down) {
    r.force = command.asked;
    r.force_rate = rate;
    if (t > touch_) command.press = command.asked * (1.0 - std::exp((touch_ - t) / kRise));
  }
  return command;
}

ForceQuestion ForceProgramme::question(double touch) const {
  ForceQuestion q;
  if (c_.judge_contact) {
    const double end = touch + kContact;
    q.from = touch;
    q.to = end;
    q.changes = {{touch, end, 0.0, c_.command.front().force}};
    q.steady = {{end - kSteady, end}};
    return q;
  }
  q.from = start_;
  q.to = end();
  q.sweep = c_.sweep;
  q.moves = c_.path_length > 0.0;
  const auto& knots = c_.command;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    if (knots[i].force == knots[i - 1].force) continue;
    const double until = i + 1 < knots.size() ? knots[i + 1].time : c_.duration;
    q.changes.push_back(
        {start_ + knots[i].time, start_ + until, knots[i - 1].force, knots[i].force});
    q.steady.push_back({start_ + until - kSteady, start_ + until});
  }
  if (q.changes.empty() && !c_.sweep) q.steady = {{q.from, q.to}};
  return q;
}

}  // namespace impedraw
