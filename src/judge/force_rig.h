// The orders of a rig under a driven arm: what the workpiece is and does in a run of the force
// benchmark. The rig is a simulator of somebody's own, or a machine that moves and loads a piece.
#pragma once

#include <string>

#include "impedraw/judge/force_case.h"
#include "impedraw/simulation/canvas_motion.h"

namespace impedraw {

// The motion of the case's workpiece: it stands until `start` [s], and where the case has none.
CanvasMotion motion_of(const ForceCase& c, const Workpiece& piece, double start);

// One run as JSON. Times count from the run's first torque; lists have a value each `period` from
// `start` on, and the last one holds.
//
//   run        number of the run, from 1; a new one tells the rig that the next torque begins it
//   case       name of the case
//   shape      bowl, flat or roof; middle: of it, in W [m] (Workpiece)
//   start      of the programme; end, leave: of it, and of the run [s]
//   period     [s]
//   poses      x, y, z [m], qw, qx, qy, qz of a frame that is W while the piece stands; or empty
//   stiffness  of workpiece and tip together [N/m]; or empty: as they are
//   hand       force on the tip, in W [N]; or empty
std::string rig_order(const ForceCase& c, const Workpiece& piece, const ForceProgramme& programme,
                      int number);

}  // namespace impedraw
