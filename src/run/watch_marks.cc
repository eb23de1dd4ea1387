#include "impedraw/run/watch_marks.h"

#include "impedraw/perception/rigid_fit.h"
#include "impedraw/run/identify_joints.h"
#include "impedraw/run/posture_holder.h"

namespace impedraw {

using Eigen::Vector3d;

Vector3d centre_of(const FiducialSettings& fiducials) {
  Vector3d centre = Vector3d::Zero();
  for (const Fiducial& mark : fiducials.points)
    centre += mark.p_K / static_cast<double>(fiducials.points.size());
  return centre;
}

std::vector<StampedPoint> watch_marks(const ArmModel& arm, Driver& driver,
                                      const FiducialSettings& fiducials, double seconds) {
  constexpr double kLeastSpread = 5e-3;  // of marks beside a line [m]
  const Vector3d centre = centre_of(fiducials);
  const StartedDriver started(driver);
  PostureHolder holder(arm, driver, kMostSteps * driver.info().period);
  const JointVector zero = JointVector::Zero(arm.joints());
  std::vector<StampedPoint> seen;
  std::vector<Vector3d> p_K, p_W;
  while (holder.state().time < seconds) {
    for (CanvasFrame frame; driver.next_frame(&frame);) {
      p_K.clear();
      p_W.clear();
      for (const FoundMark& found : frame.found()) {
        if (found.mark < 0 || found.mark >= static_cast<int>(fiducials.points.size())) continue;
        p_K.push_back(fiducials.points[static_cast<std::size_t>(found.mark)].p_K);
        p_W.push_back(found.p_W);
      }
      if (p_K.size() < 3 || spread_beside_line(p_K) < kLeastSpread) continue;
      seen.push_back({frame.time, holder.state().time, fit_rigid(p_K, p_W).X_WK * centre});
    }
    holder.step(holder.start(), zero, zero);
  }
  return seen;
}

}  // namespace impedraw
