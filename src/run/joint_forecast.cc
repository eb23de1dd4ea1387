#include "impedraw/run/joint_forecast.h"

#include <algorithm>
#include <cmath>

#include "impedraw/arm/least_energy_step.h"

namespace impedraw {

JointForecast::JointForecast(ArmModel arm, const TipPath& path, const JointVector& start,
                             const JointVector& rest_q, double share) {
  constexpr int kSubsteps = 2;
  constexpr double kRelax = 0.5;         // time in which the redundant joints settle [s]
  constexpr double kFurthestStep = 0.3;  // of a joint; a longer one would leave the path [rad]
  constexpr double kLeast = 0.05;        // rate
  const double dt = kStep / kSubsteps;
  const double relax = 1.0 - std::exp(-dt / kRelax);
  const JointVector speed = arm.limits().speed;
  ArmTerms terms(arm.joints());
  arm.compute(start, JointVector::Zero(start.size()), &terms);
  const JointVector weight = relaxation_weight(terms);
  JointVector q = start;
  std::vector<float> own;
  for (double t = 0.0; t < path.duration(); t += kStep) {
    double fastest = 0.0;
    for (int k = 1; k <= kSubsteps; ++k) {
      const TipReference r = path.at(t + k * dt).reference;
      arm.compute(q, JointVector::Zero(q.size()), &terms);
      const LeastEnergyStep least =
          least_energy_step(terms, tip_displacement(terms.X_WE, r.p_WD, -r.n_WD, r.x_WD),
                            relax * weight.cwiseProduct(rest_q - q), 1e-6);
      // The clock slows the task's part alone.
      const JointVector& task = least.task;
      JointVector step = least.task + least.redundant;
      if (!step.allFinite()) return;
      fastest = std::max(fastest, (task.cwiseAbs().array() / speed.array()).maxCoeff() / dt);
      const double longest = step.cwiseAbs().maxCoeff();
      if (longest > kFurthestStep) step *= kFurthestStep / longest;
      q += step;
    }
    own.push_back(static_cast<float>(std::clamp(share / std::max(fastest, 1e-9), kLeast, 1.0)));
  }
  limits_ = own;
  const auto ahead = static_cast<std::size_t>(kAhead / kStep);
  for (std::size_t i = 0; i < own.size(); ++i)
    limits_[i] = *std::min_element(
        own.begin() + static_cast<std::ptrdiff_t>(i),
        own.begin() + static_cast<std::ptrdiff_t>(std::min(own.size(), i + ahead + 1)));
}

double JointForecast::limit(double t) const noexcept {
  if (limits_.empty() || !(t >= 0.0)) return 1.0;
  const auto i = static_cast<std::size_t>(t / kStep);
  return i < limits_.size() ? limits_[i] : 1.0;
}

}  // namespace impedraw
