// Prediction of one coordinate of a moving body: models of its motion, fitted to what was measured.
//
//   steady, drifting   constant velocity, or constant acceleration: Kalman filters whose highest
//                      derivative is driven by white noise of spectral density q
//   Matérn             the same where the motion is forgotten at a rate λ (matern_motion.h)
//   band-limited       any motion whose spectrum ends at f_c, beside a constant velocity: the
//                      linear predictor of least variance for a flat spectrum below f_c
//   swinging           x(t) = x0 + v0 t + Σ a_k cos ω_k t + b_k sin ω_k t, up to two sinusoids, by
//                      least squares over the last seconds; ω by search
//
// Sources: C. E. Rasmussen, C. K. I. Williams, "Gaussian Processes for Machine Learning", 2006,
// equation (2.25), for the band-limited model; Y. Bar-Shalom, "Estimation with Applications to
// Tracking and Navigation", section 6.2, for the filters.
#pragma once

#include <array>
#include <span>

#include "impedraw/perception/axis_state.h"

namespace impedraw {

// Model of a Kalman filter: state x, ẋ, ẍ up to `order`; q of its highest derivative's noise, λ.
struct AxisModel {
  int order = 1;
  double noise = 0.0, rate = 0.0;  // rate: 0, or with order 2 or 3 [1/s]
};

struct AxisFilter {
  AxisState state;
  // P: xx, xv, xa, vv, va, aa
  std::array<double, 6> P{};

  static AxisFilter started(double x, double variance, int order) noexcept;
  // Over dt ≥ 0. The noise is that of λ = 0, to first order in λ dt.
  void predict(double dt, const AxisModel& model) noexcept;
  void measure(double x, double variance) noexcept;
  AxisState ahead(double dt, double rate, int order) const noexcept;
};

// Measured at `time` [s], with its variance.
struct AxisSample {
  double time = 0.0, x = 0.0, variance = 1.0;
};

struct AxisWave {
  static constexpr int kSinusoids = 2;
  double origin = 0.0;  // of t [s]
  double x0 = 0.0, v0 = 0.0;
  std::array<double, kSinusoids> rate{}, cosine{}, sine{};  // ω [rad/s], a, b
  bool fitted = false;

  AxisState at(double time) const noexcept;
};

// A prediction as a polynomial of t − origin, beyond `span` at constant velocity.
struct AxisPolynomial {
  static constexpr int kTerms = 6;
  double origin = 0.0, span = 1.0;  // [s]
  std::array<double, kTerms> c{};   // of ((t − origin) / span)^k

  AxisState at(double time) const noexcept;
};

// The band-limited model, for several coordinates that were measured at the same times. Allocates
// nothing.
//   K_ij = sinc(2 f_c (t_i − t_j)) + trend + δ_ij r_i,   x(t) = k(t)ᵀ K⁻¹ x
// r_i: the measurement's variance against the motion's, 1/kPower for the average one.
class BandLimited {
 public:
  static constexpr int kMostSamples = 88;
  static constexpr double kWindow = 2.0;  // of the samples used [s]
  static constexpr double kSpan = 0.3;    // over which it predicts [s]
  static constexpr double kPower = 3e4;

  // times: in ascending order, at most kMostSamples; weights: 1 for the average measurement.
  // Returns false where it cannot be done.
  bool set(double cutoff, std::span<const double> times, std::span<const double> weights) noexcept;
  // x: at those times.
  AxisPolynomial predict(std::span<const double> x) const noexcept;

 private:
  int count_ = 0;
  double origin_ = 0.0;
  // For each of the prediction's coefficients, what each sample contributes.
  std::array<std::array<double, kMostSamples>, AxisPolynomial::kTerms> gain_{};
};

// Fits to the samples, in order of time. `search`: finds ω anew, from the last ones where there are
// any; else only the linear coefficients follow. A sinusoid that explains no more than noise does
// is left out. Leaves it not fitted where the samples last less than kLeastTime. Allocates nothing.
class WaveFit {
 public:
  static constexpr double kLeastTime = 2.5;                 // [s]
  static constexpr double kSlowest = 0.15, kFastest = 2.5;  // [Hz]
  static constexpr int kMostSamples = 256;
  static AxisWave fit(std::span<const AxisSample> samples, const AxisWave& last,
                      bool search) noexcept;
};

}  // namespace impedraw
