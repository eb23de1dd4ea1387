// The arm's body in one posture, as cameras see it: a copy at which a second thread may cast rays
// while the arm moves on.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

struct mjModel_;
struct mjData_;

namespace impedraw {

struct PosedBody {
  // A shape of one of MuJoCo's kinds, placed in W.
  struct Shape {
    int kind = 0, geom = 0;
    Eigen::Vector3d size = Eigen::Vector3d::Zero();  // [m]
    Eigen::Vector3d p_W = Eigen::Vector3d::Zero();   // [m]
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R_WG;
    double radius = 0.0;  // of a ball about all of it [m]
  };
  std::vector<Shape> shapes;
  // The model that posed it, which must outlive it, for shapes that are meshes.
  const mjModel_* model = nullptr;
  std::shared_ptr<mjData_> placed;  // null without meshes

  // Puts all of it where it is in the data of that model. Allocates nothing the second time.
  void copy(const mjModel_* model, const mjData_* data);

  enum class Rays { all, finite };  // which of them are cast at the body
  // Lowers each distance along its unit direction from the origin [m] to that of the body, where
  // that is nearer. The same numbers as World::ray_to_arm(); directions of neighbouring pixels are
  // fast. `finite`: a body before nothing counts as nothing. Allocates nothing.
  void cover(const Eigen::Vector3d& origin_W, std::span<const Eigen::Vector3d> directions_W,
             std::span<double> distances, Rays rays) const noexcept;
};

}  // namespace impedraw
