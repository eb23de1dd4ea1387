#include "impedraw/control/contact_stability.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <Eigen/Eigenvalues>

#include "impedraw/common/errors.h"
#include "impedraw/control/damping.h"

namespace impedraw {

double spectral_radius(const ContactLoop& s) {
  // State: penetration x, its rate v, the last `delay_steps` forces and `velocity_steps` rates. The
  // tip force is discretised as in the simulator: explicit spring, implicit damper.
  const int velocities = 2 + s.delay_steps, n = velocities + s.velocity_steps;
  const double ratio = s.natural_mass / s.desired_mass;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(n, n);
  const double h_m = s.dt / s.natural_mass;
  const double implicit = 1.0 + h_m * s.contact_damping;
  // v⁺ (1 + h b/m) = v + h/m ( −k x − ratio B v_late − (ratio − 1) f_late ),
  // f = k x + b v⁺ pushing out
  A(1, 0) = -h_m * s.contact_stiffness / implicit;
  A(1, 1) = 1.0 / implicit;
  A(1, s.velocity_steps > 0 ? n - 1 : 1) -= h_m * ratio * s.damping / implicit;
  if (s.delay_steps > 0) A(1, velocities - 1) += -h_m * (ratio - 1.0) / implicit;
  A.row(0) = s.dt * A.row(1);
  A(0, 0) += 1.0;
  if (s.delay_steps > 0) {
    A.row(2) = s.contact_damping * A.row(1);
    A(2, 0) += s.contact_stiffness;
    for (int i = 3; i < velocities; ++i) A(i, i - 1) = 1.0;
  }
  for (int i = velocities; i < n; ++i) A(i, i == velocities ? 1 : i - 1) = 1.0;
  return A.eigenvalues().cwiseAbs().maxCoeff();
}

namespace {

// Returns true if the loop is stable for every natural mass up to the largest. `desired` and
// `damping` are functions of the natural mass.
template <typename DesiredMass, typename Damping>
bool stable(const ImpedanceSettings& settings, const DesiredMass& desired, const Damping& damping) {
  const TimingSettings& timing = settings.timing;
  const int steps = std::max(1, static_cast<int>(std::lround(timing.wrench_delay / timing.dt)));
  const int velocity_steps =
      static_cast<int>(std::lround((timing.velocity_age + timing.velocity_lag) / timing.dt));
  for (double m = 1.0; m <= settings.stability_check.natural_mass_max; m += 0.5)
    if (spectral_radius({m, desired(m), damping(m), settings.stability_check.contact_stiffness_max,
                         0.0, timing.dt, steps, velocity_steps}) >= 1.0)
      return false;
  return true;
}

// Rounds up to the three digits printed, so that the printed value is itself valid.
double rounded_up(double x) {
  const double digit = std::pow(10.0, std::floor(std::log10(x)) - 2.0);
  return std::ceil(x / digit) * digit;
}

[[noreturn]] void refuse(const char* format, double value, const ImpedanceSettings& settings,
                         double least) {
  char message[256];
  std::snprintf(message, sizeof message, format, value,
                settings.stability_check.contact_stiffness_max, 1e3 * settings.timing.wrench_delay,
                rounded_up(least));
  throw InputError(message);
}

}  // namespace

double lightest_stable_mass(double mass, double damping, const ImpedanceSettings& settings) {
  const auto holds = [&](double m_d) {
    const double b = damping * std::sqrt(m_d / mass);  // scaling of diagonal_damping()
    return stable(
        settings, [=](double) { return m_d; }, [=](double) { return b; });
  };
  const double most = 2.0 * settings.stability_check.natural_mass_max;
  double least = mass;
  while (least < most && !holds(least)) least *= 1.05;
  return least;
}

void check_contact_stability(double desired_mass, double damping,
                             const ImpedanceSettings& settings) {
  const double least = lightest_stable_mass(desired_mass, damping, settings);
  if (least == desired_mass) return;
  refuse(
      "inertia along the normal: %.3g kg is unstable with a tip of %.3g N/m with a wrench %.3g ms "
      "late; valid are %.3g kg or more",
      desired_mass, settings, least);
}

double lightest_stable_scale(double scale, double stiffness, const ImpedanceSettings& settings) {
  const auto holds = [&](double c) {
    return stable(
        settings, [=](double m) { return c * m; },
        [&](double m) { return 2.0 * settings.damping_ratio * std::sqrt(stiffness * c * m); });
  };
  double least = scale;
  while (least < 1.0 && !holds(least)) least *= 1.02;
  return least;
}

void check_scaled_contact_stability(double scale, double stiffness,
                                    const ImpedanceSettings& settings) {
  const double least = lightest_stable_scale(scale, stiffness, settings);
  if (least == scale) return;
  refuse(
      "inertia along the normal: %.3g times the natural one is unstable with a tip of %.3g N/m "
      "with "
      "a wrench %.3g ms late; valid are %.3g "
      "times or more",
      scale, settings, least);
}

void check_damping_rates(const TipGain& damping, const TipGain& inertia, double dt_and_delay) {
  const auto check = [&](const char* axis, double b, double m) {
    if (b / m * dt_and_delay < kDampingLimit) return;
    char message[256];
    std::snprintf(message, sizeof message,
                  "inertia %s: damping rate %.3g 1/s times step and delay %.3g s reaches %.2f, the "
                  "limit is %.1f; valid is %.3g times the "
                  "inertia, or less stiffness",
                  axis, b / m, dt_and_delay, b / m * dt_and_delay, kDampingLimit,
                  rounded_up(1.001 * std::pow(b / m * dt_and_delay / kDampingLimit, 2)));
    throw InputError(message);
  };
  check("along the tangents", damping.linear.tangent, inertia.linear.tangent);
  check("along the normal", damping.linear.normal, inertia.linear.normal);
  check("about the tangents", damping.angular.tangent, inertia.angular.tangent);
  check("about the normal", damping.angular.normal, inertia.angular.normal);
}

}  // namespace impedraw
