// Defects found in well-known controllers of this kind: one test each, which fails if the defect is
// present. Where it is cheap, the test also builds the defect and checks that it would be found.
// Accelerations come from MuJoCo: M⁻¹ and J of the true arm.
#include <cmath>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "dense_algebra.h"
#include "free_arm.h"
#include "impedraw/common/errors.h"
#include "impedraw/control/describe_control.h"
#include "seeds.h"

namespace impedraw {
namespace {

using namespace testing_arm;

// The arm at rest in a random or given posture, with the reference at the tip.
struct Still {
  FreeArm free;

  Still(const ImpedanceSettings& s, const JointVector& q) : free(s, q) {}

  JointVector random_rest(std::mt19937& rng) {
    const JointVector q = random_terms(free.arm, rng).q;
    rest_at(q);
    return q;
  }
  void rest_at(const JointVector& q) {
    free.world.set_state(q, JointVector::Zero(7));
    free.measure();
    free.reference.p_WD = free.terms.X_WE.p;
    free.reference.n_WD = -free.terms.X_WE.R.col(2);
    free.controller.reset();
  }
  // Of the tip, at rest.
  Vector6 acceleration(const JointVector& tau) const {
    const World::Terms t = free.world.terms();
    return t.J * solve(t.M, Eigen::VectorXd(tau) - t.bias);
  }
};

TEST(Defects,
     OneTriangleOfTheInverseInertia) {  // Pinocchio's computeMinverse fills the upper one only
  ArmModel arm(kArm);
  const unsigned seed = 41;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  ImpedanceSettings s = shaped_settings(arm);
  Still still(s, working_posture());
  for (int i = 0; i < 20; ++i) {
    still.random_rest(rng);
    still.free.reference.a_WD = Eigen::Vector3d(1.0, -2.0, 1.5);
    still.free.reference.alpha_WD = Eigen::Vector3d(3.0, 2.0, -1.0);
    Vector6 asked;
    asked << still.free.reference.a_WD, still.free.reference.alpha_WD;
    EXPECT_LT((still.acceleration(still.free.control().tau) - asked).norm(), 1e-6 * asked.norm());
    const Eigen::MatrixXd J = still.free.terms.J, whole = inverse(still.free.terms.M);
    const Eigen::MatrixXd half = whole.triangularView<Eigen::Upper>();
    const Eigen::VectorXd tau =
        J.transpose() * inverse(J * half * J.transpose()) * asked + still.free.terms.g;
    EXPECT_GT((still.acceleration(tau) - asked).norm(), 0.01 * asked.norm())
        << "the defect would show";
  }
}

TEST(Defects, AJacobianInOneFrameAndAnErrorInAnother) {
  ArmModel arm(kArm);
  const unsigned seed = 42;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  ImpedanceSettings s = shaped_settings(arm);
  s.stiffness = {{500.0, 500.0},
                 {30.0, 0.0}};  // equal along all axes: the tip moves straight to its goal
  s.shaped_inertia = {{3.0, 3.0}, {0.05, 0.05}};
  s.stability_check.contact_stiffness_max = 1e4;
  Still still(s, working_posture());
  for (int i = 0; i < 20; ++i) {
    JointVector q = still.random_rest(rng);
    for (const double turn : {0.0, 2.0, -2.5}) {  // of the whole arm on its base
      q[0] = turn;
      for (int axis = 0; axis < 3; ++axis) {
        still.rest_at(q);
        const Eigen::Vector3d shift = 1e-3 * Eigen::Vector3d::Unit(axis);
        still.free.reference.p_WD += shift;
        Vector6 expected = Vector6::Zero();
        expected.head<3>() = 500.0 / 3.0 * shift;
        EXPECT_LT((still.acceleration(still.free.control().tau) - expected).norm(),
                  1e-6 * expected.norm())
            << "along W's axis " << axis;
        const Eigen::Matrix3d R_EW = still.free.terms.X_WE.R.transpose();
        Eigen::MatrixXd J_local = still.free.terms.J;
        J_local.topRows(3) = R_EW * J_local.topRows(3);
        J_local.bottomRows(3) = R_EW * J_local.bottomRows(3);
        const Eigen::MatrixXd M = still.free.terms.M;
        const Eigen::VectorXd force = operational_inertia(J_local, M) * expected;
        const Eigen::VectorXd tau = J_local.transpose() * force + still.free.terms.g;
        EXPECT_GT((still.acceleration(tau) - expected).norm(), 0.02 * expected.norm())
            << "the defect would show";
      }
      still.rest_at(q);
      const Eigen::Vector3d about = still.free.reference.n_WD.unitOrthogonal();
      still.free.reference.n_WD = Eigen::AngleAxisd(1e-3, about) * still.free.reference.n_WD;
      Vector6 expected = Vector6::Zero();
      expected.tail<3>() = 30.0 / 0.05 * 1e-3 * about;
      EXPECT_LT((still.acceleration(still.free.control().tau) - expected).norm(),
                1e-5 * expected.norm())
          << "a turn in W turns it in W";
    }
  }
}

TEST(Defects, NullSpaceTorqueClippedAfterItsProjection) {
  ArmModel arm(kArm);
  ImpedanceSettings s = shaped_settings(arm);
  s.null_space.stiffness = Eigen::VectorXd::Constant(7, 60.0);
  s.null_space.q_0[2] += 1.0;
  Still free_of_limits(s, working_posture());
  free_of_limits.free.reference.a_WD = Eigen::Vector3d(1.0, 0.0, 1.0);
  Vector6 asked = Vector6::Zero();
  asked.head<3>() = free_of_limits.free.reference.a_WD;
  const ImpedanceTorque desired = free_of_limits.free.control();
  int limited = 0;
  for (int j = 0; j < 7; ++j) {
    // The joint can have its whole task torque, but only a part of its null-space torque.
    const double with = desired.tau[j], without = with - desired.terms(j, kNullSpace);
    if (std::abs(with) < std::abs(without) + 0.5 || with * without < 0.0) continue;
    ++limited;
    ImpedanceSettings tight = s;
    tight.limits.torque[j] = 0.5 * std::abs(with + without);
    Still still(tight, working_posture());
    still.free.reference.a_WD = asked.head<3>();
    const ImpedanceTorque& out = still.free.control();
    EXPECT_TRUE(out.status.torque_limited);
    EXPECT_EQ(out.task_share, 1.0);
    EXPECT_LT((still.acceleration(out.tau) - asked).norm(), 1e-6 * asked.norm())
        << "joint " << j + 1;
    JointVector clipped = desired.tau;
    clipped[j] = std::copysign(tight.limits.torque[j], clipped[j]);
    EXPECT_GT((still.acceleration(clipped) - asked).norm(), 0.01 * asked.norm())
        << "the defect would show";
  }
  EXPECT_GE(limited, 2);
}

TEST(Defects, ADampedInverseThatLeaksTheNullSpaceIntoTheTask) {
  ArmModel arm(kArm);
  ImpedanceSettings s = shaped_settings(arm);
  s.null_space.stiffness = Eigen::VectorXd::Constant(7, 60.0);
  JointVector q(7);
  for (const double bend :
       {-0.5, -0.35, -0.25}) {  // towards the stretched elbow, short of the release
    q << 0.3, 0.5, 0.4, bend, 0.2, 0.7, 0.1;
    s.null_space.q_0 = q;
    s.null_space.q_0[2] += 0.8;
    s.null_space.q_0[5] -= 0.5;
    Still still(s, q);
    const ImpedanceTorque& out = still.free.control();
    ASSERT_FALSE(out.status.near_singular) << bend;
    const World::Terms t = still.free.world.terms();
    const Eigen::VectorXd null = out.terms.col(kNullSpace);
    ASSERT_GT(null.norm(), 1.0);
    const Eigen::MatrixXd M_inverse = inverse(t.M), A = t.J * M_inverse * t.J.transpose();
    EXPECT_LT((t.J * M_inverse * null).norm(), 1e-9 * (M_inverse * null).norm()) << "bend " << bend;
    // λ²/(σ² + λ²) of the torque comes through a damped inverse.
    const Eigen::VectorXd asked =
        s.null_space.stiffness.cwiseProduct(s.null_space.q_0 - Eigen::VectorXd(q));
    const double lambda = 0.05;
    const Eigen::MatrixXd damped = inverse(A + lambda * lambda * Eigen::MatrixXd::Identity(6, 6));
    const Eigen::VectorXd leaking = asked - t.J.transpose() * damped * t.J * M_inverse * asked;
    EXPECT_GT((t.J * M_inverse * leaking).norm(), 0.1) << "the defect would show";
  }
}

TEST(Defects, GainsTurnedAndNeverUsed) {
  ArmModel arm(kArm);
  const unsigned seed = 43;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  ImpedanceSettings s = natural_settings(arm);
  s.limits.turn_speed = 50.0;  // the limit on turning, not to scale K e
  s.stiffness.angular.tangent *= 0.01;
  ASSERT_NE(s.stiffness.linear.tangent, s.stiffness.linear.normal);
  Still still(s, working_posture());
  for (int i = 0; i < 20; ++i) {
    still.random_rest(rng);
    const double k_t = s.stiffness.linear.tangent;
    const Eigen::Vector3d e(1e-3, -0.6e-3, 0.4e-3);
    still.free.reference.p_WD += e;
    OperationalSpace space;
    space.update(still.free.terms);
    for (const Eigen::Vector3d& n :
         {still.free.reference.n_WD, Eigen::Vector3d(Eigen::Vector3d::UnitX()),
          Eigen::Vector3d(0.6, 0.0, 0.8)}) {
      still.free.reference.n_WD = n;
      still.free.controller.reset();
      const Eigen::Vector3d force =
          space.project_to_tip(still.free.control().terms.col(kImpedance)).head<3>();
      const Eigen::Vector3d along = n.dot(e) * n, expected = k_t * (e - along) + 1500.0 * along;
      EXPECT_LT((force - expected).norm(), 1e-8) << "n = " << n.transpose();
      const Eigen::Vector3d unturned(k_t * e.x(), k_t * e.y(), 1500.0 * e.z());
      if (i > 0) {
        EXPECT_GT((unturned - expected).norm(), 0.05) << "the defect would show";
      }
    }
  }
}

TEST(Defects, LimitRepulsionThatWeakensTowardsTheLimit) {
  ArmModel arm(kArm);
  ImpedanceSettings s = shaped_settings(arm);
  s.null_space.stiffness = Eigen::VectorXd::Zero(7);
  s.joint_range.lower = Eigen::VectorXd::Constant(7, -3.0);
  s.joint_range.upper = Eigen::VectorXd::Constant(7, 3.0);
  double last = -1.0;
  for (double distance = 0.16; distance > -0.1; distance -= 0.01) {
    s.joint_range.upper[2] = working_posture()[2] + distance;
    Still still(s, working_posture());
    // The projected torque may have the opposite sign on the joint itself: the acceleration of the
    // joint counts.
    const Eigen::VectorXd tau = still.free.control().terms.col(kNullSpace);
    const double push = -solve(still.free.world.terms().M, tau)[2];
    if (distance < s.joint_range.margin) {
      EXPECT_GT(push, last) << "at " << distance << " rad";
    }
    last = push;
  }
  EXPECT_GT(last, 1.0) << "[rad/s²]";
}

TEST(Defects, ATorqueCheckThatNothingCalls) {
  ArmModel arm(kArm);
  for (const bool natural : {false, true}) {
    ImpedanceSettings s = natural ? natural_settings(arm) : shaped_settings(arm);
    s.limits.torque_rate = Eigen::VectorXd::Constant(7, 2000.0);
    Still still(s, working_posture());
    JointVector last = still.free.control().tau;
    for (int i = 0; i < 400; ++i) {
      still.free.reference.a_WD = 1e4 * Eigen::Vector3d(i % 100 < 50 ? 1.0 : -1.0, 0.5, -1.0);
      const ImpedanceTorque& out = still.free.control();
      ASSERT_LE((out.tau.cwiseAbs() - s.limits.torque).maxCoeff(), 0.0);
      ASSERT_LE((out.tau - last).cwiseAbs().maxCoeff(), 2.0 + 1e-9);
      ASSERT_TRUE(out.status.torque_limited);
      ASSERT_GT((out.terms.rowwise().sum().cwiseAbs() - s.limits.torque).maxCoeff(), 0.0)
          << "or it was not asked for too much";
      last = out.tau;
    }
  }
}

// The poles of M_d s² + B s + K', with M_d from MuJoCo and B from the controller's response.
TEST(Defects, DampingThatForgetsTheEffectiveMass) {
  ArmModel arm(kArm);
  const unsigned seed = 44;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  for (const double scale : {0.0, 1.0, 2.5}) {  // 0: shaped
    ImpedanceSettings s = shaped_settings(arm);
    s.inertia = scale > 0.0 ? InertiaShaping::scaled : InertiaShaping::shaped;
    if (scale > 0.0) s.inertia_scale = scale;
    Still still(s, working_posture());
    for (int i = 0; i < 10; ++i) {
      const JointVector q = still.random_rest(rng);
      const World::Terms t = still.free.world.terms();
      const Matrix6 Lambda = operational_inertia(t.J, t.M);
      const Eigen::Vector3d n = still.free.reference.n_WD;
      Matrix6 M_d = scale * Lambda, K = Matrix6::Zero(), B;
      if (scale == 0.0) {
        M_d.topLeftCorner<3, 3>() = s.shaped_inertia.linear.matrix(n);
        M_d.bottomRightCorner<3, 3>() = s.shaped_inertia.angular.matrix(n);
      }
      K.topLeftCorner<3, 3>() = s.stiffness.linear.matrix(n);
      K.bottomRightCorner<3, 3>() =
          AxialGain{s.stiffness.angular.tangent, s.reference_stiffness.angular.normal}.matrix(n);
      const Eigen::MatrixXd J_inverse = t.J.transpose() * inverse(t.J * t.J.transpose());
      for (int axis = 0; axis < 6; ++axis) {
        const JointVector v = J_inverse * Vector6(1e-2 * Vector6::Unit(axis));
        still.free.arm.compute(q, v, &still.free.terms);
        still.free.controller.reset();
        const Eigen::VectorXd tau = still.free.control().terms.col(kImpedance);
        const Vector6 F = Lambda * t.J * solve(t.M, tau);  // F = −Λ M_d⁻¹ B V
        B.col(axis) = -M_d * inverse(Lambda) * F / 1e-2;
      }
      EXPECT_LT((B - B.transpose()).norm(), 1e-3 * B.norm());
      Eigen::Matrix<double, 12, 12> A = Eigen::Matrix<double, 12, 12>::Zero();
      A.topRightCorner<6, 6>().setIdentity();
      A.bottomLeftCorner<6, 6>() = -inverse(M_d) * K;
      A.bottomRightCorner<6, 6>() = -inverse(M_d) * B;
      const Eigen::VectorXcd poles = eigenvalues(A);
      for (int k = 0; k < 12; ++k)
        EXPECT_NEAR(-poles[k].real() / std::abs(poles[k]), s.damping_ratio, 2e-3)
            << "mode of " << std::abs(poles[k]) << " rad/s";
    }
  }
}

TEST(Defects,
     // against MuJoCo's own; ClosedLoop.GravityIsCountedOnce has the controller's terms
     GravityTwiceOrNotAtAll) {
  ArmModel arm(kArm);
  const unsigned seed = 45;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  ImpedanceSettings s = shaped_settings(arm);
  s.null_space.stiffness = Eigen::VectorXd::Zero(7);
  for (const bool natural : {false, true}) {
    if (natural) s.inertia = InertiaShaping::natural;
    Still still(s, working_posture());
    for (int i = 0; i < 20; ++i) {
      still.random_rest(rng);
      const Eigen::VectorXd gravity = still.free.world.terms().bias;
      ASSERT_GT(gravity.norm(), 5.0);
      EXPECT_LT((Eigen::VectorXd(still.free.control().tau) - gravity).norm(),
                1e-8 * gravity.norm());
    }
  }
}

struct Knob {
  std::string name;
  Range range;
  std::function<void(double)> set;
  double at(double share) const {
    const double low = range.above ? 1e-6 : range.lowest,
                 high = range.below ? range.highest - 1e-6 : range.highest;
    return low + share * (high - low);
  }
};

// The numbers of settings, from their description.
struct Knobs {
  std::vector<Knob> all;

  Knobs& field(std::string_view name, double& value, const Range& range, std::string_view,
               std::string_view = {}) {
    all.push_back({std::string(name), range, [&value](double x) { value = x; }});
    return *this;
  }
  Knobs& constant(std::string_view name, double& value, const Range& range, std::string_view) {
    return field(name, value, range, "");
  }
  template <class T>
  Knobs& field(std::string_view, T&, std::string_view) {
    return *this;
  }
  template <class T>
  Knobs& choice(std::string_view, T&, std::initializer_list<const char*>, std::string_view) {
    return *this;
  }
  Knobs& for_users() { return *this; }
  Knobs& formerly(std::string_view) { return *this; }
};

std::vector<Knob> knobs_of(ImpedanceSettings& s) {
  Knobs knobs;
  describe(knobs, s);
  knobs.field("mass_normal", s.shaped_inertia.linear.normal, kMassRange, "")
      .field("min_axis_cosine", s.surface.min_axis_cosine, Range::positive_to(1.0), "")
      .field("normal_error", s.friction.normal_error_deg, kNormalErrorRange, "");
  knobs.all.push_back({"null_stiffness", kNullStiffnessRange,
                       [&s](double x) { s.null_space.stiffness = JointVector::Constant(7, x); }});
  knobs.all.push_back({"torque_rate", kTorqueRateRange,
                       [&s](double x) { s.limits.torque_rate = JointVector::Constant(7, x); }});
  return knobs.all;
}

// Each setting's ends, and random pairs of all: refused by name, or a finite torque that follows
// the law and is not the safe one. The pose is far off, so that the speed's limits act, too.
TEST(Defects, AnAllowedSettingThatGivesNoNumber) {
  ArmModel arm(kArm);
  const auto require_finite = [&](const ImpedanceSettings& s, const std::string& what) {
    SCOPED_TRACE(what);
    std::optional<FreeArm> free;
    try {
      free.emplace(s);
    } catch (const InputError& refused) {
      EXPECT_STRNE(refused.what(), "");
      return;
    }
    free->reference.p_WD += Eigen::Vector3d(0.3, -0.2, 0.1);
    free->reference.v_WD = Eigen::Vector3d(0.1, 0.2, 0.3);
    free->surface.status = SurfaceStatus::ok;
    free->surface.n_W = free->reference.n_WD;
    free->surface.distance = 2e-3;
    for (int i = 0; i < 20; ++i) {
      free->reference.pen_down = i >= 5;
      free->F_ext.head<3>() = (i >= 8 ? 4.0 : 0.0) * free->reference.n_WD;
      const ImpedanceTorque& out = free->control();
      ASSERT_TRUE(out.tau.allFinite());
      ASSERT_FALSE(out.status.bad_input);
    }
  };
  const auto settings_of = [&](int kind) {
    ImpedanceSettings s = kind == 2 ? natural_settings(arm) : shaped_settings(arm);
    if (kind == 1) s.inertia = InertiaShaping::scaled;
    s.joint_range = {arm.limits().lower, arm.limits().upper};
    s.limits.joint_speed = arm.limits().speed;
    return s;
  };
  ImpedanceSettings any;
  const std::size_t count = knobs_of(any).size();
  ASSERT_GT(count, 30u);
  for (int kind = 0; kind < 3; ++kind)
    for (std::size_t at = 0; at < count; ++at)
      for (const double end : {0.0, 1.0}) {
        ImpedanceSettings s = settings_of(kind);
        const Knob knob = knobs_of(s)[at];
        knob.set(knob.at(end));
        require_finite(s, fmt::format("{} {} {}", kind, knob.name, end));
      }
  std::mt19937 rng(43);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (unsigned i = 0; i < seeds(500, 20000); ++i) {
    ImpedanceSettings s = settings_of(static_cast<int>(i % 3));
    std::string what = std::to_string(i % 3);
    for (int k = 0; k < 2; ++k) {
      const Knob knob = knobs_of(s)[rng() % count];
      const double x = unit(rng), share = x < 0.3 ? 0.0 : x > 0.7 ? 1.0 : unit(rng);
      knob.set(knob.at(share));
      what += fmt::format(" {} {}", knob.name, knob.at(share));
    }
    require_finite(s, what);
  }
}

// The arm is 10 % heavier than its model. With the observer, the normal force is still
// correct.
TEST(Defects, AForceThatIsOffByAWrongPayload) {
  ArmModel arm(kArm);
  ModelErrors heavy;
  heavy.mass_scale = 1.1;
  for (const bool observed : {false, true}) {
    ImpedanceSettings s = shaped_settings(arm);
    s.observer.enabled = observed;
    PlaneArm on(s, 0.2, heavy);
    on.draw(3000);
    double mean = 0.0;
    for (int i = 0; i < 500; ++i) {
      ASSERT_EQ(on.step().mode, ContactMode::contact);
      mean += on.n_W.dot(on.free.F_ext.head<3>()) / 500.0;
    }
    if (observed)
      EXPECT_NEAR(mean, s.normal_force, 0.01 * s.normal_force);
    else
      EXPECT_GT(std::abs(mean - s.normal_force), 0.1 * s.normal_force)
          << "or there was nothing to observe";
  }
}

}  // namespace
}  // namespace impedraw
