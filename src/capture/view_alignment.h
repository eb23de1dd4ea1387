// Puts the views of a still scene onto each other: cameras whose poses are known to a few
// millimetres disagree by as much.
//
// Minimises over the corrections T_v of all views, T_v p the place of what view v measured at p,
//   Σ_{a ≠ b} Σ_i ρ( n_i·(T_b p_i − T_a q_i) / σ ) + Σ_v |t_v|²/s² + |φ_v|²/γ²,
// p_i: a sample of view b; q_i: the sample of view a nearest to it; n_i: the mean of both normals,
// which takes the surface's curvature out of the distance; ρ: Huber's; t_v, φ_v: T_v as a motion of
// the camera. Gauss-Newton for all views at once, from far matches to near ones. The prior holds
// what no match tells, above all a motion of all views together.
//
// Corrections after which the views agree hardly better than as calibrated are not made: exact
// views stay. Directions that a view's matches leave open (registration.h) stay as calibrated. Then
// all views are moved together so that their cameras move the least, Σ |(t_v/s, φ_v/γ)|: views that
// agree stay. Of two views the first one stays.
//
// Sources: P. Besl, N. McKay, PAMI 1992; S. Rusinkiewicz, "A symmetric objective function for ICP",
// SIGGRAPH 2019; J. Zhang, M. Kaess, S. Singh, ICRA 2016.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "impedraw/common/pose.h"
#include "impedraw/perception/registration.h"

namespace impedraw {

// The measurements of one view, as it is calibrated.
struct ViewSamples {
  std::string name;
  Eigen::Vector3d p_WC = Eigen::Vector3d::Zero();  // its camera [m]
  std::vector<SeenPoint> samples;                  // W
};

struct AlignedView {
  Pose T;           // correction, in W
  int matches = 0;  // 0: the view overlaps with no other one, and stays
  std::vector<OpenDirection> open;
  // As a motion of the camera; of all that the open directions allow, the least.
  double shift = 0.0, turn_deg = 0.0;
};

struct ViewAlignment {
  std::vector<AlignedView> views;
  // Root-mean-square distance between views along the normals [m].
  double rms_before = 0.0, rms = 0.0;
};

// The same for the same input. Throws InputError naming a view whose camera would move further than
// 10 mm or 2°.
ViewAlignment align_views(std::span<const ViewSamples> views);

}  // namespace impedraw
