#include "impedraw/simulation/wrench_sensor.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace impedraw {

namespace {

Vector6 both(double force, double torque) {
  Vector6 v;
  v << force, force, force, torque, torque, torque;
  return v;
}

// G, from numbers of its own: the other faults stay as they are without it.
Eigen::Matrix<double, 6, 6> gain_of(const WrenchSensorSettings& s, std::uint64_t seed) {
  constexpr double kRanges = 10.0;  // of force over torque [1/m]
  SeededNormals normals(seed ^ 0x6a09e667f3bcc908u);
  Eigen::Matrix<double, 6, 6> G = Eigen::Matrix<double, 6, 6>::Identity();
  for (int i = 0; i < 6; ++i) {
    G(i, i) += std::copysign(s.gain_error, normals.next());
    Vector6 others;
    for (int j = 0; j < 6; ++j) others[j] = j == i ? 0.0 : normals.next();
    others *= s.cross_talk / others.norm();
    for (int j = 0; j < 6; ++j)
      G(i, j) += others[j] * (i / 3 == j / 3 ? 1.0 : i < 3 ? kRanges : 1.0 / kRanges);
  }
  return G;
}

}  // namespace

WrenchSensor::WrenchSensor(const WrenchSensorSettings& s, double dt, std::uint64_t seed)
    : normals_(seed) {
  require_valid(s, dt);
  noise_ = both(s.noise_force, s.noise_torque) * std::sqrt(1e-3 / dt);
  noisy_ = !noise_.isZero(0.0);
  quantum_ = both(s.quantum_force, s.quantum_torque);
  range_ = both(s.range_force, s.range_torque);
  const auto directions = [&] {
    Vector6 d = normals();
    d.head<3>().normalize();
    d.tail<3>().normalize();
    return d;
  };
  bias_ = both(s.bias_force, s.bias_torque).cwiseProduct(directions());
  drift_ = both(s.drift_force, s.drift_torque).cwiseProduct(directions()) * (dt / 60.0);
  if (s.gain_error > 0.0 || s.cross_talk > 0.0) gain_ = gain_of(s, seed);
  under_way_.resize(static_cast<std::size_t>(std::lround(s.delay / dt)));
}

Vector6 WrenchSensor::sample(const Vector6& F) noexcept {
  Reading now{(gain_ ? Vector6(*gain_ * F) : F) + bias_ + samples_ * drift_, false};
  if (noisy_) now.F += noise_.cwiseProduct(normals());
  for (int i = 0; i < 6; ++i) {
    if (range_[i] > 0.0 && std::abs(now.F[i]) >= range_[i]) {
      now.F[i] = std::copysign(range_[i], now.F[i]);
      now.saturated = true;
    }
    if (quantum_[i] > 0.0) now.F[i] = quantum_[i] * std::round(now.F[i] / quantum_[i]);
  }
  if (!under_way_.empty()) {
    if (samples_ == 0.0) std::fill(under_way_.begin(), under_way_.end(), now);
    std::swap(now, under_way_[oldest_]);
    oldest_ = (oldest_ + 1) % under_way_.size();
  }
  samples_ += 1.0;
  last_ = now;
  return last_.F;
}

Vector6 WrenchSensor::normals() noexcept {
  Vector6 z;
  for (double& value : z) value = normals_.next();
  return z;
}

}  // namespace impedraw
