#include "impedraw/experiment/start_posture.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <Eigen/SVD>

#include "impedraw/arm/inverse_kinematics.h"

namespace impedraw {
namespace {

// a condition of 4 is as good as a joint in the middle of its range
constexpr double kCondition = 4.0;
constexpr int kSeeds = 200;                  // of the search
constexpr double kBeneathScale = 0.2;        // [m]
constexpr double kStep = 0.03, kJump = 0.5;  // of the tip [m], of a joint in it [rad]
constexpr double kMargin = 0.03;
constexpr double kAbove = 0.02;    // the drawing: there no link but the pen is near the canvas [m]
constexpr double kNearest = 0.35;  // share of the usual start's distance from the base

JointVector as_joints(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

// Sum over the links' capsules of the depth of their lowest end beneath the tip, along z_W.
double depth_beneath(const std::vector<BodyCapsule>& bodies, const Eigen::Vector3d& p_W,
                     const Eigen::Vector3d& z_W) {
  double sum = 0.0;
  for (const BodyCapsule& body : bodies)
    sum += std::max({0.0, z_W.dot(p_W - body.a_W), z_W.dot(p_W - body.b_W)});
  return sum;
}

using Touching = std::function<std::string(const JointVector&)>;
using Way = std::vector<Eigen::Vector3d>;

// The answer to whether the tip can be led from a posture to just above one place after the other
// without a jump of a joint or a posture near a limit or a singularity; and without a link that
// touches there.
enum class Leads { no, touching, clear };

Leads leads(ArmModel& arm, ArmTerms* terms, const PenPlacement& start, JointVector q,
            const Touching& touching, const Way& way) {
  PenPlacement at = start;
  bool clear = true;
  for (const Eigen::Vector3d& place : way) {
    const Eigen::Vector3d from = at.p_WE, to = place - kAbove * start.z_WE;
    const int steps = 1 + static_cast<int>((to - from).norm() / kStep);
    for (int i = 1; i <= steps; ++i) {
      at.p_WE = from + (to - from) * i / steps;
      const IkResult next = find_posture(arm, at, q);
      if (!next.reached || (next.q - q).cwiseAbs().maxCoeff() > kJump) return Leads::no;
      q = next.q;
    }
    if (posture_margin(arm, terms, q) < kMargin) return Leads::no;
    clear = clear && touching(q).empty();
  }
  return clear ? Leads::clear : Leads::touching;
}

// Seeds are drawn by hand: the standard's distributions differ between libraries. A posture in
// which a link touches only where no other was found.
IkResult searched(ArmModel& arm, const PenPlacement& start, const Touching& touching,
                  const Way& drawing) {
  constexpr double kTurn = std::numbers::pi;
  const JointVector lower = JointVector(arm.limits().lower).cwiseMax(-kTurn),
                    upper = JointVector(arm.limits().upper).cwiseMin(kTurn);
  std::mt19937 random(1);
  ArmTerms terms(arm.joints());
  std::optional<IkResult> best;
  std::tuple<bool, Leads, double> best_score;  // clear of the canvas; leads to the drawing
  for (int i = 0; i < kSeeds; ++i) {
    JointVector seed = 0.5 * (lower + upper);
    if (i > 0)
      for (Eigen::Index j = 0; j < seed.size(); ++j)
        seed[j] = lower[j] + random() * (upper[j] - lower[j]) / std::mt19937::max();
    const IkResult found = find_posture(arm, start, seed);
    if (!found.reached) {
      if (!best || (!best->reached && found.position_error < best->position_error)) best = found;
      continue;
    }
    const double beneath = depth_beneath(arm.body_capsules(found.q), start.p_WE, -start.z_WE);
    const double margin = posture_margin(arm, &terms, found.q) * std::exp(-beneath / kBeneathScale);
    const std::tuple score(touching(found.q).empty(),
                           leads(arm, &terms, start, found.q, touching, drawing), margin);
    if (best && best->reached && score <= best_score) continue;
    best = found;
    best_score = score;
  }
  return *best;
}

}  // namespace

void check_joint_settings(const Scenario& scenario, const std::filesystem::path& urdf,
                          const ArmModel& arm, const SettingErrors& setting_errors) {
  const auto check = [&](const std::string& name, const std::vector<double>& entries) {
    const auto joints = static_cast<std::size_t>(arm.joints());
    if (entries.empty() || entries.size() == joints) return;
    setting_errors.raise(
        {name, "arm.urdf"},
        fmt::format("{} has {} {}, but the arm {} has {} joints; valid are {} entries or none",
                    name, entries.size(), entries.size() == 1 ? "entry" : "entries", urdf.string(),
                    joints, joints));
  };
  check("arm.posture_seed", scenario.arm.posture_seed);
  check("arm.q_0", scenario.arm.q_0);
  check("control.null_stiffness", scenario.control.null_stiffness);
  check("control.observer.yield_limit", scenario.control.observer.yield_limit);
  const JointVector &lower = arm.limits().lower, &upper = arm.limits().upper;
  const auto within = [&](const char* setting, const std::string& name,
                          const std::vector<double>& q) {
    for (std::size_t j = 0; j < q.size(); ++j)
      if (const auto i = static_cast<Eigen::Index>(j); !(q[j] >= lower[i] && q[j] <= upper[i]))
        setting_errors.raise({setting},
                             fmt::format("{}: {:.4g} rad is beyond the range of joint {}; valid is "
                                         "{:.4g} to {:.4g} rad",
                                         name, q[j], j + 1, lower[i], upper[i]));
  };
  within("arm.posture_seed", "arm.posture_seed", scenario.arm.posture_seed);
  within("arm.q_0", "arm.q_0", scenario.arm.q_0);
  within("arm.urdf", urdf.string() + ": rest_posture", arm.rest_posture());
}

double posture_margin(ArmModel& arm, ArmTerms* terms, const JointVector& q) {
  const ArmLimits& limits = arm.limits();
  double joints = 1.0;
  for (Eigen::Index j = 0; j < q.size(); ++j) {
    const double half = 0.5 * (limits.upper[j] - limits.lower[j]);
    if (std::isfinite(half))
      joints = std::min(joints, std::min(q[j] - limits.lower[j], limits.upper[j] - q[j]) / half);
  }
  arm.compute(q, JointVector::Zero(q.size()), terms);
  Eigen::MatrixXd J = terms->J;
  J.bottomRows(3) *= kMarginLength;
  const Eigen::VectorXd sigma = Eigen::JacobiSVD<Eigen::MatrixXd>(J).singularValues();
  return std::min(joints, kCondition * sigma.minCoeff() / sigma.maxCoeff());
}

JointVector start_posture(ArmSettings& settings, ArmModel& arm, const Pose& X_WP,
                          const Way& drawing, const SettingErrors& setting_errors,
                          const Touching& touching, std::vector<std::string>* notes) {
  PenPlacement start{settings.start_p_WE, -X_WP.R.col(2)};
  std::vector<double> seed = settings.posture_seed;
  if (seed.empty()) seed = arm.rest_posture();
  if (seed.empty() && arm.joints() == 7) seed = {0.0, 0.6, 0.0, -1.4, 0.0, 1.1, 0.0};
  IkResult found = seed.empty() ? searched(arm, start, touching, drawing)
                                : find_posture(arm, start, as_joints(seed));
  const bool chosen = !settings.posture_seed.empty() || !arm.rest_posture().empty();
  ArmTerms terms(arm.joints());
  if (!chosen && !seed.empty() &&
      !(found.reached && leads(arm, &terms, start, found.q, touching, drawing) == Leads::clear))
    found = searched(arm, start, touching, drawing);
  if (!found.reached && settings.start_p_WE == ArmSettings().start_p_WE) {
    const IkResult there = found;
    for (const bool lower : {false, true})  // for a small arm with a long gripper
      for (double share = 0.9; !found.reached && share > kNearest; share -= 0.1) {
        start.p_WE = share * settings.start_p_WE;
        if (lower) start.p_WE.z() *= share;
        found = searched(arm, start, touching, drawing);
      }
    if (found.reached) {
      settings.start_p_WE = start.p_WE;
      notes->push_back(
          fmt::format("the usual start is out of the arm's reach by {:.0f} mm; the tip starts at "
                      "({:.3f}, {:.3f}, {:.3f}) m (arm.start places it elsewhere)",
                      1e3 * there.position_error, start.p_WE.x(), start.p_WE.y(), start.p_WE.z()));
    } else {
      found = there;
    }
  }
  std::string link = found.reached ? touching(found.q) : "";
  if (!link.empty() && !seed.empty()) {
    const IkResult other = searched(arm, start, touching, drawing);
    if (other.reached && touching(other.q).empty()) {
      found = other;
      link.clear();
    }
  }
  if (!found.reached)
    setting_errors.raise(
        {"arm.start", "arm"},
        fmt::format("arm.start ({:.3f}, {:.3f}, {:.3f}) m is out of the arm's reach by {:.0f} mm",
                    settings.start_p_WE.x(), settings.start_p_WE.y(), settings.start_p_WE.z(),
                    1e3 * found.position_error));
  if (!link.empty())
    setting_errors.raise(
        {"canvas.move", "arm.start", "canvas"},
        fmt::format("{} touches the canvas in the start posture, and a link does in every other "
                    "posture that was tried with the tip at arm.start ({:.3f}, {:.3f}, {:.3f}) m; "
                    "canvas.move or arm.start must keep the arm clear",
                    link, start.p_WE.x(), start.p_WE.y(), start.p_WE.z()));
  return found.q;
}

JointVector rest_posture(const ArmSettings& settings, const PlacedArtwork& artwork,
                         const std::vector<PlacedStroke>& strokes, const Belief& belief) {
  if (!settings.q_0.empty()) return as_joints(settings.q_0);
  const Eigen::Vector2d centre = artwork.placement.centre_m;
  auto middle = belief.surface(centre.x(), centre.y());
  for (std::size_t i = 0; i < strokes.size() && !middle; ++i) {
    const Eigen::Vector2d p = strokes[i].p_P[strokes[i].p_P.size() / 2];
    middle = belief.surface(p.x(), p.y());
  }
  const Eigen::Vector3d p_WE = middle ? artwork.X_WP * middle->p_P : settings.start_p_WE;
  ArmModel arm = belief.arm;
  return find_posture(arm, {p_WE, -artwork.X_WP.R.col(2)}, belief.start_q).q;
}

}  // namespace impedraw
