#include "planning/reach.h"

#include <limits>

#include <fmt/core.h>

#include "common/errors.h"

namespace impedraw {

void require_reach(const TipPath& path, double step, const ReachProblem& problem) {
  constexpr double kLook = 0.01;  // [s]; the tip moves far less than a step in it
  Eigen::Vector3d asked = Eigen::Vector3d::Constant(std::numeric_limits<double>::infinity());
  int last_stroke = -1;
  std::size_t next = 0;  // whose lead-in a travelling tip is on
  const auto ask = [&](double t) {
    const PathSample sample = path.at(t);
    const TipGoal& goal = sample.goal;
    const bool change = sample.stroke != last_stroke;
    last_stroke = sample.stroke;
    if (!change && (goal.p_WD - asked).norm() < step) return;
    asked = goal.p_WD;
    const std::string why = problem(goal.p_WD, goal.n_WD);
    if (why.empty()) return;
    while (next < path.strokes().size() && path.strokes()[next].end < t) ++next;
    const std::string where = sample.stroke >= 0                   ? fmt::format("stroke {}", sample.stroke)
                              : next < path.strokes().size()        ? fmt::format("the way to stroke {}", next)
                                                                    : std::string("the way back from the last stroke");
    throw InputError(fmt::format("{} leaves the arm's reach at ({:.4f}, {:.4f}, {:.4f}) m: {}", where,
                                 goal.p_WD.x(), goal.p_WD.y(), goal.p_WD.z(), why));
  };
  for (double t = 0; t < path.duration(); t += kLook) ask(t);
  ask(path.duration());
}

}  // namespace impedraw
