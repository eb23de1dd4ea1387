// Reads what a resumed run needs from its log: the progress along the plan, and the measured
// contact force, which shows where the pen wrote.
#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

#include "impedraw/common/pose.h"

namespace impedraw {

struct ResumeRow {
  double time = 0.0;          // [s]
  double stroke_along = 0.0;  // in the drawing plane [m]; NaN if stroke < 0
  // measured force · the controller's estimated normal [N]; NaN without an estimate
  double f = 0.0;
  double push = 0.0;  // force asked for [N]
  int stroke = -1;
  int mode = 0;  // index into RunLogHeader::mode_names
};

struct ResumeLog {
  std::vector<ResumeRow> rows;     // one per step, 40 bytes each
  Eigen::VectorXd joint_position;  // of the last row [rad]; empty if there is none
  Pose canvas_pose;                // as last estimated; the identity for one that stands
};

// Reads the steps that RunLog::append_to would keep. Throws InputError naming the file if it is no
// log, and the dataset if one is missing.
ResumeLog read_resume_log(const std::filesystem::path& path);

}  // namespace impedraw
