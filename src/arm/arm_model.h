// Rigid-body model of a serial arm with a pen, read from a URDF. Pinocchio computes; its headers
// stay in this folder's sources.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "impedraw/common/pose.h"
#include "impedraw/control/arm_terms.h"

namespace impedraw {

struct ArmLimits {
  Eigen::VectorXd lower, upper;  // joint range [rad]
  Eigen::VectorXd torque;        // ± [Nm]
  Eigen::VectorXd speed;         // ± [rad/s]
};

// A piece of the arm's body: all points within `radius` of the segment a–b.
struct BodyCapsule {
  std::string link;
  Eigen::Vector3d a_W, b_W;  // [m]
  double radius;             // [m]
};

// One instance serves one thread: queries use a workspace. All are for the joint order of the URDF.
class ArmModel {
 public:
  // `tip_frame` is the frame E of the pen tip: origin at the tip's apex, z out of the tip.
  // Throws InputError for a file that is missing, broken, has other than single-axis joints, over
  // kMaxJoints, or no such frame.
  explicit ArmModel(const std::filesystem::path& urdf, const std::string& tip_frame = "tip");
  ~ArmModel();
  ArmModel(ArmModel&&) noexcept;

  int joints() const;
  const std::vector<std::string>& joint_names() const;
  const ArmLimits& limits() const;

  // All terms of the law at (q, v). Allocates nothing. Errors against MuJoCo's own terms: < 1e-9
  // relative (tests/arm).
  void compute(const JointVector& q, const JointVector& v, ArmTerms* terms) noexcept;

  Pose tip_pose(const JointVector& q);  // X_WE
  // the URDF's collision cylinders and spheres
  std::vector<BodyCapsule> body_capsules(const JointVector& q);

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace impedraw
