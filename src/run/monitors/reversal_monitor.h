// Notices a measured force that turns over from one reading to the next.
//
// Between two readings a contact's force changes by what the tip moves, and friction may turn over,
// but not both at once: what pushed the pen away does not draw it in. The force w of a reading is
// the last one's turned over if |w + w₋| < 0.2 |w − w₋| and |w₋| > 2.5 N. It is named if it stays
// so for two more readings, and the force along the pen's axis changed by as much: a tool whose
// weight cancels the push leaves friction alone, which may turn over.
#pragma once

#include <cmath>

#include <fmt/format.h>
#include <Eigen/Core>

#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/verdict.h"

namespace impedraw {

class ReversalMonitor {
 public:
  static constexpr double kAlike = 0.2, kStays = 0.5;  // shares of |w − w₋|, of |w₋|
  static constexpr double kLeast = 2.5;                // [N]
  static constexpr int kReadings = 3;

  Verdict judge(const Cycle& cycle) {
    const Eigen::Vector3d w = cycle.state->wrench.head<3>(), axis = cycle.arm.X_WE.R.col(2);
    const double along = axis.dot(cycle.F_ext.head<3>());
    if (!w.allFinite() || w == last_) return {};
    if (turned_ > 0 && (w + before_).norm() < kStays * before_.norm()) {
      ++turned_;
    } else if (last_.norm() > kLeast && (w + last_).norm() < kAlike * (w - last_).norm()) {
      turned_ = 1;
      before_ = last_;
      along_ = along;
    } else {
      turned_ = 0;
    }
    last_ = w;
    if (turned_ < kReadings || std::abs(along - along_) < before_.norm()) return {};
    return {Severity::damp, fmt::format("the measured wrench of {:.1f} N turned over within a "
                                        "reading: its sign is wrong at t = {:.3f} s",
                                        before_.norm(), cycle.next_run_time())};
  }

 private:
  Eigen::Vector3d last_ = Eigen::Vector3d::Zero(), before_ = last_;  // w₋; that was turned over [N]
  double along_ = 0.0;  // the pen's axis, before that [N]
  int turned_ = 0;      // readings
};

}  // namespace impedraw
