#include "impedraw/simulation/joint_springs.h"

#include <cmath>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/per_joint.h"
#include "impedraw/common/range_check.h"
#include "impedraw/simulation/describe_world.h"

namespace impedraw {

namespace {

constexpr double kLossTime = 1e-3;  // D/K: a damping ratio of 3 % at 60 rad/s [s]

struct Published {
  const char* name;
  std::vector<double> stiffness, rotor_inertia;
  double loop_bandwidth;
  bool motor_side;
};

// Papers and catalogues are quoted from memory; docs/arm-springs.md says what was read again.
//
// iiwa. Rotors: motor inertias of the KUKA LWR over its gears, Jubien, Gautier and Janot, Dynamic
//   Identification of the Kuka LWR Robot Using Motor Torques and Joint Torque Sensors Data, IFAC
//   World Congress (2014). Stiffness: the order of 10 kNm/rad of the DLR-KUKA LWR, Albu-Schäffer,
//   Ott and Hirzinger, A Unified Passivity-based Control Framework, IJRR 26 (2007); one figure for
//   all joints is assumed. Loop: assumed. Sensors on both sides (KUKA, LBR iiwa's specification);
//   the link's are read.
// FR3. Rotors: armature of mujoco_menagerie's franka_fr3_v2. Stiffness: K_1 of Harmonic Drive's
//   sizes 20 and 14, which are assumed. Loop: assumed. libfranka's q is the link's position beside
//   theta, the motor's.
// harmonic_drive. A cobot with gears of 100 : 1, sizes 25 and 14, and no torque sensor. Stiffness:
//   K_1, for small torques, in Harmonic Drive's catalogue of CSG gears. Rotors: twice the wave
//   generator's inertia there, 0.413 and 0.033 kg cm², the motor being assumed as large.
Published published(SpringsOf arm, int joints) {
  switch (arm) {
    case SpringsOf::none:
      break;
    case SpringsOf::iiwa:
      return {"iiwa", {1e4}, {3.19, 3.05, 1.98, 2.05, 0.787, 0.391, 0.394}, 200.0, false};
    case SpringsOf::fr3:
      return {"fr3", {1.6e4, 1.6e4, 1.6e4, 1.6e4, 4.7e3, 4.7e3, 4.7e3}, {0.195}, 400.0, false};
    case SpringsOf::harmonic_drive: {
      Published cobot{"harmonic_drive", {}, {}, 0.0, true};
      for (int j = 0; j < joints; ++j) {
        const bool large = 2 * j < joints;
        cobot.stiffness.push_back(large ? 3.1e4 : 4.7e3);
        cobot.rotor_inertia.push_back(large ? 0.83 : 0.066);
      }
      return cobot;
    }
  }
  return {"none", {}, {}, 0.0, false};
}

}  // namespace

Eigen::VectorXd JointSpringValues::apparent_inertia() const {
  if (loop_bandwidth <= 0.0) return rotor_inertia;
  return rotor_inertia.cwiseMin(stiffness / (loop_bandwidth * loop_bandwidth));
}

Eigen::VectorXd JointSpringValues::loop_lag() const {
  const Eigen::VectorXd inertia = apparent_inertia();
  Eigen::VectorXd lag = Eigen::VectorXd::Zero(inertia.size());
  for (Eigen::Index j = 0; j < lag.size(); ++j)
    if (inertia[j] < rotor_inertia[j]) lag[j] = 2.0 * JointSprings::kLoopDamping / loop_bandwidth;
  return lag;
}

JointSpringValues joint_spring_values(const JointSpringSettings& s, int joints) {
  const std::string group = "world.joint_spring";
  require_ranges(group, s);
  const Published of = published(s.arm, joints);
  const auto values = [&](const char* name, const std::vector<double>& given,
                          const std::vector<double>& known) {
    if (given.empty() && static_cast<int>(known.size()) > 1 &&
        static_cast<int>(known.size()) != joints)
      throw InputError(fmt::format(
          "{}.arm is {}, which has {} joints, but the arm has {}; valid are harmonic_drive, or "
          "{}.stiffness and {}.rotor_inertia of each joint",
          group, of.name, known.size(), joints, group, group));
    return per_joint(group + "." + name, given.empty() ? known : given, joints);
  };
  JointSpringValues v;
  v.stiffness = values("stiffness", s.stiffness, of.stiffness);
  v.damping = s.damping.empty() ? Eigen::VectorXd(kLossTime * v.stiffness)
                                : values("damping", s.damping, {});
  v.rotor_inertia = values("rotor_inertia", s.rotor_inertia, of.rotor_inertia);
  if (!(v.rotor_inertia.minCoeff() > 0.0))
    throw InputError(
        fmt::format("{}.rotor_inertia is empty: a rotor before a spring needs an inertia; valid "
                    "are {}.arm, or one entry for all joints or for each",
                    group, group));
  v.loop_bandwidth = s.loop_bandwidth.value_or(of.loop_bandwidth);
  v.motor_side =
      s.reading == SpringSide::as_published ? of.motor_side : s.reading == SpringSide::motor;
  return v;
}

JointSprings::JointSprings(const JointSpringSettings& s, const JointVector& b,
                           const GearFriction& friction, double h)
    : values_(joint_spring_values(s, static_cast<int>(b.size()))),
      friction_(friction),
      ripple_(s.sensor_ripple),
      offset_(s.sensor_offset),
      h_(h),
      b_(b) {
  lag_ = values_.loop_lag();
  inertia_ = values_.apparent_inertia();
  share_ = inertia_.cwiseQuotient(values_.rotor_inertia);
  stiff_ = 0.25 * h * values_.stiffness + 0.5 * values_.damping;
  coupling_ = (h + lag_.array()) * stiff_.array();
  const JointVector own = inertia_ + h * share_.cwiseProduct(b_);
  mass_ = own + coupling_;
  link_damping_ = stiff_.cwiseProduct(own).cwiseQuotient(mass_);
  theta_ = rate_ = torque_ = sensed_ = known_ = base_ = error_ = link_torque_ =
      JointVector::Zero(b.size());
}

void JointSprings::reset(const JointVector& q, const JointVector& v,
                         const JointVector& tau_J) noexcept {
  theta_ = q + tau_J.cwiseQuotient(values_.stiffness);
  rate_ = v;
  torque_ = sensed_ = tau_J;
}

const JointVector& JointSprings::begin(const JointVector& u, const JointVector& q,
                                       const JointVector& v) noexcept {
  const Eigen::Index n = q.size();
  for (Eigen::Index j = 0; j < n; ++j)
    error_[j] = (j % 2 ? -offset_ : offset_) +
                ripple_ * std::sin(ModelErrors::kRipplePeriods * theta_[j] + friction_.phase(j));
  base_ = values_.stiffness.cwiseProduct(theta_ - q) +
          (0.5 * values_.damping - 0.25 * h_ * values_.stiffness).cwiseProduct(rate_ - v);
  // what θ̇⁺ is without v⁺, times mass_
  known_ = inertia_.cwiseProduct(rate_) + h_ * (u + share_.cwiseProduct(error_)) -
           (h_ + lag_.array()).matrix().cwiseProduct(base_ + error_) + lag_.cwiseProduct(sensed_);
  if (friction_.acts()) {
    const JointVector free = (known_ + coupling_.cwiseProduct(v)).cwiseQuotient(share_);
    const JointVector most = h_ * friction_.most(rate_, theta_, torque_);
    known_ -= share_.cwiseProduct(free.cwiseMin(most).cwiseMax(-most));
  }
  link_torque_ = base_ + stiff_.cwiseProduct(known_).cwiseQuotient(mass_);
  return link_torque_;
}

void JointSprings::finish(const JointVector& v) noexcept {
  rate_ = (known_ + coupling_.cwiseProduct(v)).cwiseQuotient(mass_);
  theta_ += h_ * rate_;
  torque_ = base_ + stiff_.cwiseProduct(rate_ - v);
  sensed_ = torque_ + error_;
}

}  // namespace impedraw
