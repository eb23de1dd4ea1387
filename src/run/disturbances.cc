#include "impedraw/run/disturbances.h"

#include <cmath>

namespace impedraw {

double time_at(const TipPath& path, double share) {
  const auto& strokes = path.strokes();
  return strokes.front().start + share * (strokes.back().end - strokes.front().start);
}

Disturbances::Disturbances(const Scenario& scenario, const TipPath& path) {
  if (path.strokes().empty()) return;
  // The plan begins once the canvas was watched.
  const double watched = scenario.perception.frames.enabled ? scenario.perception.watch : 0.0;
  for (const FaultSettings& fault : scenario.faults) {
    const double start = watched + time_at(path, fault.start);
    faults_.push_back({fault.kind, start, start + fault.duration});
  }
  for (const PushSettings& push : scenario.pushes) {
    const double middle = watched + time_at(path, push.middle);
    if (push.link.empty()) {
      pushes_.push_back({push, middle});
    } else if (push.direction_W.norm() > 1e-9) {
      link_pushes_.push_back({push.link, push.force * push.direction_W.normalized(),
                              middle - 0.5 * push.duration, middle + 0.5 * push.duration});
    }
  }
}

double Disturbances::since(FaultKind kind, double time) const noexcept {
  for (const TimedFault& fault : faults_)
    if (fault.kind == kind && time >= fault.start && time < fault.end) return time - fault.start;
  return -1.0;
}

Eigen::Vector3d Disturbances::push(double time, const Eigen::Vector3d& n_W) const noexcept {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  for (const auto& [push, middle] : pushes_) {
    if (std::abs(time - middle) > 0.5 * push.duration) continue;
    const Eigen::Vector3d along = push.direction_W - n_W * n_W.dot(push.direction_W);
    if (along.norm() > 1e-9) force += push.force * along.normalized();
    force += push.lift * n_W;
  }
  return force;
}

}  // namespace impedraw
