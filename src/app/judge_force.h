// ./impedraw judge-force: the force benchmark (docs/force.md).
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "impedraw/experiment/draw_options.h"

namespace impedraw {

struct JudgeForceOptions {
  // sim, iiwa-lcm or franka: who moves the arm. Or the simulated arm itself: iiwa, an arm of
  // models/arms, or a URDF file.
  std::string arm = "sim";
  std::vector<std::string> controllers;  // empty: all
  std::vector<std::string> cases;        // empty: all
  int runs = 5;
  std::filesystem::path sensor;  // readings under the workpiece (SensorFile); empty: the arm's own
};

// Leaves force.json and force.html in options.out, by default runs/judge-force. Ctrl-C keeps what
// was run. Returns the exit code.
int judge_force(DrawOptions options, const JudgeForceOptions& judged);

}  // namespace impedraw
