// A monitor's whole answer to a cycle. Of several the worst wins; reaction.h says what follows.
#pragma once

#include <string>

#include <Eigen/Core>

#include "impedraw/metrics/ending.h"

namespace impedraw {

// In order: what is less to be trusted than before stands further down.
enum class Severity {
  none,
  hold,   // the plan's clock stands
  leave,  // the path ends where the pen is
  lift,   // the pen goes up by the control law
  brake,  // the law has lost control: the motion is damped, then the pen goes up
  halt,   // the motion is damped, and the run ends where the pen is
  damp,   // the arm's state is not believed: its joints alone are damped, and the run ends
  lose,   // the arm cannot be driven: the run ends at once
};

struct Verdict {
  Severity severity = Severity::none;
  std::string cause{};  // one sentence without its full stop, with its time
  // The run's end; finished: the drawing may go on elsewhere.
  RunEnd end = RunEnd::stopped;
  // The pen's way up.
  enum class Rise {
    clear,     // along the normal of the canvas
    a_little,  // the same, before the rest of the drawing is planned anew
    let_go,    // in W, wherever the canvas goes
  } rise = Rise::clear;
  Eigen::Vector3d aside_W = Eigen::Vector3d::Zero();  // while it goes up `a_little` [m]
  double calm = 0.0;  // for `brake`: ends below this share of the joints' speed limits

  explicit operator bool() const noexcept { return severity != Severity::none; }
};

// The worse of two; the first if they are equally bad.
inline const Verdict& worse(const Verdict& a, const Verdict& b) noexcept {
  return a.severity < b.severity ? b : a;
}

}  // namespace impedraw
