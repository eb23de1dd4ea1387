// The side of the canvas that the tip is on. A sheet that is open bears the tip on both of them.
//
//   c      centre of the tip's ball, q the canvas's closest point to it, in the canvas's frame [m]
//   d      ± |c − q|, < 0 behind the face at q
//   clear  of c from the canvas: |d|, but −|d| once c has passed through it
//   n      unit: from q towards c; back again once c has passed through. At a rim, (c − q)/|c − q|
//
// c passes through where d changes its sign and |d| ≤ |c − c'|, its way since the last call: else
// that way cannot have crossed the face at q. The closest point has then jumped to another part,
// which shows its other side, and c is beside it. Round a rim one sheet's sides meet. A tip that
// begins at most the ball's radius behind a face begins in contact with its front.
#pragma once

#include <cmath>

#include "impedraw/canvas/canvas.h"

namespace impedraw {

struct TipFacing {
  double clear;       // [m]
  Eigen::Vector3d n;  // in the canvas's frame
};

class TipSide {
 public:
  void reset() noexcept { *this = {}; }
  // The canvas is out of reach of the ball.
  void leave() noexcept {
    begun_ = true;
    sign_ = 0.0;
    through_ = false;
  }
  TipFacing update(const Eigen::Vector3d& c, const SurfacePoint& closest, double radius) noexcept {
    const double depth = std::abs(closest.distance), sign = closest.distance < 0.0 ? -1.0 : 1.0;
    if (closest.on_edge)
      through_ = false;
    else if (!begun_)
      through_ = sign < 0.0 && depth <= radius;
    else if (sign_ * sign < 0.0)
      through_ = !through_ && depth <= (c - c_).norm() + kRounding;
    begun_ = true;
    sign_ = sign;
    c_ = c;
    if (closest.on_edge && depth > kRounding) return {depth, (c - closest.p_W) / depth};
    return through_ ? TipFacing{-depth, -sign * closest.n_W} : TipFacing{depth, sign * closest.n_W};
  }

 private:
  static constexpr double kRounding = 1e-9;  // [m]

  bool begun_ = false, through_ = false;
  double sign_ = 0.0;  // of the last d; 0: out of reach
  Eigen::Vector3d c_ = Eigen::Vector3d::Zero();
};

}  // namespace impedraw
