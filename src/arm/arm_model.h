// Rigid-body model of a serial arm with a pen, read from a URDF. Based on Pinocchio, whose headers
// are included only by this folder's sources.
#pragma once

#include <filesystem>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "impedraw/common/pose.h"
#include "impedraw/common/range.h"
#include "impedraw/control/arm_terms.h"

namespace impedraw {

struct ArmLimits {
  Eigen::VectorXd lower, upper;  // joint range [rad]
  Eigen::VectorXd torque;        // ± [Nm]
  Eigen::VectorXd speed;         // ± [rad/s]
  // Limit on every joint's torque rate [Nm/s]; infinite where the description does not say.
  double torque_rate = std::numeric_limits<double>::infinity();
};

inline constexpr Limit kRotorInertia = {"rotor_inertia", "kg m²", {0.0, 10.0}};

// Collision capsule of a link: all points within `radius` of the segment a–b.
struct BodyCapsule {
  std::string link;
  Eigen::Vector3d a_W, b_W;  // [m]
  double radius;             // [m]
};

// A description, which copies share, and a workspace, which each copy has for itself. Queries write
// into the workspace: who asks owns a copy, and what others are given is const. Not thread-safe.
// Joints are in the order of the URDF.
class ArmModel {
 public:
  // `tip_frame` is the frame E of the pen tip: origin at the tip's apex, z out of the tip.
  // Joints that do not carry it are fixed where they stand (plain_urdf.h). Throws InputError if the
  // file is missing or malformed, lacks the frame, or has a joint with more than one axis or fewer
  // than 6 or more than kMaxJoints joints on the way to it.
  explicit ArmModel(const std::filesystem::path& urdf, const std::string& tip_frame = "tip");
  ~ArmModel();
  ArmModel(const ArmModel& other);
  ArmModel(ArmModel&&) noexcept;

  int joints() const;
  const std::vector<std::string>& joint_names() const;
  const ArmLimits& limits() const;
  // The posture that the description gives (arm_notes.h), else empty [rad].
  const std::vector<double>& rest_posture() const;

  // Inertia of the rotors about the joints' axes, reflected through their gears [kg m²]. It stands
  // on the diagonal of M, and turns with nothing else: neither C nor g has a part of it.
  const Eigen::VectorXd& rotor_inertia() const;
  // One value for all joints, or one for each; none: what the description says (arm_notes.h), else
  // zero. Throws InputError for another number of values, or one below 0 or not finite.
  void set_rotor_inertia(const std::vector<double>& values);

  // Moves the frame E along its z, as a pen of another length does [m].
  void lengthen_pen(double by);

  // From now on Cv includes b v, with the joints' damping b as the description has it (<dynamics>).
  // Not for an arm that compensates its friction itself. Dry friction is in no term.
  void expect_damping();

  // Computes all terms at (q, v). Allocates nothing. The relative difference from MuJoCo's terms is
  // < 1e-9 (tests/arm).
  void compute(const JointVector& q, const JointVector& v, ArmTerms* terms) noexcept;
  // Computes only q, X_WE and J of these terms, the same bit by bit, in a quarter of the time.
  void place(const JointVector& q, ArmTerms* terms) noexcept;

  Pose tip_pose(const JointVector& q);  // X_WE
  // the URDF's collision cylinders, spheres and capsules, and those that enclose its other bodies
  std::vector<BodyCapsule> body_capsules(const JointVector& q);

 private:
  struct Description;
  struct Workspace;
  void move_tip(ArmTerms* terms) const noexcept;
  std::shared_ptr<const Description> description_;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace impedraw
