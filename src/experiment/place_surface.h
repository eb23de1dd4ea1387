// Placement on the object, which stays where it is: moves, turns and, if asked, shrinks the
// drawing to where most of it can be drawn well.
//
// Candidates come from the perceived surface (planning/preflight/place_search.h). The best ones
// pass the whole pre-flight; where it fails, further candidates keep off. The best one is moved a
// little where that lets more be drawn. Where the level drawing plane has no place for the whole,
// planes that lean by 35° or 65° to one of eight sides are tried: an object's sides are drawn on,
// too; then the level one again with the start above the place, and leans of 20°, 50° and 90°. In
// the best of them the pen leans off the surface's normal by up to 20°, then 30° (path.lean), where
// that of the scenario does not: joints meet their ends later. The best places of all are moved,
// turned and leant as long as more can be drawn. A plane that the scenario tilts stays.
#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/experiment/scenario.h"
#include "impedraw/planning/preflight/place_search.h"
#include "impedraw/settings/yaml_read.h"

namespace impedraw {

struct SurfaceWish {
  // The place: "x,y,z" in W [m], or the side front (+x), back (−x), left (+y), right (−y) or top of
  // the object; empty: anywhere.
  std::string near{};
  bool shrink = false;  // the drawing may get smaller, down to a quarter
  // Share of the drawing from which on a place is of use: where the quick look promises clearly
  // less, nothing is planned.
  double least = 0.0;
};

// Share of a drawing's length: where more of it can be drawn, no better place is looked for.
inline constexpr double kNearlyAll = 0.98;
inline constexpr double kRefinable = 0.7;  // from here on the drawing plane is leant further

struct SurfacePlace {
  // as given but for drawing.placement and, where it was level, drawing.tilt and path.lean
  Scenario scenario;
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();      // surface at the drawing's middle [m]
  double turn_deg = 0.0;                              // from the given one
  Eigen::Vector2d size_mm = Eigen::Vector2d::Zero();  // across and down the page, on the canvas
  double share = 0.0;                                 // of the drawing's length that can be drawn
  PlaceFound place;                                   // in the drawing plane
  std::vector<std::string> assignments;               // settings that put it there again
  std::shared_ptr<class PlaceBench> bench;            // on which it was found
};

// drawing.tilt of a plane with the normal z. No yaw: the search turns the drawing. Without negative
// zeros, which would be printed.
Eigen::Vector3d tilt_towards(const Eigen::Vector3d& z);

// A surface that was looked at once, on which the drawing is tried at place after place.
class PlaceBench {
 public:
  // Throws InputError like prepare(), and for a wish that means nothing.
  // `other`: one on the same object, whose scene it shares: only drawing plane and start differ.
  PlaceBench(const Scenario& scenario, const Places& places, const SurfaceWish& wish = {},
             const PlaceBench* other = nullptr);
  ~PlaceBench();

  const Scenario& scenario() const;  // as given
  const Pose& X_WP() const;
  const PlaceSearch& search() const;
  // Knowledge of the object, in W: the mesh, if the cameras are simulated, else null; points.
  const TriangleMesh* known_mesh() const;
  std::vector<Eigen::Vector3d> cloud() const;
  // The strokes as they are given, about the middle of their box [m].
  const std::vector<std::vector<Eigen::Vector2d>>& strokes() const;
  PlaceFound given() const;

  // Takes some milliseconds: the pre-flight has the last word.
  struct QuickCheck {
    double share = 0.0;                  // of the drawing's length that can be drawn
    std::map<CellTrouble, double> lost;  // length on the page's scale [m]
    double length = 0.0, time = 0.0;  // of all of it [m]; drawing and about a second a stroke [s]
    Eigen::Vector2d size_mm = Eigen::Vector2d::Zero();
  };
  QuickCheck check(const PlaceFound& place) const;

  // The drawing there: as a scenario, and what of it the pre-flight lets pass, from 0 to 1.
  Scenario scenario_at(const PlaceFound& place) const;
  double share_of_plan(const PlaceFound& place) const;

  // The best place in this drawing plane; with a share of 0 if there is none. What it was asked
  // before costs no time again. `behind`: gets others that were tried, from kRefinable on.
  SurfacePlace best_place(const SurfaceWish& wish, const std::function<void(double)>& progress,
                          std::vector<SurfacePlace>* behind = nullptr);
  // Without a bench, as best_place(); with a share of 0 where a quick look, if there was one,
  // promises clearly less than `least`.
  SurfacePlace at(const PlaceFound& place, double least = 0.0) const;
  // The scenario with other drawing planes, which lean so, and starts of the arm before them, which
  // promise more than what best_place() left of this one; the best first, none without a cloud.
  std::vector<Scenario> others(const SurfaceWish& wish, const std::vector<double>& leans_deg) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

// `progress`: fraction done, 0 to 1. Throws InputError like prepare(), for a wish that means
// nothing, and where no part of the drawing can be drawn anywhere.
SurfacePlace place_on_surface(const Scenario& scenario, const Places& places,
                              const SurfaceWish& wish,
                              const std::function<void(double)>& progress = {});

// The size at which the whole can be drawn in the same drawing plane, where less than kNearlyAll
// can at the place that was found [mm]; nullopt if there is none, or the wish lets it shrink
// anyway.
std::optional<Eigen::Vector2d> whole_size_mm(const SurfaceWish& wish, const SurfacePlace& found,
                                             const std::function<void(double)>& progress);

}  // namespace impedraw
