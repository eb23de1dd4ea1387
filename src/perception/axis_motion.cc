#include "impedraw/perception/axis_motion.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>

#include "impedraw/perception/matern_motion.h"

namespace impedraw {

namespace {

constexpr double kFirstSpeed = 0.5, kFirstAcceleration = 2.0;  // standard deviation [1/s], [1/s²]

}  // namespace

AxisFilter AxisFilter::started(double x, double variance, int order) noexcept {
  AxisFilter f;
  f.state.x = x;
  f.P = {variance, 0.0,
         0.0,      order > 1 ? kFirstSpeed * kFirstSpeed : 0.0,
         0.0,      order > 2 ? kFirstAcceleration * kFirstAcceleration : 0.0};
  return f;
}

AxisState AxisFilter::ahead(double dt, double rate, int order) const noexcept {
  return MaternStep(order, rate, dt).of(state);
}

void AxisFilter::predict(double dt, const AxisModel& model) noexcept {
  if (!(dt > 0.0)) return;
  const MaternStep F(model.order, model.rate, dt);
  const double q = model.noise;
  const int order = model.order;
  state = F.of(state);
  auto& [xx, xv, xa, vv, va, aa] = P;
  // F P, then F P Fᵀ
  const double x_v = xv + F.xv * vv + F.xa * va, x_a = xa + F.xv * va + F.xa * aa,
               v_v = F.vv * vv + F.va * va, v_a = F.vv * va + F.va * aa,
               a_v = F.av * vv + F.aa * va, a_a = F.av * va + F.aa * aa;
  xx += F.xv * (xv + x_v) + F.xa * (xa + x_a);
  xv = F.vv * x_v + F.va * x_a;
  xa = F.av * x_v + F.aa * x_a;
  vv = F.vv * v_v + F.va * v_a;
  va = F.av * v_v + F.aa * v_a;
  aa = F.av * a_v + F.aa * a_a;
  const double t2 = dt * dt, t3 = t2 * dt;
  if (order > 2) {
    xx += q * t3 * t2 / 20.0;
    xv += q * t2 * t2 / 8.0;
    xa += q * t3 / 6.0;
    vv += q * t3 / 3.0;
    va += q * t2 / 2.0;
    aa += q * dt;
  } else if (order > 1) {
    xx += q * t3 / 3.0;
    xv += q * t2 / 2.0;
    vv += q * dt;
  } else {
    xx += q * dt;
  }
}

void AxisFilter::measure(double x, double variance) noexcept {
  auto& [xx, xv, xa, vv, va, aa] = P;
  const double s = 1.0 / (xx + variance), off = x - state.x;
  const double kx = xx * s, kv = xv * s, ka = xa * s;
  state.x += kx * off;
  state.v += kv * off;
  state.a += ka * off;
  vv -= kv * xv;
  va -= kv * xa;
  aa -= ka * xa;
  const double left = 1.0 - kx;
  xx *= left, xv *= left, xa *= left;
}

AxisState AxisWave::at(double time) const noexcept {
  const double t = time - origin;
  AxisState s{x0 + v0 * t, v0, 0.0};
  for (int k = 0; k < kSinusoids; ++k) {
    if (rate[k] == 0.0) continue;
    const double c = std::cos(rate[k] * t), n = std::sin(rate[k] * t);
    s.x += cosine[k] * c + sine[k] * n;
    s.v += rate[k] * (sine[k] * c - cosine[k] * n);
    s.a -= rate[k] * rate[k] * (cosine[k] * c + sine[k] * n);
  }
  return s;
}

AxisState AxisPolynomial::at(double time) const noexcept {
  const double u = (time - origin) / span, in = std::clamp(u, 0.0, 1.0);
  AxisState s;
  double rise = 0.0;
  for (int k = kTerms - 1; k >= 0; --k) {
    rise = rise * in + 2.0 * s.v;  // Horner's rule, differentiated twice
    s.v = s.v * in + s.x;
    s.x = s.x * in + c[k];
  }
  s.v /= span;
  s.a = in == u ? rise / (span * span) : 0.0;
  s.x += s.v * span * (u - in);
  return s;
}

bool BandLimited::set(double cutoff, std::span<const double> times,
                      std::span<const double> weights) noexcept {
  constexpr double kLevel = 1e2, kSlope = 1e2;  // prior variances of the trend, of x² and (x/s)²
  constexpr int n_nodes = AxisPolynomial::kTerms;
  const int n = static_cast<int>(times.size());
  count_ = 0;
  if (n < 4 || n > kMostSamples) return false;
  origin_ = times.back();
  const auto covariance = [&](double a, double b) {
    const double u = 2.0 * std::numbers::pi * cutoff * (a - b);
    return (std::abs(u) < 1e-6 ? 1.0 : std::sin(u) / u) + kLevel +
           kSlope * (a - origin_) * (b - origin_);
  };
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostSamples, kMostSamples> K(n, n);
  Eigen::Matrix<double, Eigen::Dynamic, n_nodes, 0, kMostSamples, n_nodes> k(n, n_nodes);
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j <= i; ++j) K(i, j) = covariance(times[i], times[j]);
    K(i, i) += 1.0 / (kPower * weights[i]);
  }
  // Chebyshev's nodes, then the coefficients through them.
  Eigen::Matrix<double, n_nodes, n_nodes> powers;
  for (int node = 0; node < n_nodes; ++node) {
    const double u = 0.5 - 0.5 * std::cos(std::numbers::pi * (node + 0.5) / n_nodes);
    for (int i = 0; i < n; ++i) k(i, node) = covariance(origin_ + kSpan * u, times[i]);
    for (int power = 0; power < n_nodes; ++power) powers(node, power) = std::pow(u, power);
  }
  const Eigen::LLT<decltype(K), Eigen::Lower> factor(K);
  if (factor.info() != Eigen::Success) return false;
  factor.solveInPlace(k);
  const Eigen::Matrix<double, n_nodes, n_nodes> inverse = powers.inverse();
  for (int term = 0; term < n_nodes; ++term)
    for (int i = 0; i < n; ++i) {
      gain_[term][i] = 0.0;
      for (int node = 0; node < n_nodes; ++node) gain_[term][i] += inverse(term, node) * k(i, node);
    }
  count_ = n;
  return true;
}

AxisPolynomial BandLimited::predict(std::span<const double> x) const noexcept {
  AxisPolynomial out;
  out.origin = origin_;
  out.span = kSpan;
  for (int term = 0; term < AxisPolynomial::kTerms; ++term)
    for (int i = 0; i < count_; ++i)
      out.c[term] += gain_[term][i] * (x[i] - x[count_ - 1]);  // near 0, for the trend's prior
  out.c[0] += x[count_ - 1];
  return out;
}

namespace {

constexpr int kMost = 2 + 2 * AxisWave::kSinusoids;
using Normal = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;
using Right = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMost, 1>;
constexpr int kMostRates = kMost + AxisWave::kSinusoids;
using Newton = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostRates, kMostRates>;
using NewtonRight = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostRates, 1>;

// Weighted least squares with the given rates, of which zeros are left out. Returns Σ w (x − fit)².
// The slope is drawn towards 0, as a sinusoid slower than the window could be taken for it.
double solve(std::span<const AxisSample> samples, double origin,
             const std::array<double, AxisWave::kSinusoids>& rates, AxisWave* out) {
  int n = 2;
  for (const double rate : rates) n += rate != 0.0 ? 2 : 0;
  Normal A = Normal::Zero(n, n);
  Right b = Right::Zero(n), basis(n);
  double square = 0.0;
  for (const AxisSample& s : samples) {
    const double t = s.time - origin, w = 1.0 / s.variance;
    basis[0] = 1.0;
    basis[1] = t;
    for (int k = 0, at = 2; k < AxisWave::kSinusoids; ++k) {
      if (rates[k] == 0.0) continue;
      basis[at++] = std::cos(rates[k] * t);
      basis[at++] = std::sin(rates[k] * t);
    }
    A.selfadjointView<Eigen::Lower>().rankUpdate(basis, w);
    b += w * s.x * basis;
    square += w * s.x * s.x;
  }
  A.diagonal() *= 1.0 + 1e-9;
  const Eigen::LLT<Normal> factor(A);  // reads the lower half
  const Right x = factor.solve(b);
  if (out) {
    out->origin = origin;
    out->x0 = x[0];
    out->v0 = x[1];
    out->rate = rates;
    for (int k = 0, at = 2; k < AxisWave::kSinusoids; ++k) {
      out->cosine[k] = rates[k] != 0.0 ? x[at++] : 0.0;
      out->sine[k] = rates[k] != 0.0 ? x[at++] : 0.0;
    }
  }
  return std::max(0.0, square - x.dot(b));
}

// The k-th rate that leaves least, near `first` or, where that is 0, anywhere.
double best_rate(std::span<const AxisSample> samples, double origin,
                 std::array<double, AxisWave::kSinusoids> rates, int k, double first,
                 double slowest, double* least) {
  const double fastest = 2.0 * std::numbers::pi * WaveFit::kFastest;
  const double span = samples.back().time - samples.front().time;
  double step = 2.0 * std::numbers::pi * 0.25 / span;
  double best = first;
  *least = 1e300;
  const auto trial = [&](double rate) {
    for (int other = 0; other < AxisWave::kSinusoids; ++other)  // two alike tell nothing apart
      if (other != k && rates[other] != 0.0 && std::abs(rate - rates[other]) < 2.0 * step) return;
    rates[k] = rate;
    const double left = solve(samples, origin, rates, nullptr);
    if (left < *least) {
      *least = left;
      best = rate;
    }
  };
  if (first == 0.0)
    for (double rate = slowest; rate <= fastest; rate += 2.0 * step) trial(rate);
  else
    trial(std::clamp(first, slowest, fastest));
  if (best == 0.0) return 0.0;
  for (double half = first == 0.0 ? step : 0.25 * step; half > 1e-3 * step; half *= 0.5) {
    const double middle = best;
    trial(std::clamp(middle - half, slowest, fastest));
    trial(std::clamp(middle + half, slowest, fastest));
  }
  return best;
}

// All rates at once, by Gauss and Newton's method, from good first ones; one by one, two that lie
// close would creep towards what is best. Returns what is left. Rates stay where they are if a step
// would bring nothing, or two of them too close.
double refine(std::span<const AxisSample> samples, double origin, double slowest,
              std::array<double, AxisWave::kSinusoids>* rates, double left) {
  constexpr int kSteps = 12, kHalvings = 6;
  constexpr double kEnough = 1e-4;  // of what is left
  const double fastest = 2.0 * std::numbers::pi * WaveFit::kFastest;
  const double apart =
      std::numbers::pi / (samples.back().time - samples.front().time);  // of two rates
  AxisWave wave;
  solve(samples, origin, *rates, &wave);
  for (int step = 0; step < kSteps; ++step) {
    int n = 2;
    for (const double rate : *rates) n += rate != 0.0 ? 3 : 0;
    Newton A = Newton::Zero(n, n);
    NewtonRight b = NewtonRight::Zero(n), basis(n);
    for (const AxisSample& s : samples) {
      const double t = s.time - origin, w = 1.0 / s.variance;
      basis[0] = 1.0;
      basis[1] = t;
      for (int k = 0, at = 2; k < AxisWave::kSinusoids; ++k) {
        if ((*rates)[k] == 0.0) continue;
        const double c = std::cos((*rates)[k] * t), d = std::sin((*rates)[k] * t);
        basis[at++] = c;
        basis[at++] = d;
        basis[at++] = t * (wave.sine[k] * c - wave.cosine[k] * d);  // ∂/∂ω
      }
      A.selfadjointView<Eigen::Lower>().rankUpdate(basis, w);
      b += w * (s.x - wave.at(s.time).x) * basis;
    }
    A.diagonal() *= 1.0 + 1e-9;
    const NewtonRight change = Eigen::LLT<Newton>(A).solve(b);
    const double before = left;
    double part = 1.0;
    for (int half = 0; half < kHalvings && left == before; ++half, part *= 0.5) {
      std::array<double, AxisWave::kSinusoids> trial = *rates;
      bool valid = true;
      for (int k = 0, at = 4; k < AxisWave::kSinusoids; ++k) {
        if (trial[k] == 0.0) continue;
        trial[k] += part * change[at];
        at += 3;
        valid = valid && trial[k] >= slowest && trial[k] <= fastest;
        for (int other = 0; other < k; ++other)
          valid = valid && (trial[other] == 0.0 || std::abs(trial[k] - trial[other]) >= apart);
      }
      if (!valid) continue;
      AxisWave tried;
      const double with = solve(samples, origin, trial, &tried);
      if (with < left) {
        left = with;
        *rates = trial;
        wave = tried;
      }
    }
    if (!(left < (1.0 - kEnough) * before)) break;
  }
  return left;
}

}  // namespace

AxisWave WaveFit::fit(std::span<const AxisSample> given, const AxisWave& last,
                      bool search) noexcept {
  constexpr double kWorth = 25.0;      // χ² that a sinusoid must explain for each of its unknowns
  constexpr double kLeastTurns = 1.2;  // within the samples
  if (given.empty()) return {};
  const std::span<const AxisSample> samples =
      given.size() > kMostSamples ? given.last(kMostSamples) : given;
  const double span = samples.back().time - samples.front().time;
  AxisWave wave;
  if (span < kLeastTime) return wave;
  const double origin = samples.back().time;
  const double slowest = 2.0 * std::numbers::pi * std::max(kSlowest, kLeastTurns / span);
  std::array<double, AxisWave::kSinusoids> rates = last.fitted ? last.rate : decltype(last.rate){};
  if (search) {
    double left = solve(samples, origin, {}, nullptr);
    std::array<double, AxisWave::kSinusoids> found{};
    for (int k = 0; k < AxisWave::kSinusoids; ++k) {
      double with = 0.0;
      found[k] = best_rate(samples, origin, found, k, k == 0 ? rates[0] : rates[1], slowest, &with);
      // A known swing may have ended.
      if (rates[k] != 0.0 && found[k] != 0.0) {
        double anew = 0.0;
        std::array<double, AxisWave::kSinusoids> others = found;
        others[k] = 0.0;
        const double rate = best_rate(samples, origin, others, k, 0.0, slowest, &anew);
        if (anew < 0.8 * with) {
          with = anew;
          found[k] = rate;
        }
      }
      if (found[k] == 0.0 || left - with < 3.0 * kWorth) {
        found[k] = 0.0;
        break;
      }
      left = refine(samples, origin, slowest, &found, with);
    }
    rates = found;
  }
  solve(samples, origin, rates, &wave);
  wave.fitted = rates[0] != 0.0;
  return wave;
}

}  // namespace impedraw
