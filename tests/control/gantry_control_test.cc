// The control law on the arm of the second example, whose terms are closed forms. These cases need
// neither Pinocchio nor MuJoCo, so the sanitizers run them, too.
#include <algorithm>
#include <cmath>
#include <iterator>
#include <random>

#include <gtest/gtest.h>
#include <Eigen/Cholesky>

#include "02_own_simulator/gantry.h"
#include "impedraw/control/impedance.h"

namespace impedraw {
namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

// Posture and velocity at random, the wrist well away from its singular posture.
ArmTerms random_gantry(std::mt19937& rng, double speed) {
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  JointVector q(6), v(6);
  for (int j = 0; j < 6; ++j) {
    q[j] = 0.5 * unit(rng);
    v[j] = speed * unit(rng);
  }
  ArmTerms arm(6);
  Gantry().compute(q, v, &arm);
  return arm;
}

Matrix3d diagonal(double tangent, double normal, const Vector3d& n) {
  return tangent * (Matrix3d::Identity() - n * n.transpose()) + normal * n * n.transpose();
}

// M_d (V̇ − V̇_d) = B (V_d − V) + K e + F_ext, with V̇ from the plant (2) and B = 2 ζ √(K' M_d) per
// axis.
TEST(GantryControl, AStepInFreeMotionGivesTheDesiredClosedLoop) {
  std::mt19937 rng(20250101);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto vector = [&] { return Vector3d(unit(rng), unit(rng), unit(rng)); };
  const ImpedanceSettings s;
  const TipGain& m = s.shaped_inertia;
  const auto damping = [&](double stiffness, double inertia) {
    return 2.0 * s.damping_ratio * std::sqrt(stiffness * inertia);
  };
  for (int sample = 0; sample < 20; ++sample) {
    const ArmTerms arm = random_gantry(rng, 0.05);
    const Vector3d n = -arm.X_WE.R.col(2);  // aligned, so the error has no rotation
    TipReference reference;
    reference.p_WD = arm.X_WE.p + 1e-3 * vector();
    reference.v_WD = 0.05 * vector();
    reference.a_WD = vector();
    reference.n_WD = n;
    Wrench F_ext;
    F_ext << 2.0 * vector(), 0.1 * vector();
    ImpedanceController controller(s, 6);
    const ImpedanceTorque& out = controller.step(arm, reference, {}, F_ext);
    ASSERT_TRUE(out.status.ok());

    const JointVector a = arm.M.llt().solve(out.tau - arm.Cv - arm.g + arm.J.transpose() * F_ext);
    const Vector6 Vdot = arm.J * a + arm.Jdot_v;
    const Vector3d v = arm.V_WE.head<3>(), w = arm.V_WE.tail<3>();
    const TipGain& K = s.stiffness;
    const TipGain& zero = s.reference_stiffness;  // where K is zero
    const Vector3d force =
        diagonal(damping(K.linear.tangent, m.linear.tangent),
                 damping(K.linear.normal, m.linear.normal), n) *
            (reference.v_WD - v) +
        diagonal(K.linear.tangent, K.linear.normal, n) * (reference.p_WD - arm.X_WE.p) +
        F_ext.head<3>();
    const Vector3d torque = diagonal(damping(K.angular.tangent, m.angular.tangent),
                                     damping(zero.angular.normal, m.angular.normal), n) *
                                -w +
                            F_ext.tail<3>();
    const Vector3d linear = diagonal(m.linear.tangent, m.linear.normal, n) *
                            (Vdot.head<3>() - reference.a_WD),
                   angular = diagonal(m.angular.tangent, m.angular.normal, n) * Vdot.tail<3>();
    EXPECT_LT((linear - force).norm(), 1e-8);
    EXPECT_LT((angular - torque).norm(), 1e-8);
  }
}

// Through every mode, and with every input that a loop can get.
TEST(GantryControl, TorqueStaysWithinItsLimitsWhateverComesIn) {
  for (const InertiaShaping inertia :
       {InertiaShaping::natural, InertiaShaping::scaled, InertiaShaping::shaped}) {
    SCOPED_TRACE(static_cast<int>(inertia));
    ImpedanceSettings s;
    s.inertia = inertia;
    s.inertia_scale = 2.0;
    s.force_integral.enabled = true;
    s.limits.torque = Eigen::VectorXd::Constant(6, 40.0);
    s.limits.torque_rate = Eigen::VectorXd::Constant(6, 2000.0);
    s.joint_range.lower = Eigen::VectorXd::Constant(6, -0.5);
    s.joint_range.upper = Eigen::VectorXd::Constant(6, 0.5);
    ImpedanceController controller(s, 6);
    std::mt19937 rng(3);
    JointVector last = JointVector::Zero(6);
    bool seen[std::size(kContactModeNames)] = {};
    int bad = 0, singular = 0, stale_state = 0, stale_wrench = 0, limited = 0, fast = 0, lost = 0,
        near_end = 0;
    ArmTerms arm = random_gantry(rng, 0.2);
    for (int i = 0; i < 4000; ++i) {
      if (i % 200 == 0) arm = random_gantry(rng, 0.2);
      ArmTerms given = arm;
      TipReference reference;
      reference.p_WD = arm.X_WE.p;
      reference.n_WD = -arm.X_WE.R.col(2);
      reference.pen_down = i % 200 > 20;
      if (i % 50 > 40) reference.p_WD.y() += 0.5;
      SurfaceEstimate surface;
      surface.status = i % 400 > 350 && i % 400 < 380 ? SurfaceStatus::too_few : SurfaceStatus::ok;
      surface.n_W = reference.n_WD;
      surface.distance = reference.pen_down ? 0.0 : 0.03 * (i % 200) / 20.0;
      Wrench F_ext = Wrench::Zero();
      F_ext.head<3>() = 3.0 * reference.n_WD;
      InputAges ages;
      if (i % 113 == 0) {
        JointVector q = arm.q;
        q[4] = 0.5 * M_PI;
        Gantry().compute(q, arm.v, &given);
      }
      if (i % 97 == 0) given.v[3] = std::nan("");
      if (i % 101 == 0) given.M.setZero();
      if (i % 103 == 0) given.J.resize(6, 7);
      if (i % 107 == 0) F_ext[5] = INFINITY;
      if (i % 109 == 0) surface.n_W *= 2.0;
      if (i % 89 == 0) ages.state = 1.0;
      if (i % 400 > 150 && i % 400 < 200) ages.wrench = 1.0;
      const ImpedanceTorque& out = controller.step(given, reference, surface, F_ext, ages);
      ASSERT_TRUE(out.tau.allFinite()) << i;
      ASSERT_TRUE(out.terms.allFinite()) << i;
      ASSERT_LE(out.tau.cwiseAbs().maxCoeff(), 40.0 + 1e-9) << i;
      ASSERT_LE((out.tau - last).cwiseAbs().maxCoeff(), 2.0 + 1e-9) << i;
      last = out.tau;
      seen[static_cast<int>(out.mode)] = true;
      bad += out.status.bad_input;
      singular += out.status.near_singular;
      stale_state += out.status.stale_state;
      stale_wrench += out.status.stale_wrench;
      limited += out.status.torque_limited;
      fast += out.status.speed_limited;
      lost += out.status.surface_lost;
      near_end += out.status.joint_limit;
    }
    controller.reset();
    for (std::size_t mode = 0; mode < std::size(seen); ++mode)
      EXPECT_TRUE(seen[mode]) << kContactModeNames[mode];
    for (const int count :
         {bad, singular, stale_state, stale_wrench, limited, fast, lost, near_end})
      EXPECT_GT(count, 5) << "not every input was met";
  }
}

// A force that swings about the push as on a stiff canvas: the status tells it until a reset, and
// with the arm's own inertia never.
TEST(GantryControl, AStiffContactIsToldUntilAReset) {
  for (const InertiaShaping inertia : {InertiaShaping::shaped, InertiaShaping::natural}) {
    ImpedanceSettings s;
    s.inertia = inertia;
    ImpedanceController controller(s, 6);
    std::mt19937 rng(20261130);
    const ArmTerms arm = random_gantry(rng, 0.0);
    TipReference reference;
    reference.p_WD = arm.X_WE.p;
    reference.n_WD = -arm.X_WE.R.col(2);
    reference.pen_down = true;
    SurfaceEstimate surface;
    surface.status = SurfaceStatus::ok;
    surface.n_W = reference.n_WD;
    surface.distance = 0.0;
    const auto told = [&](double swing) {
      Wrench F_ext = Wrench::Zero();
      F_ext.head<3>() = (s.normal_force + swing) * reference.n_WD;
      return controller.step(arm, reference, surface, F_ext).status.stiff_contact;
    };
    bool any = false;
    for (int i = 0; i < 300; ++i) any |= told(i < 50 ? 0.0 : 3.0 * std::sin(0.2 * i));
    EXPECT_EQ(any, inertia == InertiaShaping::shaped);
    EXPECT_EQ(told(0.0), any);
    controller.reset();
    EXPECT_FALSE(told(0.0));
  }
}

}  // namespace
}  // namespace impedraw
