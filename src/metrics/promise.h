// What the pre-flight promised of a drawing, as the log keeps it: the root attribute `promise` of
// run.h5, JSON. Without it (older logs), metrics that need it are null.
#pragma once

#include <map>
#include <optional>
#include <string>

#include <Eigen/Core>

namespace impedraw {

struct Promise {
  // Lengths are in the drawing plane [m]. Of the artwork, hatched and dashed: `asked`. Of the parts
  // that are drawn: `promised`. Of those that the pre-flight names with a reason: `undrawable`.
  // Neither promised nor named: `unnamed`, 0 but for rounding or a fault.
  double asked = 0.0, promised = 0.0, undrawable = 0.0, unnamed = 0.0;
  // What a planner that knows the true canvas could draw: what lies above it, where it leans by
  // less than 75°, less what the arm cannot reach. None if wrapped, and in older logs.
  std::optional<double> reachable;
  std::map<std::string, int> problems;    // findings by problem: {"too_steep", 3}
  std::map<std::string, double> lengths;  // of them; empty in older logs [m]
  double slope = 0.0;                     // steepest under the target, against the level [rad]
  double time = 0.0;                      // of the planned path [s]
  bool asks_ink = true;                   // false: a dry run
  Eigen::Vector3d axis_W = Eigen::Vector3d::UnitZ();  // the drawing axis, out of the canvas
};

inline constexpr const char* kPromiseAttribute = "promise";

std::string promise_text(const Promise& promise);
std::optional<Promise> read_promise(const std::map<std::string, std::string>& attributes);

}  // namespace impedraw
