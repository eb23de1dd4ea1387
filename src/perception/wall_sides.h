// A thin wall, as a mug's or a lampshade's, that is seen from both sides.
//
// Its surfaces lie in the same cubes and patches: their points are averaged, and the normal looks
// to the side of whichever camera saw the nearest one. So one side of such a wall is left. Each
// view's surface has normals towards its own camera; where those of two views are contrary to each
// other, they are two sides. The one that most pixels nearby saw is left, those of a side that
// faces up or outwards counting for more: the pen gets there, and hardly into a vessel.
#pragma once

#include "impedraw/perception/cloud.h"
#include "impedraw/perception/normals.h"

namespace impedraw {

inline constexpr double kThinWall = 1.5;  // in cubes

// The cloud without the points of other sides, or as it is if those are few. voxel: side of the
// cubes [m].
PointCloud without_far_sides(const PointCloud& seen, double voxel, const NormalSettings& settings);

}  // namespace impedraw
