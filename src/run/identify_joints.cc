#include "impedraw/run/identify_joints.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include <fmt/format.h>
#include <Eigen/Cholesky>
#include <Eigen/QR>

#include "impedraw/common/minimum_jerk.h"
#include "impedraw/perception/rigid_fit.h"

namespace impedraw {
namespace {

// Holds an arm by joint stiffness plus modelled gravity about the posture in which it stands, or a
// posture near it.
class PostureHolder {
 public:
  // delay: the longest that the loop may have [s]. A light joint gets less stiffness: through the
  // delay it would oscillate.
  PostureHolder(const ArmModel& arm, Driver& driver, double delay)
      : arm_(arm), driver_(driver), terms_(arm.joints()), state_(&driver.read()), q0_(state_->q) {
    arm_.compute(q0_, state_->v, &terms_);
    const JointMatrix inverse =
        terms_.M.ldlt().solve(JointMatrix::Identity(terms_.M.rows(), terms_.M.cols()));
    const JointVector inertia = inverse.diagonal().cwiseInverse();
    const double bandwidth = kPhase / delay;
    stiffness_ = (bandwidth * bandwidth * inertia).cwiseMin(kMostStiffness);
    damping_ = 1.4 * stiffness_.cwiseProduct(inertia).cwiseSqrt();
  }

  // One cycle towards (q_d, v_d), with a torque added. Returns what was commanded beyond gravity.
  JointVector step(const JointVector& q_d, const JointVector& v_d, const JointVector& added) {
    arm_.compute(state_->q, state_->v, &terms_);
    JointVector tau =
        stiffness_.cwiseProduct(q_d - state_->q) + damping_.cwiseProduct(v_d - state_->v) + added;
    tau = tau.cwiseMin(arm_.limits().torque).cwiseMax(-arm_.limits().torque);
    driver_.command(terms_.g + tau, terms_.g);
    state_ = &driver_.read();
    if (!driver_.fault().empty()) throw std::runtime_error(driver_.fault());
    return tau;
  }
  const JointVector& start() const { return q0_; }
  const ArmState& state() const { return *state_; }
  const ArmTerms& terms() const { return terms_; }

 private:
  static constexpr double kMostStiffness = 300.0;  // of each joint [Nm/rad]
  static constexpr double kPhase = 0.35;  // bandwidth of a joint's stiffness times the loop's delay

  ArmModel arm_;
  Driver& driver_;
  ArmTerms terms_;
  const ArmState* state_;
  JointVector q0_, stiffness_, damping_;
};

constexpr double kSweep = 0.2;                          // to each side of the start [rad]
constexpr std::array<double, 2> kSpeeds = {0.15, 0.4};  // [rad/s]
constexpr int kRounds = 2;
constexpr double kMoves = 0.03;       // a joint that is faster moves [rad/s]
constexpr double kLeastMoved = 3.0;   // in all sweeps [s]
constexpr double kMargin = 0.05;      // that a sweep keeps from a joint's limits [rad]
constexpr double kLeastShake = 0.02;  // [Nm]
constexpr double kMostShake = 0.1;    // of the last joint's torque limit
constexpr double kShakeSpeed = 0.1;   // of its speed limit, at which it moves enough
constexpr double kLeastExplained = 0.5;
constexpr double kMostFriction = 1.0 / 3.0;                      // of the joint's torque limit
constexpr std::array<double, 2> kShakeFrequencies = {2.0, 3.5};  // [Hz]
constexpr int kShakes = 6;                                       // periods of each
constexpr double kShake = 0.05;                                  // [rad]
constexpr double kSpan = 0.012;  // over which positions are differenced, to each side [s]

struct JointFit {
  Eigen::Matrix<double, 5, 1> x = Eigen::Matrix<double, 5, 1>::Zero();  // of sign(v), v, a, q, 1
  double residual = 0.0;                                                // RMS [Nm]
  double inertia_error = 0.0;  // standard deviation of x[2] [kg m²]
  double moved = 0.0;          // time for which the joint moved [s]
};

// Commands and motion of joint j. Velocities and accelerations are differences of
// the positions before and after: those that an arm gives are filtered, and a filter's lag turns
// friction into inertia.
class Motion {
 public:
  explicit Motion(int j) : j_(j) {}
  void clear() { samples_.clear(); }
  void add(PostureHolder* holder, const JointVector& q_d, const JointVector& v_d,
           const JointVector& added) {
    Sample s;
    s.q = holder->state().q;
    s.tau = holder->step(q_d, v_d, added)[j_];
    s.M = holder->terms().M.row(j_).transpose();
    s.Cv = holder->terms().Cv[j_];
    samples_.push_back(s);
  }

  JointFit fit(double dt, double delay) const {
    const auto w = static_cast<std::size_t>(std::max(1L, std::lround(kSpan / dt))),
               late = static_cast<std::size_t>(std::lround(delay / dt));
    const double span = static_cast<double>(w) * dt;
    std::vector<Eigen::Matrix<double, 6, 1>> rows;  // sign(v), v, a, q, 1; τ
    for (std::size_t k = std::max(w, late); k + w < samples_.size(); ++k) {
      const JointVector &before = samples_[k - w].q, &now = samples_[k].q,
                        &after = samples_[k + w].q;
      const JointVector a = (after - 2.0 * now + before) / (span * span);
      const double v = (after[j_] - before[j_]) / (2.0 * span);
      if (std::abs(v) <= kMoves) continue;
      // The others are held by springs: what their motion takes is in the model. The torque is the
      // mean over the span, as the difference of positions weighs it.
      double tau = 0.0;
      for (std::size_t i = 0; i < 2 * w - 1; ++i) {
        const auto at = static_cast<long>(k + i + 1) - static_cast<long>(w + late);
        const double weight = static_cast<double>(std::min(i + 1, 2 * w - 1 - i));
        tau += weight * samples_[static_cast<std::size_t>(std::max(0L, at))].tau;
      }
      tau /= static_cast<double>(w * w);
      const Sample& s = samples_[k];
      rows.push_back({v > 0.0 ? 1.0 : -1.0, v, a[j_], now[j_] - samples_.front().q[j_], 1.0,
                      tau - s.M.dot(a) - s.Cv});
    }
    JointFit out = solve(rows);
    out.moved = static_cast<double>(rows.size()) * dt;
    // Its parts tell how far it can be trusted: what is left over is no white noise.
    constexpr std::size_t kParts = 4;
    double sum = 0.0;
    for (std::size_t i = 0; i < kParts; ++i) {
      std::vector<Eigen::Matrix<double, 6, 1>> others = rows;
      const auto at = [&](std::size_t part) {
        return others.begin() + static_cast<std::ptrdiff_t>(part * rows.size() / kParts);
      };
      others.erase(at(i), at(i + 1));
      sum += std::pow(solve(others).x[2] - out.x[2], 2);
    }
    out.inertia_error = std::sqrt(sum * (kParts - 1) / kParts);  // the jackknife's
    return out;
  }

 private:
  struct Sample {
    JointVector q, M;
    double tau, Cv;
  };
  static JointFit solve(const std::vector<Eigen::Matrix<double, 6, 1>>& rows) {
    JointFit out;
    if (rows.size() < 5) return out;
    Eigen::MatrixXd A(static_cast<Eigen::Index>(rows.size()), 5);
    Eigen::VectorXd y(A.rows());
    for (Eigen::Index i = 0; i < A.rows(); ++i) {
      A.row(i) = rows[static_cast<std::size_t>(i)].head<5>().transpose();
      y[i] = rows[static_cast<std::size_t>(i)][5];
    }
    out.x = A.colPivHouseholderQr().solve(y);
    out.residual = (y - A * out.x).norm() / std::sqrt(static_cast<double>(A.rows()));
    return out;
  }

  int j_;
  std::vector<Sample> samples_;
};

constexpr double kMoveTime = 1.5;  // from pose to pose [s]
constexpr double kDelay = 5e-3;    // the longest that the loop may have [s]
constexpr double kTurn = 1.0;      // of each wrist joint from the start posture, at most [rad]
constexpr double kAtRest = 0.05;   // joint speed [rad/s]

// Orientations spread over the ball of wrist turns: a low-discrepancy sequence (Roberts' R3), so
// that any number of poses is well placed.
Eigen::Vector3d wrist_turn(int i) {
  const Eigen::Vector3d step(0.8191725134, 0.6710436067, 0.5497004779);
  Eigen::Vector3d x = 0.5 * Eigen::Vector3d::Ones() + i * step;
  for (double& c : x) c = 2.0 * (c - std::floor(c)) - 1.0;
  return kTurn * x;
}

// From rest to rest, then still for `rest` seconds; the mean reading over the last half of them.
Vector6 move(PostureHolder& holder, double dt, const JointVector& from, const JointVector& to,
             double rest) {
  Vector6 sum = Vector6::Zero();
  int count = 0;
  const long moving = std::lround(kMoveTime / dt), steps = moving + std::lround(rest / dt),
             averaging = steps - std::lround(0.5 * rest / dt);
  for (long k = 0; k < steps; ++k) {
    const MinimumJerk jerk =
        MinimumJerk::at(std::min(1.0, static_cast<double>(k) / moving), kMoveTime);
    const JointVector way = to - from;
    if (k >= averaging) {
      sum += holder.state().wrench;
      ++count;
    }
    holder.step(from + jerk.share * way, jerk.rate * way, JointVector::Zero(way.size()));
  }
  return sum / count;
}

JointVector within_range(const JointVector& q, const ArmLimits& limits) {
  const JointVector margin = JointVector::Constant(q.size(), 0.1);
  return q.cwiseMax(JointVector(limits.lower) + margin)
      .cwiseMin(JointVector(limits.upper) - margin);
}

}  // namespace

LoopDelay identify_delay(const ArmModel& arm, Driver& driver, double seconds) {
  const StartedDriver started(driver);
  PostureHolder holder(arm, driver, kMostSteps * driver.info().period);
  const double dt = driver.info().period;
  const auto last = static_cast<Eigen::Index>(arm.joints() - 1);
  const JointVector zero = JointVector::Zero(arm.joints());
  const long steps = std::lround(seconds / dt), settle = std::lround(0.5 / dt);
  std::mt19937 random(1);
  std::bernoulli_distribution coin(0.5);
  std::vector<double> tau, v;
  // Pairs of 5 ms up and 5 ms down, or the other way round by a coin: what the first half adds to
  // the speed, the second takes away. Returns the largest speed [rad/s].
  const auto shake = [&](double amplitude, long count) {
    JointVector added = zero;
    double fastest = 0.0, sign = 1.0;
    tau.clear();
    v.clear();
    for (long k = 0; k < count; ++k) {
      if (k % 10 == 0)
        sign = coin(random) ? 1.0 : -1.0;
      else if (k % 5 == 0)
        sign = -sign;
      added[last] = sign * amplitude;
      v.push_back(holder.state().v[last]);
      fastest = std::max(fastest, std::abs(v.back()));
      tau.push_back(holder.step(holder.start(), zero, added)[last]);
    }
    return fastest;
  };
  for (long k = 0; k < settle; ++k) holder.step(holder.start(), zero, zero);
  // Friction and rotor are not known yet: from a small torque on, until the joint moves.
  const double most = kMostShake * arm.limits().torque[last];
  double amplitude = kLeastShake;
  while (shake(amplitude, std::lround(0.2 / dt)) < kShakeSpeed * arm.limits().speed[last] &&
         amplitude < most)
    amplitude = std::min(most, 1.5 * amplitude);
  shake(amplitude, steps);
  for (long k = 0; k < settle; ++k) holder.step(holder.start(), zero, zero);
  // v_{k+1} − v_k = a τ_{k−d} + b v_k + c sign(v_k) + e, by least squares for each d.
  LoopDelay best;
  int best_d = 0;
  best.explained = -1.0;
  const auto rows = static_cast<Eigen::Index>(v.size()) - kMostSteps - 2;
  Eigen::VectorXd y(rows);
  for (int d = 0; d <= kMostSteps; ++d) {
    Eigen::MatrixXd A(rows, 4);
    for (Eigen::Index i = 0; i < rows; ++i) {
      const auto k = static_cast<std::size_t>(i + kMostSteps);
      y[i] = v[k + 1] - v[k];
      A.row(i) << tau[k - static_cast<std::size_t>(d)], v[k], v[k] > 0.0 ? 1.0 : -1.0, 1.0;
    }
    const Eigen::VectorXd x = A.colPivHouseholderQr().solve(y);
    const double share =
        1.0 - (y - A * x).squaredNorm() / (y.array() - y.mean()).matrix().squaredNorm();
    if (share > best.explained && x[0] > 0.0) {
      best.explained = share;
      best_d = d;
    }
  }
  best.delay = best_d * dt;
  if (!(best.explained >= kLeastExplained))
    throw std::runtime_error(
        fmt::format("the last joint does not answer its torque: {:.0f} % of its acceleration is "
                    "explained, {:.0f} "
                    "% are needed; is it blocked, or is its velocity noisy?",
                    1e2 * std::max(0.0, best.explained), 1e2 * kLeastExplained));
  if (best_d == kMostSteps)
    throw std::runtime_error(
        fmt::format("the loop's delay is {} steps or more: too long to draw with", kMostSteps));
  return best;
}

std::vector<JointFriction> identify_friction(const ArmModel& arm, Driver& driver, double delay) {
  const StartedDriver started(driver);
  PostureHolder holder(arm, driver, delay + 2.0 * driver.info().period);
  const double dt = driver.info().period;
  const int n = arm.joints();
  const JointVector zero = JointVector::Zero(n), q0 = holder.start();
  std::vector<JointFriction> found(static_cast<std::size_t>(n));
  for (int j = 0; j < n; ++j) {
    const double low = std::max(q0[j] - kSweep, arm.limits().lower[j] + kMargin),
                 high = std::min(q0[j] + kSweep, arm.limits().upper[j] - kMargin);
    const std::string& name = arm.joint_names()[static_cast<std::size_t>(j)];
    if (high - low < kSweep)
      throw std::runtime_error(fmt::format(
          "{} stands {:.2f} rad from a limit: a sweep needs {:.2f} rad", name,
          std::min(q0[j] - arm.limits().lower[j], arm.limits().upper[j] - q0[j]), kSweep));
    JointVector q_d = q0, v_d = zero, added = zero;
    Motion motion(j);
    const auto step = [&] { motion.add(&holder, q_d, v_d, added); };
    const auto sweep = [&](double to, double speed) {
      const double from = q_d[j], direction = to > from ? 1.0 : -1.0;
      const long steps = std::lround(std::abs(to - from) / (speed * dt));
      for (long k = 1; k <= steps; ++k) {
        q_d[j] = from + (to - from) * static_cast<double>(k) / static_cast<double>(steps);
        v_d[j] = direction * speed;
        step();
      }
      v_d[j] = 0.0;
    };
    // Accelerations tell the inertia; what friction takes is added, or a light joint would stick.
    const auto shake = [&](double frequency, const JointFit& slow) {
      const double w = 2.0 * std::numbers::pi * frequency, from = q_d[j];
      const long period = std::lround(1.0 / (frequency * dt));
      for (long k = 1; k <= kShakes * period; ++k) {
        const double t = static_cast<double>(k) * dt, A = kShake * std::min(1.0, frequency * t);
        q_d[j] = from + A * std::sin(w * t);
        v_d[j] = A * w * std::cos(w * t);
        added[j] = std::max(0.0, slow.x[0]) * (v_d[j] > 0.0 ? 1.0 : -1.0);
        step();
      }
      q_d[j] = from;
      v_d[j] = added[j] = 0.0;
    };
    sweep(low, kSpeeds[0]);
    motion.clear();
    for (const double speed : kSpeeds) {
      for (int i = 0; i < kRounds; ++i) {
        sweep(high, speed);
        sweep(low, speed);
      }
    }
    sweep(q0[j], kSpeeds[0]);
    const JointFit slow = motion.fit(dt, delay);
    for (const double frequency : kShakeFrequencies) shake(frequency, slow);
    const JointFit fit = motion.fit(dt, delay);
    if (slow.moved < kLeastMoved)
      throw std::runtime_error(
          fmt::format("{}: it moved for {:.1f} s only, {:.1f} s are needed: is a brake closed?",
                      name, slow.moved, kLeastMoved));
    JointFriction& f = found[static_cast<std::size_t>(j)];
    f.coulomb = fit.x[0];
    f.viscous = fit.x[1];
    f.residual = fit.residual;
    f.inertia = fit.x[2];
    f.inertia_error = fit.inertia_error;
    const double fast = f.coulomb + kSpeeds[1] * f.viscous;
    const double least = -std::max(0.1, 2.0 * f.residual),
                 most = kMostFriction * arm.limits().torque[j];
    if (!(f.coulomb >= least && f.coulomb <= most && fast >= least && fast <= most))
      throw std::runtime_error(fmt::format(
          "{}: friction of {:.2f} Nm and {:.2f} Nm s/rad is implausible; valid is 0 to {:.1f} Nm: "
          "does something touch the arm, or is its model wrong?",
          name, f.coulomb, f.viscous, most));
  }
  return found;
}

ToolCalibration calibrate_tool(const Experiment& e, Driver& driver, int poses, double rest) {
  if (driver.info().wrench != WrenchReading::sensor)
    throw InputError("control.wrench: there is no sensor to read; valid are sensor, realistic");
  ArmModel arm = e.belief.arm;
  if (arm.joints() < 3)
    throw InputError(fmt::format("arm.urdf: {} joints cannot turn the tool; at least 3 are needed",
                                 arm.joints()));
  const StartedDriver started(driver);
  PostureHolder holder(arm, driver, kDelay);

  ToolCalibration calibration;
  JointVector from = e.belief.start_q;
  for (int i = 0; i < poses; ++i) {
    JointVector to = e.belief.start_q;
    to.tail<3>() += wrist_turn(i);
    to = within_range(to, arm.limits());
    const Vector6 reading = move(holder, driver.info().period, from, to, rest);
    if (holder.state().v.cwiseAbs().maxCoeff() > kAtRest)
      throw std::runtime_error(fmt::format(
          "pose {} of {}: the arm did not come to rest within {:.1f} s", i + 1, poses, rest));
    calibration.poses.push_back({arm.tip_pose(holder.state().q).R, reading});
    from = to;
  }
  calibration.found = identify_tool(calibration.poses, {0.0, 0.0, -e.scenario.world.gravity});
  return calibration;
}

using Eigen::Vector3d;

Vector3d centre_of(const FiducialSettings& fiducials) {
  Vector3d centre = Vector3d::Zero();
  for (const Fiducial& mark : fiducials.points)
    centre += mark.p_K / static_cast<double>(fiducials.points.size());
  return centre;
}

std::vector<StampedPoint> watch_marks(const ArmModel& arm, Driver& driver,
                                      const FiducialSettings& fiducials, double seconds) {
  constexpr double kLeastSpread = 5e-3;  // of marks beside a line [m]
  const Vector3d centre = centre_of(fiducials);
  const StartedDriver started(driver);
  PostureHolder holder(arm, driver, kMostSteps * driver.info().period);
  const JointVector zero = JointVector::Zero(arm.joints());
  std::vector<StampedPoint> seen;
  std::vector<Vector3d> p_K, p_W;
  while (holder.state().time < seconds) {
    for (CanvasFrame frame; driver.next_frame(&frame);) {
      p_K.clear();
      p_W.clear();
      for (const FoundMark& found : frame.found()) {
        if (found.mark < 0 || found.mark >= static_cast<int>(fiducials.points.size())) continue;
        p_K.push_back(fiducials.points[static_cast<std::size_t>(found.mark)].p_K);
        p_W.push_back(found.p_W);
      }
      if (p_K.size() < 3 || spread_beside_line(p_K) < kLeastSpread) continue;
      seen.push_back({frame.time, holder.state().time, fit_rigid(p_K, p_W).X_WK * centre});
    }
    holder.step(holder.start(), zero, zero);
  }
  return seen;
}

}  // namespace impedraw
