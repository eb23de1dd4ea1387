// Pictures of the drawing, to be written as SVG in true millimetres and as PNG of the same look.
//
//   ink_top   seen along the drawing axis: up is +x, right is −y of the drawing frame. The canvas
//             lies beneath, with shading, height contours and outline.
//   ink_page  on the artwork's page: X to the right, Y down
//
// The target is a pale band, the ink a narrow line over it, of each pen's colour and width; what
// was left out is dashed. Edges of the mesh that are seen are outlined: holes, too. Through a hole
// the inside of a body is darker. Ink farther than `highlight` from its target, and ink where the
// pen must be up, have their own colours and legend entries. Lines are thinned with a tolerance of
// 0.02 mm, or more if more than 150,000 points would remain.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/ink/pen.h"
#include "impedraw/log/run_data.h"
#include "impedraw/metrics/ink_match.h"
#include "impedraw/metrics/pens.h"

namespace impedraw {

struct Relief;

// The mesh as background of ink_top, seen along −z of the drawing frame.
std::shared_ptr<const Relief> ink_relief(const std::vector<Eigen::Vector3d>& vertices,
                                         const std::vector<Eigen::Vector3i>& triangles,
                                         const Eigen::Matrix3d& R_WP);

struct PictureSettings {
  std::shared_ptr<const Relief> relief{};  // ink_relief() of the log's canvas; null: made here
  std::string title{};                     // upper left; empty: the log's attribute `scenario`
  PenSettings pen{};
  std::optional<DrawnPens> pens{};  // of layers, in place of `pen`
  Eigen::Matrix3d R_WP = Eigen::Matrix3d::
      Identity();  // drawing frame: ink_top looks along −z_P; up is +x_P, right is −y_P
  // The lines that were not to be drawn, on the canvas [m, W].
  std::vector<std::vector<Eigen::Vector3d>> left_out{};
  double target_width = 2.6;  // [mm]
  double highlight = 0.5;     // [mm]
};

// Writes `stem`.svg and `stem`.png. Holds copies of all that it draws. Throws std::runtime_error
// naming the file if it cannot be written.
struct Picture {
  std::function<void(const std::filesystem::path&)> write_svg, write_png;  // given the stem
  void write(const std::filesystem::path& stem) const {
    write_svg(stem);
    write_png(stem);
  }
};

Picture ink_top(const RunData& run, const InkMatch& drawn, const PictureSettings& settings = {});

// `to_page` maps a point on the canvas [m, W] to the page [mm]. `page` is the area shown; if empty,
// the extent of the drawing.
Picture ink_page(const RunData& run, const InkMatch& drawn,
                 const std::function<Eigen::Vector2d(const Eigen::Vector3d&)>& to_page,
                 const Eigen::AlignedBox2d& page, const PictureSettings& settings = {});

}  // namespace impedraw
