// Finds the link whose body touches the canvas. Only this folder's sources include this header.
//
// Bodies   cylinders, spheres and capsules of the URDF, of links that a joint moves. The tip sphere
//          is none of them: it may touch.
// Touch    a point p of a body's axis has its closest canvas point q inside the body. For a plane
//          this is exact, flat ends included. The axis is searched to kAxisStep.
//
// Distances are queried only when the body can have come near since the last query. Where its axis
// is by now is asked only when the joints have turned far enough: before, none of its points can
// have moved by more than the joints' turns times the arm's length.
#pragma once

#include <string>
#include <vector>

#include <mujoco/mujoco.h>

#include "impedraw/canvas/canvas.h"
#include "impedraw/common/pose.h"

namespace impedraw {

class LinkContact {
 public:
  static constexpr double kAxisStep = 0.5e-3;  // [m]

  // `shape`: a model with the bodies' shapes, needed only here; canvas: null: nothing touches.
  LinkContact(const mjModel* shape, const Canvas* canvas);

  void reset() noexcept;
  // data: of a model with the same bodies, at the present state; X_KW: to the canvas's frame.
  // Allocates nothing but for a new contact's name.
  void update(const mjData* data, const Pose& X_KW) noexcept;
  // Bodies may have moved by so much without the joints [m].
  void shifted(double by) noexcept { way_ += by; }
  const std::string& link() const { return link_; }  // empty: none

 private:
  struct Body {
    int id = 0;  // of MuJoCo
    std::string link;
    Eigen::Vector3d a, b;  // ends of the axis, in the link's frame [m]
    double radius = 0.0;   // [m]
    bool flat = false;     // a cylinder, else rounded ends
    // ends at the last query, K [m], and how far they may move from there without a touch
    Eigen::Vector3d a_K, b_K;
    double free = 0.0;
    double due = 0.0;  // value of way_ from which on it may have moved so far [m]
  };
  bool touches(const Body& body, const Eigen::Vector3d& a_K, const Eigen::Vector3d& b_K,
               double* free) const noexcept;

  const Canvas* canvas_;
  std::vector<Body> bodies_;
  double length_ = 0.0;  // of the arm, at least [m]
  // Way that no point has exceeded, from the last positions and in the last canvas's frame [m].
  double way_ = 0.0;
  Eigen::VectorXd q_;
  Pose X_KW_;
  std::string link_;
};

}  // namespace impedraw
