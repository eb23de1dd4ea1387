// Takes the steps of a quantum out of a depth image: flat terraces, whose normals are wrong and
// whose rims look like detail.
//
// A pixel measured z, and the surface lies within half a quantum of it, z ± q/2. Within that, the
// depth of each pixel goes to what the cubic through its neighbours along row and column says,
//   w(i) ← w(i) + λ ( (4 (w(i−s) + w(i+s)) − w(i−2s) − w(i+2s)) / 6 − w(i) ),   w = 1/z,
// in which a plane has no curvature, with strides s from 8 px to 1 px. Neighbours count where that
// cubic explains what the pixel measured, within q/2: not across an edge, nor where the surface
// bends more. Detail of less than half a quantum over less than about 16 px is lost with the steps.
#pragma once

#include "impedraw/perception/depth_camera.h"

namespace impedraw {

// quantum: step of the depth values [m].
void smooth_quanta(double quantum, DepthImage* image);

}  // namespace impedraw
