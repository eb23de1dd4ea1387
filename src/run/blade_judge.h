// Judges a blade by the truth: the errors of its heading, and the smear at its corners.
//
//   yaw_error     ∠(x_E, t) about the true normal, less tool.yaw; t: tangent of the promised line
//                 where the edge's middle is nearest to it, over ± kNear and not beyond a corner.
//                 Its mean square is over the way, so that turns on the spot do not count.
//   corner_smear  the farthest that an end of the edge is from the promised lines, seen along the
//                 drawing axis, within kAbout of a corner. With tool.yaw ≠ 0: the edge's middle.
// While it writes, on a line.
#pragma once

#include <vector>

#include "impedraw/run/tool_judge.h"

namespace impedraw {

class BladeJudge : public ToolJudge {
 public:
  static constexpr double kNear = 5e-4, kAbout = 3e-3;  // [m]

  explicit BladeJudge(const Experiment& experiment);
  void add(const LogRow& row) override;
  nlohmann::ordered_json results() const override;
  const char* file() const override { return kBladeFile; }

 private:
  struct Line {
    std::vector<Eigen::Vector2d> p;  // in P, without places that stand twice [m]
    std::vector<double> along;       // of each [m]
    std::vector<double> corners;     // along [m]
  };
  // Nearest place of the line to p, among those within `about` of `along`.
  static double nearest(const Line& line, const Eigen::Vector2d& p, double along, double about);
  static Eigen::Vector2d at(const Line& line, double along);

  Pose X_PW_;
  double yaw_, trail_, half_;  // of the edge [rad], [m], [m]
  std::vector<Line> lines_;
  int last_stroke_ = -1;
  double last_along_ = 0.0;
  double way_ = 0.0, square_ = 0.0, most_ = 0.0, smear_ = 0.0;  // [m], [rad² m], [rad], [m]
  int corners_ = 0;
};

}  // namespace impedraw
