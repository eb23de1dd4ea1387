// How near the arm comes to a canvas and to a table: its bodies as capsules, its pen as a rod with
// a taper.
//
// A body's gap     min over its axis of |p − canvas| or p_z − table, less its radius
// The pen's gap    min over its axis, from kTipLength above the tip, of |p − canvas| or p_z −
//                  table, less ρ(h) + c(h)
//                  ρ(h) = min(r, h sin α)        balls in the cone from the tip to the shaft's end,
//                  tan α = r / h_0, then the shaft's
//                  c(h) = min(c, kPenOpening h)  desired clearance: the tip is to touch
// The pen: the body whose end is nearest to the tip, no more than 50 mm off; r its radius, h_0 how
// far above the tip it begins. On a plane whose normal stands at θ to the pen its gap is over 0 up
// to cos θ = sin α + kPenOpening: 60° for a pen of 5 mm that begins 10 mm up.
//
// Gaps are exact to a tenth and 1 mm on the far side, and never 0 or more where something touches.
// Capsules round off the flat ends of cylinders, so an arm's body may seem nearer by up to its
// radius. Of the canvas, both sides count. Bodies that no joint moves may touch the table: the arm
// stands on it.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"

namespace impedraw {

inline constexpr double kFarEnough = 0.03;   // gaps are not told apart beyond [m]
inline constexpr double kTipLength = 5e-3;   // of the pen that nothing is asked of [m]
inline constexpr double kPenOpening = 0.05;  // [1]

struct Gap {
  double gap = kFarEnough;     // [m]; < 0: into it
  std::string body, obstacle;  // link; "canvas" or "table"
  double above_tip = 0;        // of the pen: where on its axis [m]
};

class Clearance {
 public:
  // The canvas (in W, null: none) must outlive it, and the arm. `q`: any posture of the arm.
  // `desired`: c [m], under kFarEnough.
  Clearance(ArmModel& arm, const Canvas* canvas, std::optional<double> table_z, double desired,
            const JointVector& q);

  // At that posture. Quick where it has moved little since the last: distances change by no more
  // than the bodies move.
  Gap arm(const JointVector& q);  // without the pen
  Gap pen(const JointVector& q,
          const Pose& X_WE);  // less what is desired; X_WE the tip's pose at q

 private:
  struct Body {
    bool fixed = false;        // no joint moves it
    Eigen::Vector3d a_W, b_W;  // where the canvas was last looked for …
    double distance = 0;       // … and its axis was at least so far from it [m]
  };
  double canvas_distance(Body& body, const BodyCapsule& at, double near_enough);

  ArmModel& arm_;
  const Canvas* canvas_;
  std::optional<double> table_z_;
  double desired_;
  std::vector<Body> bodies_;  // as body_capsules()
  int pen_ = -1;              // of bodies_
};

}  // namespace impedraw
