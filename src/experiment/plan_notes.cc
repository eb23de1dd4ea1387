#include "impedraw/experiment/plan_notes.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "impedraw/control/operational_space.h"
#include "impedraw/planning/stroke_ruler.h"

namespace impedraw {

double wrap_doubt(const Plan& plan, const Belief& belief) {
  const Pose& X_WP = plan.path_settings.X_WP;
  const auto& seen = belief.perception;
  if (!seen || std::ranges::none_of(plan.wrap->chart().patch().samples, [&](const auto& s) {
        return seen->finer_share(X_WP * s.p_P) > 0.0;
      }))
    return 0.0;
  const auto finest_height = [&](double x, double y, SurfaceHeight::Sample& last) {
    SurfaceHeight::Sample sample = belief.surface(x, y, last);
    if (!sample) return sample;
    const SurfaceEstimate there = seen->estimate(X_WP * sample->p_P);
    const double lean = X_WP.R.col(2).dot(there.n_W);
    if (there.status == SurfaceStatus::ok && lean > 0.1) sample->p_P.z() -= there.distance / lean;
    return sample;
  };
  std::optional<Wrap> finest;
  try {
    finest = plan.wrap->laid_on(finest_height);
  } catch (const InputError&) {
    return std::numeric_limits<double>::infinity();
  }
  double squares = 0.0, length = 0.0;
  for (const PlacedStroke& stroke : *plan.laid)
    for (std::size_t i = 1; i < stroke.p_P.size(); ++i) {
      const auto here = plan.wrap->to_flat(stroke.p_P[i]), other = finest->to_flat(stroke.p_P[i]);
      if (!here || !other) continue;
      const double piece = (stroke.p_P[i] - stroke.p_P[i - 1]).norm();
      squares += piece * (*here - *other).squaredNorm();
      length += piece;
    }
  return length > 0.0 ? std::sqrt(squares / length) : 0.0;
}

void note_wrap(double doubt, std::vector<std::string>* notes) {
  constexpr double kDoubt = 3e-4;  // [m]
  if (doubt > kDoubt)
    notes->push_back(fmt::format(
        "wrap: on slopes as steep as here, what the cameras do not resolve shifts the page: {}",
        std::isinf(doubt)
            ? "with the finest heights seen it cannot be laid flat at all"
            : fmt::format("the drawing may lie {:.1f} mm RMS beside its place", 1e3 * doubt)));
}

std::optional<std::string> friction_note(const Scenario& s, ArmModel arm, const JointVector& q,
                                         const Eigen::Vector3d& n_W,
                                         const Eigen::VectorXd& dry_friction) {
  constexpr double kFelt = 0.2;  // of the normal force
  if (s.control.source != WrenchSource::none || s.arm.driver != ArmDriver::sim) return {};
  ArmTerms terms(arm.joints());
  arm.compute(q, JointVector::Zero(arm.joints()), &terms);
  OperationalSpace space(s.control.operational_space);
  space.update(terms);
  double at_tip = 0.0;
  for (int j = 0; j < arm.joints(); ++j)
    at_tip += dry_friction[j] *
              std::abs(n_W.dot(space.project_to_tip(JointVector::Unit(arm.joints(), j)).head<3>()));
  if (at_tip <= kFelt * s.control.normal_force) return {};
  return fmt::format(
      "the joints' dry friction of up to {:.3g} Nm is up to {:.2g} N at the tip, and without a "
      "wrench (control.wrench) nothing tells: the force of {:.3g} N may be off by as much",
      dry_friction.maxCoeff(), at_tip, s.control.normal_force);
}

std::vector<std::string> engraver_notes(const Scenario& s) {
  // The deepest that was held: a pass with exact sensing, and a whole groove, whatever the passes,
  // with realistic sensing and model errors [m].
  constexpr double kDeepestPass = 1.7e-3, kDeepest = 0.9e-3;
  std::vector<std::string> notes;
  if (s.tool.kind != ToolKind::engraver) return notes;
  const bool real = s.control.source == WrenchSource::realistic;
  const double asked = real ? s.tool.depth : s.tool.depth / s.tool.passes,
               most = real ? kDeepest : kDeepestPass;
  if (asked > most)
    notes.push_back(fmt::format(
        "tool.depth: {:.3g} mm {}; of those that were tried, the ones deeper than {:.1f} mm ended "
        "with a joint that swung",
        1e3 * asked, real ? "in all" : "a pass", 1e3 * most));
  if (s.perception.frames.enabled)
    notes.emplace_back(
        "tool.kind is engraver, and the canvas may move: the groove's depth is off by what the "
        "canvas's forecast is");
  return notes;
}

void note_spread_forces(const PathSettings& path, Plan* plan) {
  constexpr double kLess = 0.2;  // [N]
  double length = 0.0;
  for (const PlacedStroke& stroke : plan->strokes)
    length += ForceProfile(stroke, path.force_rate / path.draw_speed).spread_length(kLess);
  if (length > 0.0)
    plan->notes.push_back(
        fmt::format("the force changes by at most {:.3g} N/s: {:.1f} mm are "
                    "drawn lighter than asked, where widths jump",
                    path.force_rate, 1e3 * length));
}

void name_step(const Belief& belief, double roughest, Finding* f) {
  if (!belief.perception || f->problem != Problem::off_canvas) return;
  if (belief.planning->in_crease(f->p_W)) {
    f->problem = Problem::crease;
    f->text = "two sides of the surface meet at over 60° here, and the tip would touch both";
    return;
  }
  const Roughness there = belief.perception->roughness(f->p_W);
  const double height = 2e3 * there.misfit, width = 2e3 * there.radius;  // [mm]
  if (there.misfit > Roughness::kStepMisfit) {
    f->problem = Problem::fold;
    f->text = fmt::format("the surface steps by over {:.1f} mm within {:.0f} mm", height, width);
  } else if (there.rougher_than(roughest)) {
    f->problem = Problem::too_rough;
    f->text =
        fmt::format("rougher than the cameras resolve, by {:.1f} mm over {:.0f} mm", height, width);
  }
}

namespace {

constexpr double kCalm = 6e-5;          // RMS residual [m]
constexpr double kLeastSpacing = 2e-3;  // of the places, at least [m]
constexpr double kMostTried = 500;

// Calls visit with the surface at places along the strokes, evenly spaced.
template <class Visit>
void look_along(const std::vector<PlacedStroke>& strokes, const SurfaceHeight& surface,
                const Visit& visit) {
  double length = 0.0;
  for (const PlacedStroke& stroke : strokes) length += StrokeRuler(stroke).length();
  const double spacing = std::max(kLeastSpacing, length / kMostTried);
  SurfaceHeight::Sample last;
  for (const PlacedStroke& stroke : strokes) {
    const StrokeRuler ruler(stroke);
    for (double s = 0.0; s <= ruler.length(); s += spacing) {
      const Eigen::Vector2d p_P = ruler.at(stroke.start + s).p_P;
      if (const auto sample = surface(p_P.x(), p_P.y(), last)) visit(*sample);
    }
  }
}

}  // namespace

// In flat noise finer patches are in use, at most, in places.
bool is_rough(const Belief& belief, const Plan& plan) {
  constexpr double kOther = 0.02, kLeast = 0.1;  // [rad], [1]
  if (!belief.perception || !belief.perception->uses_finer()) return false;
  const Pose& X_WP = plan.path_settings.X_WP;
  double places = 0.0, other = 0.0;
  look_along(plan.strokes, belief.surface, [&](const SurfaceSample& sample) {
    const Eigen::Vector3d p_W = X_WP * sample.p_P;
    places += 1.0;
    if (belief.perception->finer_share(p_W) == 0.0) return;  // the normal is the plan's
    const SurfaceEstimate there = belief.perception->estimate(p_W);
    other +=
        there.status == SurfaceStatus::ok && there.n_W.cross(X_WP.R * sample.n_P).norm() > kOther;
  });
  return other > kLeast * places;
}

std::optional<std::string> roughness_note(const std::vector<PlacedStroke>& strokes,
                                          const SurfaceHeight& surface, const Pose& X_WP,
                                          const SurfaceEstimator& seen) {
  double squares = 0.0, places = 0.0;
  look_along(strokes, surface, [&](const SurfaceSample& sample) {
    const Roughness roughness = seen.roughness(X_WP * sample.p_P);
    squares += roughness.residual * roughness.residual;
    places += 1.0;
  });
  const double rms = places > 0.0 ? std::sqrt(squares / places) : 0.0;
  if (rms < kCalm) return std::nullopt;
  return fmt::format(
      "the surface is rough under the line, {:.2g} mm RMS within patches that the pen follows: the "
      "force may scatter by more than ± 0.6 N; slower (path.draw_speed) is calmer",
      1e3 * rms);
}

}  // namespace impedraw
