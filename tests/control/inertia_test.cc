// The apparent inertia at the tip, in six axes, with MuJoCo as the plant; and the inertias that
// set-up refuses.
#include <cmath>
#include <regex>
#include <string>

#include <gtest/gtest.h>

#include "dense_algebra.h"
#include "free_arm.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using namespace testing_arm;

struct Case {
  const char* name;
  InertiaShaping inertia;
  double scale;
};
const Case kCases[] = {
    {"half", InertiaShaping::scaled, 0.5},       {"0.7", InertiaShaping::scaled, 0.7},
    {"natural", InertiaShaping::scaled, 1.0},    {"twice", InertiaShaping::scaled, 2.0},
    {"four times", InertiaShaping::scaled, 4.0}, {"natural by name", InertiaShaping::natural, 1.0},
    {"shaped", InertiaShaping::shaped, 0.0},     {"light", InertiaShaping::light_normal, 0.2}};

ImpedanceSettings settings_of(const ArmModel& arm, const Case& c) {
  ImpedanceSettings s = shaped_settings(arm);
  s.inertia = c.inertia;
  if (c.scale > 0.0) s.inertia_scale = c.scale;
  s.stability_check.contact_stiffness_max = 2e3;  // the tip is free here
  s.null_space.q_0[2] += 0.3;                     // excites the null space
  return s;
}

// V̇ of the true arm under τ and F: J M⁻¹ (τ + Jᵀ F − bias) + J̇v, all MuJoCo's, J̇v by finite
// difference.
Vector6 tip_acceleration(World& world, const JointVector& tau, const Wrench& F) {
  const World::Terms t = world.terms();
  const JointVector q = world.state().q, v = world.state().v;
  const double h = 1e-6;
  world.set_state(q + h * v, v);
  const Eigen::MatrixXd J_after = world.terms().J;
  world.set_state(q - h * v, v);
  const Vector6 drift = (J_after - world.terms().J) / (2.0 * h) * v;
  world.set_state(q, v);
  const Eigen::VectorXd force = tau + t.J.transpose() * F - t.bias;
  return t.J * solve(t.M, force) + drift;
}

Matrix6 desired_inertia(const FreeArm& free, const Case& c, const ImpedanceSettings& s) {
  Matrix6 M_d = Matrix6::Zero();
  if (c.inertia == InertiaShaping::shaped) {
    M_d.topLeftCorner<3, 3>() = s.shaped_inertia.linear.matrix(free.reference.n_WD);
    M_d.bottomRightCorner<3, 3>() = s.shaped_inertia.angular.matrix(free.reference.n_WD);
    return M_d;
  }
  const World::Terms t = free.world.terms();
  if (c.inertia == InertiaShaping::light_normal) {
    const Eigen::Vector3d& n = free.reference.n_WD;
    Matrix6 S = Matrix6::Identity();
    S.topLeftCorner<3, 3>() -= (1.0 - std::sqrt(c.scale)) * n * n.transpose();
    return S * operational_inertia(t.J, t.M) * S;
  }
  return c.scale * operational_inertia(t.J, t.M);
}

Wrench push(int axis) { return (axis < 3 ? 8.0 : 0.5) * Wrench::Unit(axis); }

TEST(DesiredInertia, IsWhatAPushMeetsInAllSixAxes) {
  ArmModel arm(kArm);
  const unsigned seed = 12;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  double worst = 0.0;
  for (const Case& c : kCases) {
    const ImpedanceSettings s = settings_of(arm, c);
    for (int posture = 0; posture < 6; ++posture) {
      const ArmTerms start = random_terms(arm, rng);
      FreeArm free(s, start.q);
      for (const bool moving : {false, true}) {
        // on the plan, at its velocity: no spring or damper force, but Coriolis and drift terms
        if (moving) {
          free.world.set_state(start.q, start.v);
          free.measure();
          free.reference.v_WD = free.terms.V_WE.head<3>();
          free.reference.w_WD = free.terms.V_WE.tail<3>();
        }
        ImpedanceSettings fast = s;
        fast.limits.tip_speed = 5.0;
        const Matrix6 M_d = desired_inertia(free, c, s);
        for (int axis = 0; axis < 6; ++axis) {
          ImpedanceController fresh(fast, 7);
          free.measure();
          const JointVector tau = fresh.step(free.terms, free.reference, {}, push(axis)).tau;
          const Vector6 expected = inverse(M_d) * push(axis),
                        V_dot = tip_acceleration(free.world, tau, push(axis));
          const double error = (V_dot - expected).norm() / expected.norm();
          worst = std::max(worst, error);
          EXPECT_LT(error, 1e-5) << c.name << ", axis " << axis
                                 << (moving ? ", moving" : ", at rest");
          // without the wrench the arm's own inertia would show
          if (c.scale != 1.0 && c.inertia != InertiaShaping::light_normal) {
            ImpedanceController deaf(fast, 7);
            const JointVector unaware =
                deaf.step(free.terms, free.reference, {}, Wrench::Zero()).tau;
            EXPECT_GT((tip_acceleration(free.world, unaware, push(axis)) - expected).norm(),
                      0.1 * expected.norm())
                << c.name;
          }
        }
      }
    }
  }
  RecordProperty("worst_relative_error", std::to_string(worst));
}

TEST(DesiredInertia, IsWhatTheSimulatedTipMovesBy) {
  ArmModel arm(kArm);
  for (const Case& c : kCases) {
    ImpedanceSettings s = settings_of(arm, c);
    s.stiffness = {{1.0, 1.0}, {0.01, 0.0}};  // negligible over the 5 ms of the test
    s.reference_stiffness = {{1.0, 1.0}, {0.01, 0.01}};
    s.damping_ratio = 0.05;
    s.stability_check.contact_stiffness_max = 1.0;
    for (int axis = 0; axis < 6; ++axis) {
      FreeArm free(s);
      const Vector6 expected = inverse(desired_inertia(free, c, s)) * (0.1 * push(axis));
      const int steps = 5;
      for (int i = 0; i < steps; ++i) {
        free.F_ext = 0.1 * push(axis);  // the wrench of this step
        free.step_under(Wrench(free.F_ext));
      }
      const Vector6 V_dot = free.world.state().V_WE / (steps * s.timing.dt);
      EXPECT_LT((V_dot - expected).norm(), 0.01 * expected.norm()) << c.name << ", axis " << axis;
    }
  }
}

TEST(DesiredInertia, AScaleOfOneIsTheNaturalOne) {
  ArmModel arm(kArm);
  std::mt19937 rng(13);
  ImpedanceSettings scaled = settings_of(arm, kCases[2]), natural = settings_of(arm, kCases[5]);
  for (int i = 0; i < 20; ++i) {
    const ArmTerms terms = random_terms(arm, rng);
    TipReference reference;
    reference.p_WD = terms.X_WE.p + 0.01 * Eigen::Vector3d::Random();
    reference.n_WD = -terms.X_WE.R.col(2);
    ImpedanceController a(scaled, 7), b(natural, 7);
    EXPECT_LT((a.step(terms, reference, {}, push(i % 6)).tau -
               b.step(terms, reference, {}, push(i % 6)).tau)
                  .norm(),
              1e-9);
  }
}

std::string refusal(const ImpedanceSettings& s) {
  try {
    ImpedanceController(s, 7);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

double named_value(const std::string& message) {
  std::smatch found;
  return std::regex_search(message, found, std::regex("valid are ([0-9.eE+-]+) "))
             ? std::stod(found[1])
             : std::nan("");
}

TEST(RefusedInertia, ScaledNeedsAWrench) {
  ArmModel arm(kArm);
  ImpedanceSettings s = settings_of(arm, kCases[3]);
  s.wrench = WrenchFeedback::none;
  const std::string why = refusal(s);
  EXPECT_NE(why.find("scaled"), std::string::npos) << why;
  EXPECT_NE(why.find("measured wrench"), std::string::npos) << why;
  EXPECT_NE(why.find("natural"), std::string::npos) << why;
  s.inertia_scale = 1.0;
  EXPECT_EQ(refusal(s), "") << "once Λ is the natural inertia";
  for (const double scale : {0.0, -1.0, std::nan("")}) {
    ImpedanceSettings bad = settings_of(arm, kCases[3]);
    bad.inertia_scale = scale;
    EXPECT_NE(refusal(bad).find("inertia_scale"), std::string::npos) << scale;
  }
}

TEST(RefusedInertia, AnUnstableScaleNamesTheAxisTheCauseAndWhatWouldDo) {
  ArmModel arm(kArm);
  ImpedanceSettings s = shaped_settings(arm);
  s.inertia = InertiaShaping::scaled;
  s.inertia_scale = 0.2;
  s.stability_check.contact_stiffness_max = 50e3;
  s.timing.wrench_delay = 5e-3;
  const std::string why = refusal(s);
  for (const char* part : {"normal", "0.2", "5e+04 N/m", "5 ms", "valid are"})
    EXPECT_NE(why.find(part), std::string::npos) << part << ": " << why;
  s.inertia_scale = named_value(why);
  EXPECT_GT(s.inertia_scale, 0.2);
  EXPECT_EQ(refusal(s), "");
}

TEST(RefusedInertia, TheValueNamedIsAlwaysAccepted) {
  ArmModel arm(kArm);
  const unsigned seed = 14;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  int refused[2] = {};
  for (int i = 0; i < 60; ++i) {
    const bool shaped = i % 2;
    ImpedanceSettings s = shaped_settings(arm);
    s.stability_check.contact_stiffness_max = std::pow(10.0, 3.0 + 2.0 * unit(rng));
    s.timing.wrench_delay = 1e-3 * (1.0 + std::floor(6.0 * unit(rng)));
    s.stability_check.natural_mass_max = 6.0;
    s.inertia = shaped ? InertiaShaping::shaped : InertiaShaping::scaled;
    s.inertia_scale = 0.05 + 0.9 * unit(rng);
    s.shaped_inertia.linear.normal = 0.3 + 4.0 * unit(rng);
    // slow enough for every mass here
    s.stiffness.linear.normal = s.reference_stiffness.linear.normal = 300.0;
    const std::string why = refusal(s);
    if (why.empty()) continue;
    const double value = named_value(why);
    ASSERT_TRUE(std::isfinite(value)) << why;
    ++refused[shaped];
    (shaped ? s.shaped_inertia.linear.normal : s.inertia_scale) = value;
    EXPECT_EQ(refusal(s), "") << "after: " << why;
  }
  EXPECT_GT(refused[0], 5);
  EXPECT_GT(refused[1], 5);
}

TEST(RefusedInertia, ADampingThatIsTooFastNamesTheFactorThatWouldDo) {
  ArmModel arm(kArm);
  for (int axis = 0; axis < 4; ++axis) {
    ImpedanceSettings s = shaped_settings(arm);
    s.stability_check.contact_stiffness_max = 1e3;
    double* inertia[] = {&s.shaped_inertia.linear.tangent, &s.shaped_inertia.linear.normal,
                         &s.shaped_inertia.angular.tangent, &s.shaped_inertia.angular.normal};
    const char* name[] = {"along the tangents", "along the normal", "about the tangents",
                          "about the normal"};
    *inertia[axis] *= 0.003;
    const std::string why = refusal(s);
    EXPECT_NE(why.find(name[axis]), std::string::npos) << why;
    std::smatch found;
    ASSERT_TRUE(std::regex_search(why, found, std::regex("valid is ([0-9.eE+-]+) times"))) << why;
    *inertia[axis] *= std::stod(found[1]);
    EXPECT_EQ(refusal(s).find("damping rate"), std::string::npos)
        << "after: " << why << "\nagain: " << refusal(s);
  }
}

}  // namespace
}  // namespace impedraw
