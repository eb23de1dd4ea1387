#include "impedraw/control/step_input.h"

#include <cmath>

namespace impedraw {

ControlStatus input_status(const ArmTerms& arm, const TipReference& reference,
                           const SurfaceEstimate& surface, const Wrench& F_ext,
                           const InputAges& ages, const ImpedanceSettings& settings,
                           Eigen::Index joints) noexcept {
  const bool measured = settings.wrench == WrenchFeedback::measured;
  ControlStatus status;
  status.stale_state = !(ages.state <= settings.timing.max_state_age);
  status.stale_wrench = measured && !(ages.wrench <= settings.timing.max_wrench_age);
  status.bad_input = true;
  const auto unit = [](const Eigen::Vector3d& n) { return std::abs(n.squaredNorm() - 1.0) < 1e-6; };
  if (arm.q.size() != joints || arm.v.size() != joints || arm.M.rows() != joints ||
      arm.M.cols() != joints || arm.Cv.size() != joints || arm.g.size() != joints ||
      arm.J.cols() != joints || !unit(reference.n_WD))
    return status;
  double sum = arm.q.sum() + arm.v.sum() + arm.M.sum() + arm.Cv.sum() + arm.g.sum() + arm.J.sum() +
               arm.Jdot_v.sum() + arm.X_WE.p.sum() + arm.X_WE.R.sum() + arm.V_WE.sum() +
               reference.p_WD.sum() + reference.v_WD.sum() + reference.a_WD.sum() +
               reference.n_WD.sum() + reference.w_WD.sum() + reference.alpha_WD.sum() +
               reference.x_WD.sum() + reference.yaw_rate + reference.yaw_acceleration +
               reference.force_rate + (reference.force >= 0.0 ? reference.force : NAN);
  if (surface.status == SurfaceStatus::ok) {
    if (!unit(surface.n_W)) return status;
    sum += surface.n_W.sum() + surface.distance;
  }
  if (measured && !status.stale_wrench) sum += F_ext.sum();
  status.bad_input = !std::isfinite(sum);
  return status;
}

}  // namespace impedraw
