// A coordinate of a moving body and its derivatives.
#pragma once

namespace impedraw {

struct AxisState {
  double x = 0.0, v = 0.0, a = 0.0;
};

}  // namespace impedraw
