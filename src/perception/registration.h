// The pose of a body, from samples of its surface and a model of it: point to plane, with the
// directions named that its shape leaves open.
//
// Minimises  Σ ρ( n_i·(p_i − X_WK q_i) / σ_i )  over X_WK; q_i, n_i: the model's point nearest to
// the sample and its normal; ρ: Huber's, so that the arm's shadow and what is not the body pull
// little; a match further off than 20 mm counts as none. Gauss-Newton from the predicted pose; a
// step ξ = (t, φ) moves a point by t + φ × (p − c), c the samples' centroid.
//
// With rotations scaled by the samples' RMS distance from c, the eigenvalues of the normal matrix
// over the sum of the weights lie between 0 and 1. Directions below kLeastEigenvalue are open: a
// plane slides in itself and turns about its normal, a sphere turns about its centre. The pose
// keeps its prediction in those directions (solution remapping), and its covariance says so.
//
// Sources: Y. Chen, G. Medioni, "Object modelling by registration of multiple range images", 1992;
// N. Gelfand, L. Ikemoto, S. Rusinkiewicz, M. Levoy, "Geometrically stable sampling for the ICP
// algorithm", 3DIM 2003; J. Zhang, M. Kaess, S. Singh, "On degeneracy of optimization-based state
// estimation problems", ICRA 2016.
#pragma once

#include <array>
#include <span>
#include <string>

#include "impedraw/common/pose.h"
#include "impedraw/perception/surface_model.h"

namespace impedraw {

inline constexpr double kHuber = 1.5;             // [standard deviations]
inline constexpr double kLeastEigenvalue = 4e-3;  // share, below which a direction is open
inline constexpr int kLeastMatches = 50;          // fewer: not found

// A motion that leaves the surface where it is.
struct OpenDirection {
  enum class Kind { slide, turn, screw };
  Kind kind = Kind::slide;
  Eigen::Vector3d axis_W = Eigen::Vector3d::Zero();   // unit: of the slide, or of the turn
  Eigen::Vector3d point_W = Eigen::Vector3d::Zero();  // on the turn's axis [m]
  double pitch = 0.0;                                 // of a screw [m/rad]

  // "slides along (1.00, 0.00, 0.00)",
  // "turns about (0.00, 0.00, 1.00) through (0.60, 0.00, 0.10) m"
  std::string text() const;
};

// The direction of e: a displacement of c and a turn in units of 1/radius.
OpenDirection open_direction(const Vector6& e, const Eigen::Vector3d& c, double radius) noexcept;

struct ShapeRegistration {
  bool found = false;
  Pose X_WK;
  int matches = 0;
  double rms = 0.0;                               // of the matches' distances along the normals [m]
  Eigen::Vector3d c_W = Eigen::Vector3d::Zero();  // that turns refer to [m]
  // Inverse covariance of ξ about c, in W; 0 in open directions [1/m², 1/(m rad), 1/rad²].
  Matrix6 information = Matrix6::Zero();
  // Normalised, ascending; the first `open` of them belong to open directions.
  std::array<double, 6> eigenvalues{};
  int open = 0;
  std::array<OpenDirection, 6> open_directions{};
};

// samples: in W. iterations: at most. Allocates nothing.
ShapeRegistration register_samples(const SurfaceModel& model, std::span<const SeenPoint> samples,
                                   const Pose& X_WK_predicted, int iterations = 10) noexcept;

}  // namespace impedraw
