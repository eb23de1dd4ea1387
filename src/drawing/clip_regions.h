// The regions that clip paths and masks show.
#pragma once

#include <map>
#include <vector>

#include <Eigen/Core>

#include "impedraw/drawing/regions.h"

namespace impedraw {

// A clip shows the union of its shapes. A mask is painted with its shapes in order, over black, and
// shows what is lighter than one half.
struct ClipShape {
  Area area = {};
  int clip = -1;
  double value = 1, alpha = 1;  // of a mask: luminance and opacity, 0 to 1
};
struct Clip {
  int parent = -1;  // cuts this clip, and stands before it; −1: none
  bool mask = false;
  std::vector<ClipShape> shapes = {};  // their clips stand behind this clip
};

// The regions of clips, each found once. InputError: outlines cross too often.
class ClipRegions {
 public:
  struct Shown {
    Outlines region;
    RegionIndex index;
  };

  ClipRegions(const std::vector<Clip>& clips, const RegionMath& math)
      : clips_(clips), math_(math) {}

  // The region that the clip and its parents show.
  const Shown& of(int clip);
  // The share that a place lets through, from 0 to 1: for a mask, its luminance there.
  double light(int clip, const Eigen::Vector2d& p);
  // Drops the regions if they are many: what of() returned is no longer valid.
  void forget();

 private:
  const std::vector<Clip>& clips_;
  const RegionMath& math_;
  std::map<int, Shown> regions_;
  std::map<int, std::vector<RegionIndex>> shapes_;
};

}  // namespace impedraw
