// The uppermost of a cloud's sheets over the drawing plane, which hides those below it.
//
//   top    the highest point in a cell of 8 mm
//   lid    closing of the points' heights: their maximum within kAround, then the minimum of that
//          within kAround − kBeyond
//
// A closing fills the gaps between the points of a sheet, and leaves its border where it is. Points
// are means over a voxel: the sheet ends up to a quarter of it further out, kBeyond.
#pragma once

#include <vector>

#include <Eigen/Core>

namespace impedraw {

class TopSheet {
 public:
  explicit TopSheet(const std::vector<Eigen::Vector3d>& points);  // in P

  // [m]; −infinity where the cloud has no point.
  double top(double x, double y) const;
  double lid(double x, double y) const;

  // Rise of a surface with normal n across a cell of `top` [m].
  static double rise(const Eigen::Vector3d& n);

 private:
  struct Cells {
    Cells(const std::vector<Eigen::Vector3d>& points, double side, double wider);
    // Visits the cells whose middles lie within `reach` of p, that of p itself always: its number,
    // or −1 beyond the grid.
    template <class Visit>
    void around(const Eigen::Vector2d& p, double reach, const Visit& visit) const;

    double side;  // [m]
    Eigen::Vector2d lower;
    int nx = 0, ny = 0;
    std::vector<double> highest;  // of the points of each cell, or near it [m]
  };
  Cells coarse_, dilated_;
};

}  // namespace impedraw
