// Picture of a plan: the strokes on their canvas, seen along the drawing axis. Colours distinguish
// strokes that can be drawn from those that cannot.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "impedraw/report/preview_picture.h"

namespace impedraw {

struct PlanLine {
  std::vector<Eigen::Vector3d> points;  // in the drawing frame P [m]
  std::string problem;                  // why it cannot be drawn; empty if it can
  int pen = 0;                          // that draws it
};

struct PlanPicture {
  std::string title, subtitle;
  std::vector<PlanLine> lines;
  std::vector<PreviewPen> pens;                  // empty: one, in a colour of the picture's own
  std::vector<Eigen::Vector3d> canvas_vertices;  // P [m]; may be empty
  std::vector<Eigen::Vector3i> canvas_triangles;
  int png_width = 1400;
};

// Writes `stem`.svg and `stem`.png. Throws std::runtime_error naming the file if it cannot be
// written.
void write_plan(const PlanPicture& plan, const std::filesystem::path& stem);

}  // namespace impedraw
