// The picture of runs compared: a column for each, on equal axes, with the drawn and the desired
// line seen from above, the normal force, and the tilt.
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "impedraw/report/decimate.h"

namespace impedraw {

struct PicturedRun {
  std::string name;
  std::vector<Line2d> target, ink;                 // from above, (−y, x) [mm]
  Envelope force, push, tilt, normal_error;        // [N], [deg]
  std::vector<std::pair<double, double>> strokes;  // [s]
};

PicturedRun pictured_run(const std::string& name, const RunData& run, const InkMatch& drawn);

// Writes `stem`.svg and `stem`.png. Throws std::runtime_error naming the file if it cannot be
// written.
void write_comparison_picture(const std::string& title, const std::vector<PicturedRun>& runs,
                              const std::filesystem::path& stem);

}  // namespace impedraw
