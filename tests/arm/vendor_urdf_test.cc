// Descriptions as vendors write them: what is read, what a pen's arm gets, and what is said.
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "iiwa_variants.h"
#include "impedraw/arm/arm_model.h"
#include "impedraw/arm/arm_shapes.h"
#include "impedraw/arm/enclosing_capsules.h"
#include "impedraw/arm/plain_urdf.h"
#include "impedraw/common/errors.h"
#include "impedraw/simulation/world.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using ::testing::Contains;
using ::testing::HasSubstr;

// Of n links that turn about z and y in turns, 0.2 m apart along z, and what follows link n.
struct Vendor {
  int joints = 6;
  std::string limit = "<limit lower='-3' upper='3' effort='100' velocity='2'/>";
  std::string type = "revolute";
  std::string inertial =
      "<inertial><origin xyz='0 0 0.1'/><mass value='2'/><inertia ixx='0.02' iyy='0.02' "
      "izz='0.01' ixy='0' ixz='0' iyz='0'/></inertial>";
  std::string body = "<collision><geometry><sphere radius='0.05'/></geometry></collision>";
  std::string end;  // fixed to link n

  std::string text() const {
    std::string urdf = "<robot name='vendor'><link name='base'/>";
    for (int i = 1; i <= joints; ++i) {
      urdf += fmt::format(
          "<joint name='j{0}' type='{1}'><parent link='{2}'/><child link='l{0}'/><origin xyz='0 0 "
          "0.2'/><axis xyz='{3}'/>{4}</joint><link name='l{0}'>{5}{6}</link>",
          i, type, i == 1 ? "base" : fmt::format("l{}", i - 1), i % 2 == 0 ? "0 1 0" : "0 0 1",
          limit, inertial, body);
    }
    return urdf + end + "</robot>";
  }
};

std::string fixed(const std::string& parent, const std::string& child, const std::string& origin,
                  const std::string& content = "") {
  return fmt::format(
      "<joint name='{1}_joint' type='fixed'><parent link='{0}'/><child link='{1}'/><origin {2}/>"
      "</joint><link name='{1}'>{3}</link>",
      parent, child, origin, content);
}

std::string finger(const std::string& parent, const std::string& name, const std::string& more) {
  return fmt::format(
      "<joint name='{1}_joint' type='prismatic'><parent link='{0}'/><child link='{1}'/><origin "
      "xyz='0 0 0.06'/><axis xyz='0 1 0'/>{2}</joint><link name='{1}'><inertial><origin xyz='0 0 "
      "0.02'/><mass value='0.1'/><inertia ixx='1e-4' iyy='1e-4' izz='1e-4' ixy='0' ixz='0' "
      "iyz='0'/></inertial><collision><origin xyz='0 0 0.02'/><geometry><box size='0.02 0.02 "
      "0.04'/></geometry></collision></link>",
      parent, name, more);
}

const std::string kTip = fixed("l6", "tip", "xyz='0 0 0.1'");

class VendorUrdf : public ScratchFolder {
 protected:
  template <typename Read>
  std::string refusal(Read read) const {
    ::testing::internal::CaptureStderr();
    std::string error = "accepted";
    try {
      read();
    } catch (const InputError& caught) {
      error = caught.what();
    }
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    EXPECT_EQ(error.find('\n'), std::string::npos) << error;
    return error;
  }
  std::string refused(const std::string& urdf) const {
    const auto file = write("arm.urdf", urdf);
    return refusal([&] { ArmModel{file}; });
  }
  PlainUrdf made(const std::string& urdf, const std::string& flange = "") const {
    const PlainUrdf made = vendor_urdf_with_pen(write("arm.urdf", urdf), flange, {});
    require_arm(made.text, "made.urdf");
    return made;
  }
};

// The terms of both readers at a seeded state, compared.
void expect_same_arm(const std::filesystem::path& file, unsigned seed) {
  SCOPED_TRACE(fmt::format("seed {}", seed));
  ArmModel model(file);
  World world(file, nullptr, {});
  ASSERT_EQ(model.joints(), world.joints());
  std::mt19937 random(seed);
  JointVector q(model.joints());
  for (double& x : q) x = std::uniform_real_distribution<double>(-1.5, 1.5)(random);
  world.set_state(q, JointVector::Zero(q.size()));
  ArmTerms terms(model.joints());
  model.compute(q, JointVector::Zero(q.size()), &terms);
  EXPECT_LT((terms.M - world.terms().M).norm(), 1e-9 * terms.M.norm());
  EXPECT_LT((terms.g - world.terms().bias).norm(), 1e-9 * (1.0 + terms.g.norm()));
  EXPECT_LT((terms.X_WE.p - world.state().X_WE.p).norm(), 1e-9);
}

TEST_F(VendorUrdf, ALimitThatCannotBeIsNamedWithJointAttributeAndValue) {
  for (const char* what : {"velocity", "effort"}) {
    for (const char* value : {"0", "-1", "-0.0", "1e-9"}) {
      Vendor arm{.end = kTip};
      arm.limit = fmt::format("<limit lower='-3' upper='3' {}='{}' {}='2'/>", what, value,
                              what[0] == 'v' ? "effort" : "velocity");
      EXPECT_THAT(
          refused(arm.text()),
          HasSubstr(fmt::format("joint 'j1': <limit {}=\"{}\">; valid is 0.01 ", what, value)));
    }
    Vendor arm{.end = kTip};
    arm.limit =
        fmt::format("<limit lower='-3' upper='3' {}='2'/>", what[0] == 'v' ? "effort" : "velocity");
    EXPECT_THAT(refused(arm.text()),
                HasSubstr(fmt::format("joint 'j1': <limit> without {}; valid", what)));
    arm.limit = fmt::format("<limit lower='-3' upper='3' {}='nan' {}='2'/>", what,
                            what[0] == 'v' ? "effort" : "velocity");
    EXPECT_THAT(refused(arm.text()),
                HasSubstr(fmt::format("joint 'j1': <limit {}=\"nan\">", what)));
  }
}

TEST_F(VendorUrdf, ContinuousJointsTurnByAFullTurnEitherWay) {
  const auto file =
      write("arm.urdf",
            Vendor{.limit = "<limit effort='9' velocity='2'/>", .type = "continuous", .end = kTip}
                .text());
  const ArmModel model(file);
  EXPECT_NEAR(model.limits().lower[3], -2.0 * std::numbers::pi, 1e-6);
  EXPECT_NEAR(model.limits().upper[3], 2.0 * std::numbers::pi, 1e-6);
  expect_same_arm(file, 1);
}

// Fingers at 0.03 m, the least of their range; the second follows the first the other way.
TEST_F(VendorUrdf, WhatDoesNotCarryTheTipIsFixedWhereItStandsWithItsMass) {
  const std::string range = "<limit lower='0.03' upper='0.05' effort='9' velocity='1'/>";
  const std::string gripper =
      finger("hand", "a", range) +
      finger("hand", "b",
             "<limit lower='-0.05' upper='-0.03' effort='9' velocity='1'/><mimic joint='a_joint' "
             "multiplier='-1'/>");
  const std::string hand = fixed("l6", "hand", "xyz='0 0 0.1' rpy='0 0 0.4'");
  const auto file = write("arm.urdf", Vendor{.end = hand + gripper + kTip}.text());
  ArmModel arm(file);
  ASSERT_EQ(arm.joints(), 6);
  expect_same_arm(file, 2);
  // The weight of both on joint 2, level: 0.1 kg each at 4 · 0.2 + 0.1 + 0.06 + 0.02 m.
  ArmModel bare(write("bare.urdf", Vendor{.end = hand + kTip}.text()));
  JointVector q = JointVector::Zero(6);
  q[1] = 0.5 * std::numbers::pi;
  ArmTerms with(6), without(6);
  arm.compute(q, JointVector::Zero(6), &with);
  bare.compute(q, JointVector::Zero(6), &without);
  EXPECT_NEAR(std::abs(with.g[1] - without.g[1]), 2.0 * 0.1 * 9.81 * 0.98, 1e-6);
  double apart = 0.0;
  for (const BodyCapsule& body : arm.body_capsules(JointVector::Zero(6)))
    if (body.link == "a") apart = Vector3d(body.a_W + body.b_W).head<2>().norm() / 2.0;
  EXPECT_NEAR(apart, 0.03, 1e-4);
  EXPECT_EQ(read_arm_shapes(file).size(), 11u);
}

TEST_F(VendorUrdf, AMimicJointOnTheWayIsRefused) {
  Vendor arm{.end = kTip};
  arm.limit += "<mimic joint='j1'/>";
  EXPECT_THAT(refused(arm.text()), HasSubstr("mimics joint 'j1'"));
}

TEST_F(VendorUrdf, InertiaThatCannotBeIsNamedInTheFilesWords) {
  Vendor arm{.end = kTip};
  arm.inertial = changed(arm.inertial, "<inertia", "iyy='0.02'", "iyy='0.5'");
  EXPECT_THAT(refused(arm.text()),
              ::testing::AllOf(HasSubstr("link 'l1': <inertia ixx=\"0.02\" iyy=\"0.5\""),
                               HasSubstr("triangle rule"), HasSubstr("0.01, 0.02 and 0.5")));
  EXPECT_THAT(made(changed(arm.text(), kTip, kTip, "")).notes,
              Contains(HasSubstr("link 'l1': <inertia")));
  arm.inertial = changed(arm.inertial, "<mass", "value='2'", "value='-2'");
  EXPECT_THAT(refused(arm.text()), HasSubstr("link 'l1': <mass value=\"-2\">; valid is 0 kg"));
}

// Kinova's MOVO has a flat link, whose moments of 1 and 9 make the third, and Valkyrie a frame of
// 1e-22 kg m²: MuJoCo's rounding takes them for impossible.
TEST_F(VendorUrdf, InertiaOfAFlatOrTinyBodyIsPossible) {
  for (const std::string inertia :
       {"ixx='0.000009' ixy='-0.000001' ixz='0' iyy='0.000001' iyz='0' izz='0.000010'",
        "ixx='3e-22' ixy='0' ixz='0' iyy='3e-22' iyz='0' izz='5e-22'",
        "ixx='0.001' ixy='0' ixz='0' iyy='0.001' iyz='0' izz='0'",
        "ixx='0.21138718794883493' ixy='0.0035281396999986767' ixz='-0.00011216841643736652' "
        "iyy='0.00032280319352499809' iyz='0.0072182170137206399' izz='0.21120174739479408'"}) {
    const std::string held = "<inertial><mass value='0.02'/><inertia " + inertia + "/></inertial>";
    const PlainUrdf plain =
        made(Vendor{.end = kTip + fixed("l3", "frame", "xyz='0 0 0'", held)}.text());
    expect_same_arm(write("made.urdf", plain.text), 5);
  }
}

TEST_F(VendorUrdf, AJointThatMovesNoMassIsNamed) {
  Vendor arm{.end = kTip};
  arm.inertial = "";
  EXPECT_THAT(
      refused(arm.text()),
      HasSubstr("link 'l1', which joint 'j1' moves, and what is fixed to it have no <mass>"));
  // What is fixed to a link moves with it.
  std::string urdf = Vendor{.end = kTip}.text();
  const std::string inertial = Vendor{}.inertial;
  urdf = changed(urdf, "<link name='l3'>", inertial, "");
  EXPECT_THAT(
      refused(urdf),
      HasSubstr("link 'l3', which joint 'j3' moves, and what is fixed to it have no <mass>"));
  urdf = changed(urdf, "</robot>", "</robot>",
                 fixed("l3", "motor", "xyz='0 0 0.05'", inertial) + "</robot>");
  EXPECT_EQ(refused(urdf), "accepted");
  expect_same_arm(write("arm.urdf", urdf), 3);
}

// An STL of a slanted rod, an OBJ of a box with a scale, a box, a capsule.
class VendorBodies : public VendorUrdf {
 protected:
  void SetUp() override {
    std::filesystem::create_directories(folder_ / "pkg/meshes");
    std::filesystem::create_directories(folder_ / "pkg/urdf");
    write("pkg/meshes/box.obj",
          "v -100 -50 0\nv 100 -50 0\nv 100 50 0\nv -100 50 0\nv -100 -50 400\nv 100 -50 400\n"
          "v 100 50 400\nv -100 50 400\nf 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 3 4 8 7\n"
          "f 2 3 7 6\nf 1 4 8 5\n");
  }
  std::string arm_with(const std::string& shape) const {
    return Vendor{
        .body = "<collision><origin xyz='0 0 -0.1'/><geometry>" + shape + "</geometry></collision>",
        .end = kTip}
        .text();
  }
};

TEST_F(VendorBodies, MeshesAndBoxesAreEnclosed) {
  for (const char* shape :
       {"<mesh filename='package://pkg/meshes/box.obj' scale='0.001 0.001 0.001'/>",
        "<mesh filename='package://renamed/meshes/box.obj' scale='0.001 0.001 0.001'/>",
        "<mesh filename='../meshes/box.obj' scale='0.001 0.001 0.001'/>"}) {
    SCOPED_TRACE(shape);
    ArmModel arm(write("pkg/urdf/arm.urdf", arm_with(shape)));
    const std::vector<BodyCapsule> bodies = arm.body_capsules(JointVector::Zero(6));
    ASSERT_GE(bodies.size(), 6u);
    for (double x : {-0.1, 0.1})
      for (double y : {-0.05, 0.05})
        for (double z : {0.1, 0.5}) {  // of link 1, whose origin is 0.2 m up
          double least = 1.0;
          for (const BodyCapsule& b : bodies) {
            const Vector3d p(x, y, z), d = b.b_W - b.a_W;
            const double s =
                d.isZero() ? 0.0 : std::clamp(d.dot(p - b.a_W) / d.squaredNorm(), 0., 1.);
            if (b.link == "l1") least = std::min(least, (p - b.a_W - s * d).norm() - b.radius);
          }
          EXPECT_LE(least, 1e-6);
        }
  }
  EXPECT_EQ(refused(arm_with("<box size='0.1 0.1 0.3'/>")), "accepted");
  EXPECT_EQ(refused(arm_with("<capsule radius='0.05' length='0.3'/>")), "accepted");
  EXPECT_THAT(refused(arm_with("<box size='0.1 -0.1 0.3'/>")),
              HasSubstr("link 'l1': a box's size"));
  EXPECT_THAT(refused(arm_with("<capsule radius='0' length='0.3'/>")),
              HasSubstr("a capsule's rad"));
  // Kinova's base link has the first of these.
  for (const std::string none :
       {"<box size='0 0 0'/>", "<sphere radius='0'/>", "<cylinder radius='0' length='0'/>"}) {
    const std::vector<std::string> notes = made(arm_with(none)).notes;
    EXPECT_EQ(std::ranges::count_if(notes,
                                    [](const std::string& n) {
                                      return n.starts_with("link 'l1': its collision ") &&
                                             n.ends_with("left out");
                                    }),
              1)
        << none;
  }
}

TEST_F(VendorBodies, AMeshThatCannotBeReadIsNamedOrReplaced) {
  const std::string urdf = arm_with("<mesh filename='package://none/gone.stl'/>");
  EXPECT_THAT(refused(urdf), HasSubstr("link 'l1': its collision mesh 'package://none/gone.stl'"));
  EXPECT_THAT(made(urdf).notes, Contains(HasSubstr("a body of 60 mm around the way")));
  write("bad.stl", "solid of nothing");
  EXPECT_THAT(refused(arm_with("<mesh filename='bad.stl'/>")), HasSubstr("cannot be read"));
}

// The reader recurses into nodes: it ended the program.
TEST_F(VendorBodies, AMeshThatCrashesItsReaderIsNamed) {
  std::string nodes;
  for (int i = 1; i < 200'000; ++i) nodes += fmt::format("{{\"children\":[{}]}},", i);
  write("deep.gltf",
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
        "\"nodes\":[" +
            nodes + "{}]}");
  EXPECT_THAT(refused(arm_with("<mesh filename='deep.gltf'/>")), HasSubstr("crashed"));
}

// Random clouds of triangles, by distance to the segment.
TEST(EnclosingCapsules, HoldEveryTriangle) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    const Vector3d size(std::exp(normal(random)), std::exp(normal(random)),
                        std::exp(normal(random)));
    std::vector<Triangle> triangles(1 + random() % 300);
    for (Triangle& t : triangles)
      for (Vector3d& p : t)
        p = Vector3d(normal(random), normal(random), normal(random)).cwiseProduct(size);
    const std::vector<Capsule> capsules = enclosing_capsules(triangles);
    EXPECT_LE(capsules.size(), 4u);
    for (const Triangle& t : triangles) {
      const bool held = std::any_of(capsules.begin(), capsules.end(), [&t](const Capsule& c) {
        return std::all_of(t.begin(), t.end(), [&c](const Vector3d& p) {
          const Vector3d d = c.b - c.a;
          const double s = d.isZero() ? 0. : std::clamp(d.dot(p - c.a) / d.squaredNorm(), 0., 1.);
          return (p - c.a - s * d).norm() <= c.radius * (1.0 + 1e-9);
        });
      });
      EXPECT_TRUE(held);
    }
  }
}

TEST(EnclosingCapsules, ARodIsHardlyLarger) {
  std::vector<Triangle> rod;
  for (int i = 0; i < 36; ++i) {
    const auto rim = [](int k, double z) {
      const double turn = k * std::numbers::pi / 18.0;
      return Vector3d(0.05 * std::cos(turn), 0.05 * std::sin(turn), z);
    };
    rod.push_back({rim(i, 0.0), rim(i + 1, 0.0), rim(i, 1.0)});
  }
  const std::vector<Capsule> capsules = enclosing_capsules(rod);
  ASSERT_EQ(capsules.size(), 1u);
  EXPECT_NEAR(capsules[0].radius, 0.05, 0.002);
}

TEST_F(VendorUrdf, ThePenGoesOnTheFlangeThatIsClear) {
  // z of `flange` lies across, as in ROS-Industrial; tool0's points out.
  const auto ends = [](const std::string& on) {
    return fixed(on, "flange", "xyz='0 0 0.1' rpy='0 -1.5707963 0'") +
           fixed("flange", "tool0", "rpy='0 1.5707963 0'") + fixed(on, "camera", "xyz='0.1 0 0'");
  };
  const PlainUrdf pen = made(Vendor{.joints = 7, .end = ends("l7")}.text());
  EXPECT_THAT(pen.notes, Contains(HasSubstr("stands on 'tool0', along its (0.00, 0.00, 1.00)")));
  ArmModel arm(write("pen.urdf", pen.text));
  EXPECT_NEAR(arm.tip_pose(JointVector::Zero(7)).p.z(), 1.5 + 0.12, 1e-6);
  // Joint 6 turns about y, across z of the links: the pen follows the axis.
  EXPECT_THAT(made(Vendor{.joints = 6, .end = ends("l6")}.text()).notes,
              Contains(HasSubstr("stands on 'tool0', along its (0.00, 1.00, 0.00)")));
}

TEST_F(VendorUrdf, ThePenLeavesAlongTheLastAxisAndBeyondTheGripper) {
  std::string hand = fixed("l7", "hand", "xyz='0 0 0.1'");
  const std::string range = "<limit lower='0' upper='0.05' effort='9' velocity='1'/>";
  const PlainUrdf pen = made(Vendor{.joints = 7,
                                    .end = hand + finger("hand", "a", range) +
                                           finger("hand", "b", range + "<mimic joint='a_joint'/>")}
                                 .text());
  EXPECT_THAT(pen.notes, Contains(HasSubstr("stands on 'hand', along its (0.00, 0.00, 1.00)")));
  EXPECT_THAT(pen.notes, Contains(HasSubstr("fixed where they stand: a_joint b_joint")));
  const auto file = write("pen.urdf", pen.text);
  ArmModel arm(file);
  ASSERT_EQ(arm.joints(), 7);
  const Pose X_WE = arm.tip_pose(JointVector::Zero(7));
  // 7 · 0.2 + 0.1, the finger's end at 0.06 + 0.04, at most 16 mm of its capsule, the pen's 0.12.
  EXPECT_GE(X_WE.p.z(), 1.5 + 0.1 + 0.12);
  EXPECT_LE(X_WE.p.z(), 1.5 + 0.1 + 0.12 + 0.016);
  EXPECT_NEAR(X_WE.R(2, 2), 1.0, 1e-9);
  expect_same_arm(file, 4);
  // The same frames turned upside down: the pen still leaves the arm.
  hand = fixed("l7", "hand", "xyz='0 0 0.1' rpy='3.14159265358979 0 0'");
  ArmModel turned(write("turned.urdf", made(Vendor{.joints = 7, .end = hand}.text()).text));
  EXPECT_NEAR(turned.tip_pose(JointVector::Zero(7)).p.z(), 1.5 + 0.12, 1e-6);
}

// As robosuite's Panda: link7 and link8, which it carries, say nothing.
TEST_F(VendorUrdf, OfNamelessLinksOneOnTheOtherTheLastCarriesThePen) {
  const std::string on = fixed("l6", "plate_a", "xyz='0 0 0.1'") + fixed("plate_a", "plate_b", "");
  EXPECT_THAT(made(Vendor{.end = on}.text()).notes, Contains(HasSubstr("stands on 'plate_b'")));
}

// As Franka's FR3 (a body for collisions beside the flange) and KUKA's iiwa 7 (two frames on it).
TEST_F(VendorUrdf, OfNamelessLinksTheFurthestFrameOnTheLastAxisCarriesThePen) {
  const std::string body = Vendor{}.body;
  const std::string fr3 = fixed("l6", "l6_sc", "", body) + fixed("l6", "l7", "xyz='0 0.107 0'") +
                          fixed("l6", "camera", "xyz='0.1 0.2 0'");
  EXPECT_THAT(made(Vendor{.end = fr3}.text()).notes, Contains(HasSubstr("stands on 'l7'")));
  const std::string iiwa = fixed("l6", "ee_a", "xyz='0 0.045 0' rpy='0 -1.57 0'") +
                           fixed("l6", "ee_b", "xyz='0 0.045 0'");
  EXPECT_THAT(made(Vendor{.end = iiwa}.text()).notes,
              Contains(HasSubstr("stands on 'ee_a', along its (0.00, 1.00, 0.00)")));
}

// As TALOS's gripper.
TEST_F(VendorUrdf, AFixedJointMimicsNothing) {
  std::string urdf = Vendor{.end = kTip}.text();
  urdf.replace(urdf.find("'0 0 0.1'/></joint>"), 19, "'0 0 0.1'/><mimic joint='j1'/></joint>");
  EXPECT_EQ(ArmModel(write("arm.urdf", urdf)).joints(), 6);
}

// MuJoCo refuses them; an ABB IRB 4600 has two materials in a visual.
TEST_F(VendorUrdf, OfElementsThatStandTwiceTheFirstCounts) {
  std::string urdf = Vendor{.end = kTip}.text();
  const auto put = [&urdf](const std::string& before, const std::string& more) {
    const std::size_t at = urdf.find(before);
    ASSERT_NE(at, std::string::npos);
    urdf.insert(at, more);
  };
  put("</link>",
      "<visual><geometry><sphere radius='0.1'/></geometry><material name='a'/><material "
      "name='b'/></visual>");
  put("<axis xyz='0 1 0'/>", "<axis xyz='0 1 0'/><axis xyz='1 0 0'/>");
  const PlainUrdf plain = made(urdf);
  EXPECT_THAT(plain.notes, ::testing::IsSupersetOf(
                               {HasSubstr("its visual has another <material>: the first counts"),
                                HasSubstr("joint 'j2' has another <axis>: the first counts")}));
  expect_same_arm(write("made.urdf", plain.text), 3);
}

// As the SO-100: five joints and a jaw.
TEST_F(VendorUrdf, AJawIsNoJointOfAnArm) {
  std::string urdf = Vendor{}.text();
  for (std::size_t at; (at = urdf.find("'l6'")) != std::string::npos;) urdf.replace(at, 4, "'jaw'");
  const auto file = write("jaw.urdf", urdf);
  EXPECT_THAT(refusal([&] { vendor_urdf_with_pen(file, "", {}); }),
              HasSubstr("it holds no arm of 6 joints or more"));
}

TEST_F(VendorUrdf, CandidatesAreListedWhereTheFlangeIsNotClear) {
  const std::string body = Vendor{}.body;
  const std::string parts =
      fixed("l6", "plate_a", "xyz='0 0 0.1'", body) + fixed("l6", "plate_b", "", body);
  const std::string urdf = Vendor{.end = parts}.text();
  const auto file = write("arm.urdf", urdf);
  EXPECT_THAT(refusal([&] { vendor_urdf_with_pen(file, "", {}); }),
              HasSubstr("--flange takes one of l6, plate_a, plate_b"));
  EXPECT_THAT(
      refusal([&] { vendor_urdf_with_pen(file, "plate", {}); }),
      HasSubstr("--flange plate: no such link at an arm's end; candidates are l6, plate_a"));
  EXPECT_THAT(made(urdf, "plate_a").notes, Contains(HasSubstr("stands on 'plate_a'")));
  // Read as it is, without a pen.
  EXPECT_THAT(refusal([&] { ArmModel{file}; }),
              ::testing::AllOf(HasSubstr("no frame named 'tip'"), HasSubstr("arm make-urdf --arm"),
                               HasSubstr("candidates for LINK are l6, plate_a, plate_b")));
}

TEST_F(VendorUrdf, WhatIsMissingIsFilledInAndSaid) {
  Vendor arm{.joints = 7,
             .limit = "<limit lower='-3' upper='3' effort='0' velocity='0'/>",
             .inertial = "",
             .end = fixed("l7", "tool0", "xyz='0 0 0.1'")};
  const PlainUrdf pen = made(arm.text());
  EXPECT_THAT(pen.notes,
              Contains(HasSubstr(
                  "link 'l1', which joint 'j1' moves, and what is fixed to it have no <mass>")));
  EXPECT_THAT(pen.notes, Contains(HasSubstr("joint 'j7': <limit velocity=\"0\">: it became 1.5")));
  const auto file = write("pen.urdf", pen.text);
  ArmModel model(file);
  expect_same_arm(file, 5);
  // Stretched out level, every joint carries the arm with at most half of its torque.
  JointVector q = JointVector::Zero(7);
  q[1] = 0.5 * std::numbers::pi;
  ArmTerms terms(7);
  model.compute(q, JointVector::Zero(7), &terms);
  for (int i = 0; i < 7; ++i) EXPECT_LE(2.0 * std::abs(terms.g[i]), model.limits().torque[i]);
}

}  // namespace
}  // namespace impedraw
