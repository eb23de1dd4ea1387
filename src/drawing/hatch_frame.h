// Coordinates of one set of hatch lines: x_H along them, y_H across.
//
// Straight, y_H is the distance on the page. Bent, it is a field whose level lines lie evenly on
// the surface, so that lines of constant y_H do: sampled, linear between its samples, and made to
// rise across the lines, so that every point of the page has one place in H, and back.
#pragma once

#include <functional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw {

// At a point of the page [mm], the distance from a line across the drawing, measured on the
// surface, in millimetres of the page. Of the direction on the page in which it is to rise.
using SurfaceDistance = std::function<double(const Eigen::Vector2d& page_mm)>;
using SurfaceDistances = std::function<SurfaceDistance(const Eigen::Vector2d& across)>;

class HatchFrame {
 public:
  // angle: of the lines [rad], counter-clockwise as seen. Bent over a box of the page by samples
  // `step` apart [mm], or straight without distances.
  HatchFrame(double angle, const SurfaceDistances& distances, const Eigen::AlignedBox2d& box,
             double step);

  Eigen::Vector2d to_H(const Eigen::Vector2d& page_mm) const;
  Eigen::Vector2d to_page(const Eigen::Vector2d& p_H) const;
  // In pieces that follow the bends. Straight ones keep their points.
  std::vector<Eigen::Vector2d> outline_to_H(std::vector<Eigen::Vector2d> page_mm) const;
  std::vector<Eigen::Vector2d> line_to_page(const std::vector<Eigen::Vector2d>& line_H) const;

 private:
  double sample(double x, std::size_t row) const;  // of the table, at x_H

  Eigen::Vector2d along_, across_;
  double step_ = 0.0;                              // [mm]; 0: straight
  Eigen::Vector2d low_ = Eigen::Vector2d::Zero();  // of the table, along and across [mm]
  std::size_t columns_ = 0, rows_ = 0;
  std::vector<double> table_;  // y_H [mm], column by column
};

}  // namespace impedraw
