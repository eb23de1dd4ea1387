// Searches a surface for places where a drawing can be drawn well: quickly, and before the
// pre-flight, which has the last word.
//
// The surface is looked at once, over square cells. A cell costs
//
//   c = 10 b + 5 u + calm ((θ / 60°)² + (κ / 40 m⁻¹)² + r² + e) + near
//
//   b     1 where a cell has a trouble other than unreachable
//   u     what `unreachable` says of the cell's neighbourhood: 0, the arm is at ease there, to 1
//   θ, κ  slope and bend; e: 1 beside a cell with b = 1, 1/2 one cell further away
//   r     roughness, as a share of what is too rough to be drawn on
//   near  distance from where the drawing is wanted
//
// A placement costs the mean of c over the drawing's points, and a little for being turned. So
// places that no arm reaches stay candidates, behind all others.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <numbers>
#include <vector>

#include <Eigen/Geometry>

#include "impedraw/planning/surface_height.h"

namespace impedraw {

struct PlaceSearchSettings {
  Eigen::AlignedBox2d box;    // of the surface, in the drawing plane P [m]
  double cell = 4e-3;         // side of a cell; larger where the box has too many [m]
  double max_slope_deg = 75;  // as PreflightSettings
  double calm = 1.0;          // weight
  std::function<double(const SurfaceSample&)> unreachable;  // null: 0
  double reach_step = 12e-3;  // between the places for which it is asked [m]
  std::function<double(const Eigen::Vector3d& p_P)> near;   // null: 0
  std::function<double(const Eigen::Vector3d& p_P)> rough;  // null: 0
};

// The reason that a cell cannot be drawn on. Edge: broken, by a step that the slopes on both sides
// do not explain. Unreachable: u = 1. The planner's surface is missing where it is too rough, too.
enum class CellTrouble : std::uint8_t { none, missing, steep, edge, avoided, unreachable };

// The drawing, about its middle, is turned by turn_deg, scaled by `size` and put at `middle`.
struct PlaceFound {
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();  // P [m]
  double turn_deg = 0.0, size = 1.0;
  double cost = std::numeric_limits<double>::infinity();
  double share = 0.0;  // of the drawing's points that lie where b = 0

  Eigen::Vector2d operator()(const Eigen::Vector2d& p) const {  // of the drawing, to P
    return middle + size * (Eigen::Rotation2Dd(turn_deg * std::numbers::pi / 180.0) * p);
  }
};

class PlaceSearch {
 public:
  PlaceSearch(const SurfaceHeight& surface, const PlaceSearchSettings& settings);

  // Adds 5 u of an arm to the cells' costs.
  void add_effort(const std::function<double(const SurfaceSample&)>& unreachable);

  // A check failed at these points of P: drawings are to keep off them.
  void avoid(const std::vector<Eigen::Vector2d>& points);

  // The trouble that keeps a point of P from being drawn.
  CellTrouble trouble(const Eigen::Vector2d& p) const;

  // PlaceFound::share of any place.
  double share(const std::vector<Eigen::Vector2d>& drawing, const PlaceFound& place) const;

  // The cells, row by row from the box's lowest corner: how many of them along x and y, their side
  // [m], and of each the height of the surface in P [m], NaN where there is none.
  int columns() const { return nx_; }
  int rows() const { return ny_; }
  double side() const { return settings_.cell; }
  const Eigen::AlignedBox2d& box() const { return settings_.box; }
  const std::vector<float>& heights() const { return heights_; }

  // The cheapest place for the points of a drawing, spaced evenly along it, about its middle [m].
  // Not one of `tried`, nor within 8 mm and 20° of it. With an infinite cost if nothing is left.
  PlaceFound best(const std::vector<Eigen::Vector2d>& drawing, double size,
                  const std::vector<PlaceFound>& tried) const;

 private:
  std::size_t at(const Eigen::Vector2d& p) const;  // cells_.size(): outside
  bool is_bad(std::size_t cell) const { return cell == cells_.size() || cells_[cell].bad(); }
  void add_edges();

  struct Cell {
    double cost = 0.0;
    CellTrouble trouble = CellTrouble::missing;
    bool bad() const { return trouble != CellTrouble::none && trouble != CellTrouble::unreachable; }
  };
  PlaceSearchSettings settings_;
  int nx_ = 0, ny_ = 0;
  std::vector<Cell> cells_;
  std::vector<SurfaceHeight::Sample> seen_;
  std::vector<float> heights_;
};

}  // namespace impedraw
