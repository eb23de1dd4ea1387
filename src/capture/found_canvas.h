// Finds in a cloud what a drawing lies on: leaves out the table, and objects beside it.
//
// The table is the largest plane, of at least 15 % of the cloud, that faces the pen or W's z within
// 45°, that nothing lies behind, and that something stands on; found by sampling triples of points
// (RANSAC) and refined by least squares. It stays where the drawing's middle lies on it. What is
// left falls into connected parts, with gaps of 1 cm or more between them. A part stays if it holds
// at least a tenth of the upper surface within `radius` of the drawing's middle; if none does, the
// largest one. Of a drawing that looks for its place on the object, the middle says nothing: the
// table goes if a part that stands on it could bear the drawing, and the largest part stays with
// those above or beneath it.
//
// Source: M. Fischler, R. Bolles, "Random sample consensus", CACM 1981.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "impedraw/common/pose.h"
#include "impedraw/perception/cloud.h"

namespace impedraw {

struct FoundCanvas {
  PointCloud canvas, beside;       // beside: what was left out
  std::vector<std::string> notes;  // what was found, and removed of each view, one line each
};

// The place of the drawing, in its frame P [m].
struct DrawnAbout {
  Pose X_WP;
  Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  double radius = 0.15;
  bool placed = true;  // false: its place on the object is yet to be found
};

// views: names of the cloud's cameras; may be empty. The same for the same input.
FoundCanvas find_canvas(const PointCloud& cloud, const DrawnAbout& drawing,
                        const std::vector<std::string>& views = {});

}  // namespace impedraw
