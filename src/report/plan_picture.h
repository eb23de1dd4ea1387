// Picture of a plan: the strokes on their canvas, seen along the drawing axis. Colours distinguish
// strokes that can be drawn from those that cannot.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

// A flat picture of artwork before it is drawn, as SVG and PNG: each pen's lines in its colour and
// their widths, the order, and in grey what is hidden.

// In millimetres as drawn: x to the right, y down.
struct PreviewLine {
  std::vector<Eigen::Vector2d> points;
  std::vector<double> width = {};  // at each point [mm]
  int pen = 0;
};

struct PreviewPen {
  std::string text;          // for the legend
  std::uint32_t colour = 0;  // 0xRRGGBB
  double width = 1.0;        // [mm]
};

struct PreviewPicture {
  std::string title, subtitle;
  std::vector<PreviewPen> pens;    // at least one
  std::vector<PreviewLine> lines;  // in the order in which they are drawn
  std::vector<PreviewLine> whole;  // with what is hidden; may be empty
};

// Ways of the pen in the air are dashed; up to 60 lines are numbered. Throws std::runtime_error
// naming the file if it cannot be written.
void write_preview(const PreviewPicture& preview, const std::filesystem::path& stem);

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
};

// Writes `stem`.svg and `stem`.png. Throws std::runtime_error naming the file if it cannot be
// written.
void write_plan(const PlanPicture& plan, const std::filesystem::path& stem);

}  // namespace impedraw
