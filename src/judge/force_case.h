// The cases of the force benchmark, after the scenarios of S. Gadringer, H. Gattringer, A. Mueller,
// "Assessment of force control for surface finishing", Mech. Sci. 13, 361–370, 2022: contact from
// free air, changes of the command, holding, paths over a workpiece, and a hand that pushes.
//
// A run in time, from where the tip is:
//
//   travel   to kHover above the workpiece as believed
//   rest     kRest: a sensor is tared
//   descend  along the believed normal at approach_speed, to the believed surface
//   settle   kSettle under the programme's first command
//   programme, for `duration`: command, path, motion of the workpiece, hand
//   leave    up to kHover
//
// Every controller gets the same references and the same command. One that does not itself find the
// touch presses from the end of the descent on, over 40 ms.
#pragma once

#include <cmath>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "impedraw/canvas/triangle_mesh.h"
#include "impedraw/common/pose.h"
#include "impedraw/control/surface_estimate.h"
#include "impedraw/control/tip_reference.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/judge/force_metrics.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

// The workpiece of the force benchmark: three shapes about a middle p. All of them face upwards.
//
//   bowl  the lowest part of a sphere of 0.3 m, as the standard bowl; p is its lowest point
//   flat  a plane through p
//   roof  two planes that fall by 10° to either side of an edge along y through p
//
// A controller believes it to be where the rigid motion X_WB about p puts it.

struct Workpiece {
  enum class Shape { bowl, flat, roof };
  static constexpr std::string_view kNames[] = {"bowl", "flat", "roof"};

  Shape shape = Shape::bowl;
  Eigen::Vector3d p_W{0.60, 0.0, 0.10};  // the middle [m]
  Pose X_WB;                             // displacement of the belief from the truth, about p_W

  // The true one. The bowl's has chords of 1.5 mm, 1.9 µm off the sphere.
  TriangleMesh mesh() const;
  // As believed: nearest surface below and distance, and the point over (x, y) from the middle. The
  // roof's edge is believed to be round within 2 mm: an estimate from points cannot do better.
  SurfaceEstimate estimate(const Eigen::Vector3d& p_W) const noexcept;
  struct Place {
    Eigen::Vector3d p_W, n_W;
  };
  Place at(double x, double y) const noexcept;
};

struct ForceCase {
  std::string name, text;  // text: what is done, for the page
  Workpiece::Shape shape = Workpiece::Shape::bowl;
  double approach_speed = 0.03;  // [m/s]
  double duration = 4.0;         // of the programme [s]
  // Straight lines between knots, in the programme's time; two knots at one time: a step.
  struct Knot {
    double time, force;  // [s], [N]
  };
  std::vector<Knot> command{{0.0, 5.0}};
  std::optional<ForceSweep> sweep;  // in place of them; its start is the programme's
  bool judge_contact = false;       // the descent and the touch, instead of the programme
  double path_length = 0.0;         // along x, about the middle [m]
  double path_speed = 0.0;          // [m/s]
  std::optional<CanvasMotionSettings> motion;  // of the workpiece, its start is the programme's
  // Stiffness of workpiece and tip together, from the programme's start to its end, evenly in the
  // logarithm [N/m]. The damping keeps its ratio, ∝ √k.
  std::optional<Eigen::Vector2d> stiffness;
  std::optional<PushSettings> hand;  // on the pen, kHand after the programme's start

  // At a share of the programme [N/m].
  double stiffness_at(double share) const {
    return (*stiffness)[0] * std::pow((*stiffness)[1] / (*stiffness)[0], share);
  }
  // A workpiece other than the bowl that stands, or a hand: of this program's own world, or of a
  // rig that is told (force_rig.h).
  bool needs_rig() const { return shape != Workpiece::Shape::bowl || motion || stiffness || hand; }
};

std::vector<ForceCase> force_cases();
// Those named, in the benchmark's order; all for an empty list. Throws InputError for a name that
// is none.
std::vector<ForceCase> force_cases(const std::vector<std::string>& names);

// The command of a cycle to the controller, and the motion of the world.
struct ForceCommand {
  TipReference reference;  // with force and its rate while the pen should be down
  double asked = 0.0;      // the command [N]
  double press = 0.0;      // of it, for a controller that does not find the touch itself [N]
};

class ForceProgramme {
 public:
  static constexpr double kHover = 0.02;   // [m]
  static constexpr double kRest = 1.5;     // [s]
  static constexpr double kSettle = 1.0;   // [s]
  static constexpr double kLeave = 0.5;    // [s]
  static constexpr double kHand = 1.5;     // middle of a push, in the programme [s]
  static constexpr double kContact = 1.5;  // judged after a touch [s]

  // believed: the workpiece where the controllers take it to be. p_WE, n_W: tip and axis at the
  // start.
  ForceProgramme(const ForceCase& c, const Workpiece& believed, const Eigen::Vector3d& p_WE,
                 const Eigen::Vector3d& n_W);

  ForceCommand at(double t) const noexcept;
  double start() const { return start_; }              // of the programme [s]
  double end() const { return start_ + c_.duration; }  // [s]
  double leave() const { return end() + kLeave; }      // of the run [s]
  double descent() const { return descend_; }          // its start [s]
  // Share of the programme that is over, 0 to 1.
  double share(double t) const noexcept;

  // touch: the first [s].
  ForceQuestion question(double touch) const;

 private:
  struct Point {
    Eigen::Vector3d p, n;
  };
  Point point(double t) const noexcept;
  double asked(double t, double* rate) const noexcept;
  double along(double t) const noexcept;

  ForceCase c_;
  Workpiece believed_;
  Eigen::Vector3d p_0_, n_0_;
  double travel_, descend_, touch_, start_;  // ends of the travel, the rest, the descent; start [s]
};

}  // namespace impedraw
