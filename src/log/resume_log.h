// What a run that goes on must know of the rows already in its log: where the plan was, and whether
// the pen wrote, by the arm's own senses.
#pragma once

#include <filesystem>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

struct ResumeRow {
  double time = 0.0;          // [s]
  double stroke_along = 0.0;  // in the drawing plane [m]; NaN where stroke < 0
  // measured wrench's force · the controller's own normal [N]; NaN where it had no estimate
  double f = 0.0;
  int stroke = -1;
  int mode = 0;  // index into RunLogHeader::mode_names
};

struct ResumeLog {
  std::vector<ResumeRow> rows;     // one a step, 32 bytes each
  Eigen::VectorXd joint_position;  // of the last row [rad]; empty where there is none
};

// Every step as RunLog::append_to finds them. Throws InputError naming the file when it is no log,
// and the dataset that it lacks.
ResumeLog read_resume_log(const std::filesystem::path& path);

}  // namespace impedraw
