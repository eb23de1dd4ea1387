// The pen that the arm holds.
#pragma once

#include <optional>

namespace impedraw {

struct HeldPen {
  int number = -1;      // its place in the scenario's `pens`; -1: that of `pen`
  double longer = 0.0;  // its tip beyond that of arm.urdf, along the pen, as far as is known [m]
  double radius = 0.0;  // of its tip [m]
  // Where the spot of `pen.check` is along its normal, in W; absent: not known yet [m].
  std::optional<double> spot;
};

}  // namespace impedraw
