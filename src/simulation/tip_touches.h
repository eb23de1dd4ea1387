// The places at which the ball of the tip touches the canvas: one on a smooth surface, several in a
// groove, between a wire and the ground beneath it, or between two sheets.
//
//   c      centre of the ball, in the canvas's frame [m]
//   q      a place where the distance from c to the canvas has a local minimum [m]
//   d      ± |c − q|, < 0 behind the face at q
//   clear  of c from the canvas: |d|, but −|d| once c has passed through it; touched if < radius
//   n      unit: from q towards c; back again once c has passed through. At a rim, (c − q)/|c − q|
//
// A sheet that is open bears the tip on both of its sides. c passes through where d changes its
// sign and |d| ≤ |c − c'|, its way since the last call: else that way cannot have crossed the face
// at q. The place has then jumped to another part, which shows its other side, and c is beside it.
// Round a rim one sheet's sides meet. A tip that begins at most the ball's radius behind a face
// begins in contact with its front.
//
// Beside the nearest place, another is touched unless a part of the canvas lies between it and c.
// While c is through, no new one begins, and those that were touched go on: else the back of the
// other face of a thin plate would pull the ball through.
//
// The ball's contact patches overlap where their normals are close. Beyond kApart each place has
// the tip's whole stiffness; within kSame, as between neighbouring triangles of a smooth surface,
// the nearest place has it alone. Between, with overlap o from 0 to 1 and penetrations φ, place i
// has the share ∏_j (1 − o_ij φ_j²/(φ_i² + φ_j²)): no force jumps where the nearest place changes.
#pragma once

#include <array>
#include <span>

#include "impedraw/canvas/canvas.h"

namespace impedraw {

struct TipTouch {
  Eigen::Vector3d p, n;  // q [m] and n, in the canvas's frame
  double clear = 0.0;    // [m]
  double share = 1.0;    // of the tip's stiffness and damping
};

class TipTouches {
 public:
  static constexpr int kMost = 6;                           // the nearest ones
  static constexpr double kSame = 0.9659, kApart = 0.7071;  // cosines: 15°, 45°

  void reset() noexcept { *this = {}; }
  // The nearest place first, whether it is touched or not; the others are touched. None if the
  // canvas is further away than ten times the radius: a tip pressed through so far has lost it.
  std::span<const TipTouch> update(const Canvas& canvas, const Eigen::Vector3d& c,
                                   double radius) noexcept;

 private:
  struct Side {
    double sign;  // of d
    bool through;
  };
  Side side_of(const Eigen::Vector3d& c, const SurfacePoint& place, double radius) const noexcept;
  bool went_on(const Eigen::Vector3d& n) const noexcept;

  bool begun_ = false;
  int count_ = 0;
  std::array<TipTouch, kMost> touches_;
  std::array<Side, kMost> sides_;
  Eigen::Vector3d c_ = Eigen::Vector3d::Zero();
};

}  // namespace impedraw
