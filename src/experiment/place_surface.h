// Placement on the object, which stays where it is: moves, turns and, if asked, shrinks the drawing
// to where most of it can be drawn well.
//
// Candidates come from the perceived surface (planning/preflight/place_search.h). The best
// ones pass the whole pre-flight; where it fails, further candidates keep off.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "impedraw/experiment/scenario.h"
#include "impedraw/settings/yaml_read.h"

namespace impedraw {

struct SurfaceWish {
  // Where: "x,y,z" in W [m], or the side front (+x), back (−x), left (+y), right (−y) or top of the
  // object; empty: anywhere.
  std::string near;
  bool shrink = false;  // the drawing may get smaller, down to a quarter
};

struct SurfacePlace {
  Scenario scenario;                                  // as given but for drawing.placement
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();      // surface at the drawing's middle [m]
  double turn_deg = 0.0;                              // from the given one
  Eigen::Vector2d size_mm = Eigen::Vector2d::Zero();  // across and down the page, on the canvas
  double share = 0.0;                                 // of the drawing's length that can be drawn
  std::vector<std::string> assignments;               // settings that put it there again
};

// `progress`: fraction done, 0 to 1. Throws InputError like prepare(), for a wish that means
// nothing, and where no part of the drawing can be drawn anywhere.
SurfacePlace place_on_surface(const Scenario& scenario, const Places& places,
                              const SurfaceWish& wish,
                              const std::function<void(double)>& progress = {});

}  // namespace impedraw
