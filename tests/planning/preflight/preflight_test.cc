// The checks of whole drawings against what is known of the arm, and of surfaces in closed form.
#include "impedraw/planning/preflight/preflight.h"

#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <set>
#include <sstream>

#include <gtest/gtest.h>

#include "arm_on_surface.h"
#include "impedraw/common/errors.h"
#include "planning/surfaces.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// The arm's description with the first `text` after `joint` replaced.
std::filesystem::path changed_arm(const std::string& name, const std::string& joint,
                                  const std::string& text, const std::string& by) {
  std::stringstream all;
  all << std::ifstream(surfaces::kArm).rdbuf();
  std::string urdf = all.str();
  const std::size_t at = urdf.find(text, urdf.find("<joint name=\"" + joint + "\""));
  EXPECT_NE(at, std::string::npos);
  urdf.replace(at, text.size(), by);
  const auto file = std::filesystem::path(testing::TempDir()) / name;
  std::ofstream(file) << urdf;
  return file;
}

std::vector<Problem> problems(const Preflight& preflight) {
  std::vector<Problem> found;
  for (const Finding& finding : preflight.findings) found.push_back(finding.problem);
  return found;
}

class PreflightTest : public testing::Test {
 protected:
  Preflight check(const std::vector<PlacedStroke>& strokes, const SurfaceHeight& surface,
                  const Canvas* obstacle = nullptr) {
    return check_strokes(strokes, surface, arm, obstacle, surfaces::start_posture(arm), settings);
  }

  ArmModel arm{surfaces::kArm};
  PreflightSettings settings;
};

TEST_F(PreflightTest, PassesADrawingInTheBowl) {
  settings.table_z = 0.0;
  const auto strokes = surfaces::shape("M");
  const Preflight done = check(strokes, surfaces::bowl);
  EXPECT_TRUE(done.findings.empty()) << done.findings.front().text;
  ASSERT_EQ(done.drawable.size(), strokes.size());
  for (std::size_t i = 0; i < strokes.size(); ++i)
    EXPECT_NEAR(done.drawable[i].length(), plane_length(strokes[i]), 1e-12);
  EXPECT_GT(done.margins.joint, 0.2);
  EXPECT_LT(done.margins.torque_share, 0.5);
  EXPECT_LT(done.margins.effective_mass, 100);
}

TEST_F(PreflightTest, ReachEndsWhereTheArmIsStretched) {
  settings.space.max_effective_mass = 1e9;
  for (double z : {0.10, 0.25}) {
    const Preflight done = check({surfaces::line({{0.60, 0}, {0.95, 0}})}, surfaces::flat(z));
    // Shoulder 0.36 m up, 0.42 + 0.40 m to the wrist, which the upright pen holds 0.246 m above its
    // tip.
    const double radius = std::sqrt(0.82 * 0.82 - std::pow(z + 0.246 - 0.36, 2));
    ASSERT_EQ(problems(done), std::vector{Problem::out_of_reach});
    EXPECT_NEAR(0.60 + done.drawable.at(0).to, radius, 1e-3);
    EXPECT_LE(0.60 + done.drawable.at(0).to, radius + 1e-5);
    EXPECT_NEAR(done.findings[0].p_W.x(), 0.95, 1e-9) << "the farthest is the worst";
    EXPECT_NE(done.findings[0].text.find("mm"), std::string::npos);
  }
}

TEST_F(PreflightTest, SingularityIsSaidBeforeTheReachEnds) {
  const Preflight done = check({surfaces::line({{0.60, 0}, {0.95, 0}})}, surfaces::flat(0.1));
  EXPECT_EQ(problems(done), (std::vector{Problem::near_singular, Problem::out_of_reach}));
  EXPECT_LE(done.margins.effective_mass, settings.space.max_effective_mass);
  EXPECT_GT(done.margins.effective_mass, 0.8 * settings.space.max_effective_mass);
  // The loop's own criterion, at a posture on either side of the cut.
  for (double by : {-1e-3, 1e-3}) {
    const double x = 0.60 + done.drawable.at(0).to + by;
    const IkResult at =
        find_posture(arm, {{x, 0, 0.1}, -Vector3d::UnitZ()}, surfaces::start_posture(arm));
    ASSERT_TRUE(at.reached);
    ArmTerms terms(7);
    arm.compute(at.q, JointVector::Zero(7), &terms);
    OperationalSpace space(settings.space);
    EXPECT_EQ(space.update(terms), by < 0) << x;
  }
}

TEST_F(PreflightTest, NarrowedJointEndsTheStroke) {
  // Upright pen in the plane y = 0: joint 4 is the elbow, and its angle the law of cosines.
  const double limit = 1.5, margin = 0.05;
  ArmModel narrow(changed_arm("narrow.urdf", "joint_4", "lower=\"-2.0944\"", "lower=\"-1.5\""));
  settings.joint_margin = margin;
  settings.rest_q = JointVector::Zero(7);
  const JointVector start =
      find_posture(narrow, {{0.70, 0, 0.1}, -Vector3d::UnitZ()}, surfaces::start_posture(arm)).q;
  const Preflight done = check_strokes({surfaces::line({{0.72, 0}, {0.48, 0}})},
                                       surfaces::flat(0.1), narrow, nullptr, start, settings);
  ASSERT_EQ(problems(done), std::vector{Problem::joint_limit});
  const double angle = limit - margin,
               reach2 = 0.42 * 0.42 + 0.40 * 0.40 + 2 * 0.42 * 0.40 * std::cos(angle);
  const double x = std::sqrt(reach2 - std::pow(0.1 + 0.246 - 0.36, 2));
  EXPECT_NEAR(0.72 - done.drawable.at(0).to, x, 3e-4);
  EXPECT_EQ(done.findings[0].text.find("joint 4 at its limit of -1.50 rad, the tip stays"), 0u)
      << done.findings[0].text;
  EXPECT_NEAR(done.margins.joint, margin, 1e-3);
  // Everything up to the limit is reached; only the margin is zero.
  const double within = 0.72 - std::sqrt(0.42 * 0.42 + 0.40 * 0.40 +
                                         2 * 0.42 * 0.40 * std::cos(limit - 0.02) - 0.014 * 0.014);
  const PlacedStroke shorter = part_of(surfaces::line({{0.72, 0}, {0.48, 0}}), 0, within);
  const Preflight near =
      check_strokes({shorter}, surfaces::flat(0.1), narrow, nullptr, start, settings);
  ASSERT_EQ(problems(near), std::vector{Problem::joint_limit});
  EXPECT_EQ(near.findings[0].text, "joint 4 at -1.48 rad, 0.020 rad from its limit");
}

TEST_F(PreflightTest, TorqueIsWhatVirtualWorkSays) {
  settings.normal_force = 60;
  settings.friction = 0.4;
  const PlacedStroke dot = surfaces::line({{0.65, 0.05}});
  const Preflight done = check({dot}, surfaces::flat(0.1));
  ASSERT_TRUE(done.findings.empty());
  // A posture that equals the rest posture is kept.
  const JointVector q =
      find_posture(arm, {{0.65, 0.05, 0.1}, -Vector3d::UnitZ()}, surfaces::start_posture(arm)).q;
  const double share =
      check_strokes({dot}, surfaces::flat(0.1), arm, nullptr, q, settings).margins.torque_share;
  // Gravity from the arm's terms, the push from finite differences of the tip's position, friction
  // in the worst of many directions.
  ArmTerms terms(7);
  arm.compute(q, JointVector::Zero(7), &terms);
  double worst = 0;
  for (int j = 0; j < 7; ++j) {
    JointVector a = q, b = q;
    a[j] -= 1e-6;
    b[j] += 1e-6;
    const Vector3d moved = (arm.tip_pose(b).p - arm.tip_pose(a).p) / 2e-6;
    for (int k = 0; k < 720; ++k) {
      const double way = 2 * std::numbers::pi * k / 720;
      // of the pen on the surface
      const Vector3d force = 60 * Vector3d(0.4 * std::cos(way), 0.4 * std::sin(way), -1);
      worst = std::max(worst, std::abs(terms.g[j] + moved.dot(force)) / arm.limits().torque[j]);
    }
  }
  EXPECT_NEAR(share, worst, 1e-4);
  settings.torque_share = 0.98 * worst;
  const Preflight weak = check_strokes({dot}, surfaces::flat(0.1), arm, nullptr, q, settings);
  ASSERT_EQ(problems(weak), std::vector{Problem::torque});
  EXPECT_EQ(weak.findings[0].part.to, 0);
}

TEST_F(PreflightTest, PenStopsShortOfAWall) {
  // Upright pen towards a wall that ends 50 mm above the tip: 5 mm of shaft, and 5 mm of clearance
  // there.
  const Canvas wall(surfaces::wall(0.66, 0.5, 0, 0.15));
  const Preflight done =
      check({surfaces::line({{0.60, 0}, {0.66, 0}})}, surfaces::flat(0.1), &wall);
  ASSERT_EQ(problems(done), std::vector{Problem::pen_collision});
  EXPECT_NEAR(done.drawable.at(0).to, 0.05, settings.edge_tolerance + 5e-5);
  EXPECT_NE(done.findings[0].text.find("the tool "), std::string::npos);
  EXPECT_NE(done.findings[0].text.find("too near the canvas"), std::string::npos);
  // A higher one keeps the flange away, which is wider.
  const Canvas high(surfaces::wall(0.66, 0.5, 0, 0.8));
  const Preflight wide =
      check({surfaces::line({{0.58, 0}, {0.66, 0}})}, surfaces::flat(0.1), &high);
  ASSERT_FALSE(wide.findings.empty());
  EXPECT_EQ(wide.findings[0].problem, Problem::arm_collision);
  EXPECT_GE(wide.margins.clearance, settings.clearance);
  EXPECT_LT(wide.margins.clearance, settings.clearance + 1e-3);
}

TEST_F(PreflightTest, ArmKeepsOffATable) {
  settings.table_z = 0.4;  // above the drawing: the arm comes through it
  EXPECT_EQ(problems(check({surfaces::line({{0.58, 0}, {0.62, 0}})}, surfaces::flat(0.1))),
            std::vector{Problem::arm_collision});
  settings.table_z = 0.1;
  EXPECT_TRUE(check({surfaces::line({{0.58, 0}, {0.62, 0}})}, surfaces::flat(0.1)).findings.empty())
      << "drawing on the table";
}

TEST_F(PreflightTest, ASuddenTurnIsAJumpAndCutsTheStroke) {
  // The normal turns by 57° at one point without smoothing: the next posture is too far away.
  settings.normal_smoothing = 0;
  const SurfaceHeight ridge = [](double x, double y) {
    const double side = x < 0.6 ? -1 : 1;
    return SurfaceSample{{x, y, 0.2 - std::tan(0.5) * std::abs(x - 0.6)},
                         Vector3d(side * std::sin(0.5), 0, std::cos(0.5))};
  };
  const Preflight done = check({surfaces::line({{0.57, 0}, {0.63, 0}})}, ridge);
  ASSERT_EQ(done.findings.size(), 1u);
  EXPECT_EQ(done.findings[0].problem, Problem::joint_jump) << done.findings[0].text;
  EXPECT_NEAR(done.findings[0].part.from, 0.03,
              1.1e-3);  // between the samples on both sides of the ridge
  EXPECT_LT(done.findings[0].part.length(), 1.2e-3);
  EXPECT_EQ(done.drawable.size(), 2u);
}

TEST_F(PreflightTest, NamesWhatIsLeftTooShort) {
  // Holes on both sides of a rib 0.6 mm wide.
  const SurfaceHeight ribbed = [](double x, double y) -> std::optional<SurfaceSample> {
    if (std::abs(x - 0.6) > 0.0003 && std::abs(x - 0.6) < 0.01) return std::nullopt;
    return SurfaceSample{{x, y, 0.1}, Vector3d::UnitZ()};
  };
  const Preflight done = check({surfaces::line({{0.55, 0}, {0.65, 0}})}, ribbed);
  EXPECT_EQ(problems(done),
            (std::vector{Problem::off_canvas, Problem::too_short, Problem::off_canvas}));
  EXPECT_EQ(done.drawable.size(), 2u);
  EXPECT_EQ(check({surfaces::line({{0.5998, 0}, {0.6002, 0}})}, ribbed).drawable.size(), 1u)
      << "a short stroke is no remnant";
}

TEST_F(PreflightTest, TurnedDrawingFrameIsTheSame) {
  // The bowl expressed in another frame: the same cut at the same place in the world.
  settings.max_slope_deg = 25;
  const PlacedStroke stroke = surfaces::line({{0.6, 0}, {0.77, 0}});
  const Preflight plain = check({stroke}, surfaces::bowl);
  settings.X_WP.R = Eigen::AngleAxisd(std::numbers::pi / 2, Vector3d::UnitZ()).toRotationMatrix();
  settings.X_WP.p = {0.1, -0.2, 0.05};
  const Pose X_PW = settings.X_WP.inverse();
  const auto moved = [&](double x, double y) -> std::optional<SurfaceSample> {
    const Vector3d p = settings.X_WP * Vector3d(x, y, 0);
    const auto s = surfaces::bowl(p.x(), p.y());
    if (!s) return std::nullopt;
    return SurfaceSample{X_PW * s->p_P, X_PW.R * s->n_P};
  };
  PlacedStroke turned = stroke;
  for (Vector2d& p : turned.p_P) p = (X_PW * Vector3d(p.x(), p.y(), 0)).head<2>();
  const Preflight other = check({turned}, moved);
  ASSERT_EQ(problems(plain), problems(other));
  EXPECT_NEAR(plain.drawable.at(0).to, other.drawable.at(0).to, 1e-9);
  EXPECT_LT((plain.findings[0].p_W - other.findings[0].p_W).norm(), 1e-9);
}

TEST_F(PreflightTest, FindingsAndDrawablePartsCoverEveryStroke) {
  const unsigned seed = 20261121;
  SCOPED_TRACE(testing::Message() << "seed " << seed);
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  const Canvas wall(surfaces::wall(0.62, 0.1, 0, 0.17));
  const SurfaceHeight surface = [](double x, double y) -> std::optional<SurfaceSample> {
    if (std::hypot(x - 0.55, y - 0.05) < 0.03 || y < -0.2) return std::nullopt;
    const double ramp = y > 0.15 ? 5 * (y - 0.15) : 0, step = x > 0.5 ? 0.01 : 0;
    return SurfaceSample{{x, y, 0.1 + ramp + step}, Vector3d(0, y > 0.15 ? -5 : 0, 1).normalized()};
  };
  std::vector<PlacedStroke> strokes;
  for (int i = 0; i < 120; ++i) {
    PlacedStroke stroke;
    stroke.number = 2 * i;  // any, rising
    for (int k = 0; k < 1 + i % 4; ++k) {
      stroke.p_P.push_back({0.65 + 0.35 * unit(rng), 0.3 * unit(rng)});
      stroke.page.push_back(1e3 * stroke.p_P.back());
    }
    strokes.push_back(stroke);
  }
  const Preflight done = check(strokes, surface, &wall);
  std::set<Problem> seen;
  std::vector<StrokePart> parts = done.drawable;
  for (const Finding& finding : done.findings) {
    parts.push_back(finding.part);
    seen.insert(finding.problem);
    EXPECT_FALSE(finding.text.empty());
    const PlacedStroke& stroke = strokes[finding.part.stroke / 2];
    double nearest = 1;  // the worst place lies on the part
    for (double s = finding.part.from;; s = std::min(s + 1e-3, finding.part.to)) {
      nearest = std::min(nearest, (place_on(stroke, s).page - finding.page_mm).norm());
      if (s == finding.part.to) break;
    }
    EXPECT_LT(nearest, 0.51);
    EXPECT_LT((1e-3 * finding.page_mm - finding.p_W.head<2>()).norm(), 1e-4);
  }
  for (Problem problem : {Problem::off_canvas, Problem::fold, Problem::too_steep,
                          Problem::out_of_reach, Problem::pen_collision})
    EXPECT_TRUE(seen.count(problem)) << name_of(problem);
  std::stable_sort(parts.begin(), parts.end(), [](const StrokePart& a, const StrokePart& b) {
    return a.stroke != b.stroke ? a.stroke < b.stroke
           : a.from != b.from   ? a.from < b.from
                                : a.to < b.to;
  });
  std::size_t i = 0;
  for (const PlacedStroke& stroke : strokes) {
    double at = 0;
    ASSERT_LT(i, parts.size());
    for (; i < parts.size() && parts[i].stroke == stroke.number; ++i) {
      EXPECT_EQ(parts[i].from, at);
      at = parts[i].to;
    }
    EXPECT_NEAR(at, plane_length(stroke), 1e-12);
  }
  EXPECT_EQ(i, parts.size());
  for (std::size_t k = 1; k < done.findings.size(); ++k) {
    const StrokePart &a = done.findings[k - 1].part, &b = done.findings[k].part;
    EXPECT_TRUE(a.stroke < b.stroke || (a.stroke == b.stroke && a.from <= b.from));
  }
}

TEST_F(PreflightTest, SettingsOutOfRangeAreNamed) {
  settings.max_slope_deg = 95;
  try {
    check({surfaces::line({{0.6, 0}})}, surfaces::flat(0.1));
    FAIL() << "accepted";
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()), "preflight.max_slope is 95 deg, allowed is 1 to 89 deg");
  }
}

}  // namespace
}  // namespace impedraw
