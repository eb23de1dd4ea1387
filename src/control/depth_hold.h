// Holds the depth of a cut below the touched surface, by the push along the normal.
//
// Score   a first, shallow cut by force alone: the surface is where E was, less the depth f_n/k
// Cut     F = F_n + I,  İ = kRate k (d_asked − d),  −kLess F_n ≤ I ≤ kMore F_n
//         before it touches I = (h − 1) F_n;
//         d = Δ + d_1/h,  Δ = n·(p_S − p_E) − d_1
// F_n     of the reference: what the model of the cut asks for
// p_S     of the touched places nearby, weighted by their nearness
// d_1     depth of the score. In material h times as hard as believed it was that much less.
// h       learned in the first cut, from depth d_1 to d_2: F would reach the depth y in material as
//         believed, so that h d = y and h Δ = y − d_1 ≈ (d_2 − d_1) (F/F_n)^e; filtered by kLearn
// e       1.2 + 0.8 d_1/d_2, within 2 % of the model's: the score lies in the way of the cut
// In contact only; at rest, and where nothing was touched, I stays. Allocates nothing.
#pragma once

#include <algorithm>
#include <cmath>

#include "impedraw/common/place_map.h"
#include "impedraw/control/tip_reference.h"

namespace impedraw {

struct CutModel {
  double stiffness;  // k: force per depth in fresh material [N/m]
  double score;      // d_1 [m]
  double first;      // d_2: of the first cut [m]
};

class DepthHold {
 public:
  static constexpr double kRate = 6.0;               // [1/s]
  static constexpr double kLess = 0.7, kMore = 1.5;  // of F_n
  static constexpr double kLearn = 0.5;              // [s]

  DepthHold(const CutModel& cut, double dt) : cut_(cut), dt_(dt) {}  // [s]

  // The push for this step [N]. n: unit normal of the contact; f_n: measured along it [N].
  double force(const TipReference& reference, const Eigen::Vector3d& p_E, const Eigen::Vector3d& n,
               double f_n, bool touches) noexcept {
    constexpr double kNear = 1e-4;  // distance that counts half as much as none [m]
    constexpr double kSoftest = 0.3, kHardest = 3.0;  // h
    constexpr double kMoves = 1e-3;  // while it sinks in, at a line's start, nothing is wrong [m/s]
    if (!touches) {
      integral_ = 0.0;
      if (reference.depth > 0.0)
        integral_ = std::clamp(hardness_ - 1.0, -kLess, kMore) * reference.force;
      return reference.force + integral_;
    }
    if (!(reference.depth > 0.0)) {
      touch(p_E, n, f_n);
      return reference.force;
    }
    double sum = 0.0, weights = 0.0;
    touched_.around(p_E + reference.depth * n, [&](const KeptPlace& place) {
      const Eigen::Vector3d to = place.p - p_E;
      const double depth = n.dot(to);
      const double weight = 1.0 / (kNear * kNear + (to - depth * n).squaredNorm());
      sum += weight * depth;
      weights += weight;
    });
    if (weights > 0.0 && reference.v_WD.norm() > kMoves) {
      const double deeper = sum / weights - cut_.score;  // Δ
      if (reference.depth < 1.01 * cut_.first && deeper > 0.0) {
        const double y = (cut_.first - cut_.score) * std::pow(1.0 + integral_ / reference.force,
                                                              1.2 + 0.8 * cut_.score / cut_.first);
        hardness_ +=
            dt_ / (kLearn + dt_) * (std::clamp(y / deeper, kSoftest, kHardest) - hardness_);
      }
      const double depth = deeper + cut_.score / hardness_;
      integral_ += kRate * cut_.stiffness * dt_ * (reference.depth - depth);
      integral_ = std::clamp(integral_, -kLess * reference.force, kMore * reference.force);
    }
    return reference.force + integral_;
  }

  // The score was here, as in force().
  void touch(const Eigen::Vector3d& p_E, const Eigen::Vector3d& n, double f_n) noexcept {
    const Eigen::Vector3d p_S = p_E + std::max(0.0, f_n) / cut_.stiffness * n;
    if (KeptPlace* const place = touched_.at(p_S)) {
      place->value += 1.0;
      place->p += (p_S - place->p) / place->value;
    }
  }

 private:
  CutModel cut_;
  double dt_;
  double integral_ = 0.0;             // [N]
  double hardness_ = 1.0;             // h
  PlaceMap touched_{5e-4, 1u << 17};  // p: mean of what was touched in the cube
};

}  // namespace impedraw
