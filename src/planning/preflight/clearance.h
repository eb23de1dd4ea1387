// Clearance of the arm from a canvas and a table. The arm's bodies are capsules; its pen is a
// tapered rod.
//
// A body's gap     min over its axis of |p − canvas| or p_z − table, less its radius
// The pen's gap    min over its axis, from `tip_length` above the tip, of |p − canvas| or p_z −
//                  table, less ρ(h) + c(h)
//                  ρ(h) = min(r, h sin α)        balls in the cone from the tip to the shaft's end,
//                  tan α = r / h_0, then the shaft's
//                  c(h) = min(c, kPenOpening h)  desired clearance, 0 at the tip, which must touch
// The pen is the body whose end is nearest to the tip, at most 50 mm away. r is its radius; h_0 is
// the height above the tip at which it begins. On a plane whose normal is at angle θ to the pen,
// the gap is positive up to cos θ = sin α + kPenOpening: 53° for a pen of 5 mm that begins 10 mm
// up.
//
// A gap may be overestimated by up to a tenth plus 1 mm, but it is always negative where something
// touches. Capsules round the flat ends of cylinders, so a body may appear nearer by up to its
// radius. Both sides of the canvas count. Bodies that no joint moves may touch the table and a
// canvas that stands: the arm stands on a table, which may be a part of a scanned canvas.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/canvas/canvas.h"

namespace impedraw {

inline constexpr double kFarEnough = 0.03;   // larger gaps are reported as this value [m]
inline constexpr double kPenOpening = 0.15;  // [1]

struct Gap {
  double gap = kFarEnough;     // [m]; < 0: penetration
  std::string body, obstacle;  // link; "canvas" or "table"
  double above_tip = 0;        // for the pen: position on its axis [m]
};

class Clearance {
 public:
  // The canvas (in W; null: none) must outlive this object. `q`: any posture of the
  // arm. `desired`: c [m], less than kFarEnough. `tip_length`: of the pen that is not checked [m].
  Clearance(const ArmModel& arm, const Canvas* canvas, std::optional<double> table_z,
            double desired, double tip_length, const JointVector& q);

  // Moves the canvas there; at first its frame K is W.
  void move_canvas(const Pose& X_WK) {
    X_KW_ = X_WK.inverse();
    canvas_moves_ = true;
  }

  // Smallest gap at posture q. Fast if q has changed little since the last call: distances change
  // by no more than the bodies move.
  Gap arm(const JointVector& q);  // without the pen
  // The desired clearance is subtracted. X_WE: the tip's pose at q.
  Gap pen(const JointVector& q, const Pose& X_WE);

 private:
  struct Body {
    bool fixed = false;        // no joint moves it
    Eigen::Vector3d a_K, b_K;  // axis ends at the last canvas query [m]
    double distance = 0;       // lower bound of the axis' distance from the canvas then [m]
  };
  double canvas_distance(Body& body, const BodyCapsule& at, double near_enough);

  ArmModel arm_;
  const Canvas* canvas_;
  Pose X_KW_;  // of the canvas
  bool canvas_moves_ = false;
  std::optional<double> table_z_;
  double desired_, tip_length_;
  std::vector<Body> bodies_;  // as body_capsules()
  int pen_ = -1;              // of bodies_
};

}  // namespace impedraw
