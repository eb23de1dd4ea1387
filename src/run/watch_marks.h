// The frames' record of the canvas's marks while the arm stands still, to find the cameras'
// latency by a motion that is known (perception/camera_latency.h).
#pragma once

#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/perception/camera_latency.h"
#include "impedraw/run/driver.h"

namespace impedraw {

// The marks' centre in each frame in which three and more of them were found. Throws
// std::runtime_error on a fault of the driver.
std::vector<StampedPoint> watch_marks(const ArmModel& arm, Driver& driver,
                                      const FiducialSettings& fiducials, double seconds);
// The centre that they tell, in K [m].
Eigen::Vector3d centre_of(const FiducialSettings& fiducials);

}  // namespace impedraw
