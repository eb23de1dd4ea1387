#include "control/normal_loop.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <Eigen/Eigenvalues>

#include "common/errors.h"
#include "control/damping.h"

namespace impedraw {

double spectral_radius(const NormalLoop& s) {
  // State: penetration x, its rate v, and the last `delay_steps` forces. The tip's force is the simulator's: spring from the start of the
  // step, damper on the new velocity.
  const int n = 2 + s.delay_steps;
  const double ratio = s.natural_mass / s.wanted_mass;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  const double h_m = s.dt / s.natural_mass;
  const double implicit = 1.0 + h_m * s.contact_damping;
  // v⁺ (1 + h b/m) = v + h/m ( −k x − ratio B v − (ratio − 1) f_late ), f = k x + b v⁺ pushing out
  A(1, 0) = -h_m * s.contact_stiffness / implicit;
  A(1, 1) = (1.0 - h_m * ratio * s.damping) / implicit;
  if (s.delay_steps > 0) A(1, n - 1) += -h_m * (ratio - 1.0) / implicit;
  A.row(0) = s.dt * A.row(1);
  A(0, 0) += 1.0;
  if (s.delay_steps > 0) {
    A.row(2) = s.contact_damping * A.row(1);
    A(2, 0) += s.contact_stiffness;
    for (int i = 3; i < n; ++i) A(i, i - 1) = 1.0;
  }
  return A.eigenvalues().cwiseAbs().maxCoeff();
}

void check_normal_loop(double wanted_mass, double damping, const ImpedanceSettings& settings) {
  const auto stable = [&](double m_d) {
    for (double m = 1.0; m <= settings.natural_mass_max; m += 0.5) {
      const double b = damping * std::sqrt(m_d / wanted_mass);  // as diagonal_damping scales it
      const int steps = std::max(1, static_cast<int>(std::lround(settings.delay / settings.dt)));
      if (spectral_radius({m, m_d, b, settings.contact_stiffness_max, 0.0, settings.dt, steps}) >= 1.0) return false;
    }
    return true;
  };
  if (stable(wanted_mass)) return;
  double least = wanted_mass;
  while (least < 2.0 * settings.natural_mass_max && !stable(least)) least *= 1.05;
  char message[256];
  std::snprintf(message, sizeof message,
                "inertia along the normal: %.3g kg is unstable on a tip of %.3g N/m with a wrench %.3g ms late; valid are %.3g kg or more",
                wanted_mass, settings.contact_stiffness_max, 1e3 * settings.delay, least);
  throw InputError(message);
}

void check_damping_rates(const TipGain& damping, const TipGain& inertia, double dt_and_delay) {
  const auto check = [&](const char* axis, double b, double m) {
    if (b / m * dt_and_delay < kDampingLimit) return;
    char message[256];
    std::snprintf(message, sizeof message,
                  "inertia %s: damping rate %.3g 1/s times step and delay %.3g s reaches %.2f, the limit is %.1f; valid is %.3g times the "
                  "inertia, or less stiffness",
                  axis, b / m, dt_and_delay, b / m * dt_and_delay, kDampingLimit, std::pow(b / m * dt_and_delay / kDampingLimit, 2));
    throw InputError(message);
  };
  check("along the tangents", damping.linear.tangent, inertia.linear.tangent);
  check("along the normal", damping.linear.normal, inertia.linear.normal);
  check("about the tangents", damping.angular.tangent, inertia.angular.tangent);
  check("about the normal", damping.angular.normal, inertia.angular.normal);
}

}  // namespace impedraw
