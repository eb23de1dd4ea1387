// Holds the depth of a cut below the touched surface, by the push along the normal.
//
// Score   a first, shallow cut by force alone: the surface is where E was, less the depth f_n/k
// Cut     F = F_n + I,  İ = kRate k (d_asked − d),  |I| ≤ kShare F_n
//         d = n·(p_S − p_E) − d_1 (1 − F_n/F)
// F_n     of the reference: what the model of the cut asks for
// p_S     of the touched places nearby, weighted by their nearness
// d_1     depth of the score. In material F/F_n times as hard as believed it was that much less.
// In contact only; at rest, and where nothing was touched, I stays. Allocates nothing.
#pragma once

#include "impedraw/common/place_map.h"
#include "impedraw/control/tip_reference.h"

namespace impedraw {

struct CutModel {
  double stiffness;  // k: force per depth in fresh material [N/m]
  double score;      // d_1 [m]
};

class DepthHold {
 public:
  static constexpr double kRate = 6.0;   // [1/s]
  static constexpr double kShare = 0.7;  // of F_n

  DepthHold(const CutModel& cut, double dt) : cut_(cut), dt_(dt) {}  // [s]

  // The push for this step [N]. n: unit normal of the contact; f_n: measured along it [N].
  double force(const TipReference& reference, const Eigen::Vector3d& p_E, const Eigen::Vector3d& n,
               double f_n, bool touches) noexcept;

 private:
  CutModel cut_;
  double dt_;
  double integral_ = 0.0;             // [N]
  PlaceMap touched_{5e-4, 1u << 17};  // p: mean of what was touched in the cube
};

}  // namespace impedraw
