// Identification of an arm's joints by small motions in the air: the delay of its loop, and
// friction. The arm moves by joint stiffness plus modelled gravity about the posture in which it
// stands.
#pragma once

#include <vector>

#include "impedraw/arm/arm_model.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/perception/camera_latency.h"
#include "impedraw/run/driver.h"
#include "impedraw/sensing/tool_identification.h"

namespace impedraw {

struct LoopDelay {
  double delay = 0.0;      // from a state to the torque that answers it acting, in whole steps [s]
  double explained = 0.0;  // share of the last joint's acceleration that the torque then explains
};

// Shakes the last joint by torques of random sign, as small as move it and at most a tenth of its
// limit, and finds the delay with which its velocity answers. Throws std::runtime_error if the arm
// does not answer (the share is below 0.5), or the delay would be kMostSteps.
inline constexpr int kMostSteps = 20;
LoopDelay identify_delay(const ArmModel& arm, Driver& driver, double seconds = 2.0);

struct JointFriction {
  double coulomb = 0.0;   // [Nm]
  double viscous = 0.0;   // [Nm s/rad]
  double residual = 0.0;  // RMS of the torque that the law leaves [Nm]
  // About the joint's axis beyond the model's, of a rotor above all, and its standard deviation
  double inertia = 0.0, inertia_error = 0.0;  // [kg m²]
};

// Sweeps each joint slowly to and fro, at two speeds, and shakes it at 2 and 3.5 Hz, with the
// others held.
//
// Law       τ = c sign(v) + b v + I a + k (q − q_0) + e      beyond the modelled torque
// Least squares over all samples in which the joint moves, with v and a from positions alone; k and
// e take what the model misses. delay: of the loop, which bounds the stiffness of light joints
// [s]. Throws std::runtime_error that names the joint if it hardly moves, if a sweep finds no
// room, or if its friction would be negative beyond the residual or above a third of its torque
// limit.
std::vector<JointFriction> identify_friction(const ArmModel& arm, Driver& driver, double delay);

// Identifies mass and centre of mass of the tool on the wrench sensor. The arm holds the tool still
// in several orientations in the air.
struct ToolCalibration {
  ToolIdentification found;
  std::vector<StaticReading> poses;
};

// Moves the driver's arm from the experiment's start posture through `poses` orientations, by
// turning its last three joints about the start posture. Rests `rest` seconds [s] in each and
// averages the reading over the last half. Joint stiffness plus modelled gravity hold the arm: it
// must come to rest, but where matters little. Throws InputError if the experiment has no sensor or
// the joint ranges leave no room.
ToolCalibration calibrate_tool(const Experiment& experiment, Driver& driver, int poses = 8,
                               double rest = 1.0);

// The frames' record of the canvas's marks while the arm stands still, to find the cameras'
// latency by a motion that is known (perception/camera_latency.h).

// The marks' centre in each frame in which three and more of them were found. Throws
// std::runtime_error on a fault of the driver.
std::vector<StampedPoint> watch_marks(const ArmModel& arm, Driver& driver,
                                      const FiducialSettings& fiducials, double seconds);
// The centre that they tell, in K [m].
Eigen::Vector3d centre_of(const FiducialSettings& fiducials);

}  // namespace impedraw
