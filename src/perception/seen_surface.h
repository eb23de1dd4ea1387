// The part of a surface that a cloud shows. It may go on below an overhang: no sheet that a surface
// has over each point of a plane tells where it ends.
//
//   seen(p)   ⇔   every place of the surface within `around` of p is within `gap` of a point
//
// The places are 16 on the tangent plane of the point nearest to p, in two rings.
#pragma once

#include "impedraw/perception/cloud.h"
#include "impedraw/perception/neighbours.h"

namespace impedraw {

class SeenSurface {
 public:
  // Keeps a reference to the cloud, whose normals must be there. Lengths in metres.
  SeenSurface(const PointCloud& cloud, double gap, double around);

  // May run in any number of threads.
  bool operator()(const Eigen::Vector3d& p_W) const;

 private:
  const PointCloud& cloud_;
  NeighbourTree tree_;
  double gap_, around_;
};

}  // namespace impedraw
