// Pictures of what was drawn, each as SVG in true millimetres and as PNG of the same look.
//
//   ink_top   seen along the drawing axis: up is +x, right is −y of the drawing frame; the canvas
//             with shading, height contours and outline beneath
//   ink_page  on the page, as the artwork had it: X to the right, Y down
//
// The target is a pale band, the ink a narrow line over it. Ink further than `highlight` from its
// target, and ink where the pen had to be up, have colours of their own and then a place in the
// legend. Lines are thinned: no point left out lies farther than 0.02 mm off, in a drawing of more
// than 150,000 points as much more as it takes.
#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/log/run_data.h"
#include "impedraw/metrics/ink_match.h"

namespace impedraw {

// Width of the ink's line: width + width_per_newton (f − nominal_force), kept within a quarter and
// three times `width`.
struct PenSettings {
  double width = 1.0;             // at the nominal force [mm]
  double width_per_newton = 0.0;  // [mm/N]; 0: the same throughout
  double nominal_force = 5.0;     // [N]
};

struct PictureSettings {
  std::string title{};  // upper left; empty: the log's attribute `scenario`
  PenSettings pen{};
  Eigen::Matrix3d R_WP = Eigen::Matrix3d::
      Identity();  // drawing frame: write_ink_top looks along −z_P; up is +x_P, right is −y_P
  double target_width = 2.6;  // [mm]
  double highlight = 0.5;     // [mm]
  int png_width = 1600;       // [px]
};

// Write `stem`.svg and `stem`.png. Throw std::runtime_error naming the file when it cannot be
// written.
void write_ink_top(const RunData& run, const InkMatch& drawn, const std::filesystem::path& stem,
                   const PictureSettings& settings = {});

// `to_page` takes a point on the canvas [m, W] to the page [mm]; `page` is what to show, the
// drawing's own extent where it is empty.
void write_ink_page(const RunData& run, const InkMatch& drawn,
                    const std::function<Eigen::Vector2d(const Eigen::Vector3d&)>& to_page,
                    const Eigen::AlignedBox2d& page, const std::filesystem::path& stem,
                    const PictureSettings& settings = {});

}  // namespace impedraw
