// Removes from a depth image what no surface explains: flying pixels and rims, grazing rays, and
// specks.
//
// Two neighbouring pixels lie on one surface if their depths differ by at most
//   step = max(pitch · tan 80°, 6 σ(z), two quanta),   pitch = z / f,
// a surface seen at less than 10° looks like a step. σ(z) = σ₁ z² is the camera's noise; where the
// capture does not tell σ₁, it is the median of |z(i−1) − 2 z(i) + z(i+1)| / (√6 · 0.6745 z²): a
// smooth surface leaves that at zero.
//   edge    a pixel within two pixels of a step: its depth may mix what lies on both sides
//   speck   a connected part of fewer than 60 pixels
#pragma once

#include "impedraw/capture/capture.h"
#include "impedraw/perception/depth_camera.h"

namespace impedraw {

// Takes the steps of a quantum out of a depth image: flat terraces, whose normals are wrong and
// whose rims look like detail.
//
// A pixel measured z, and the surface lies within half a quantum of it, z ± q/2. Within that, the
// depth of each pixel goes to what the cubic through its neighbours along row and column says,
//   w(i) ← w(i) + λ ( (4 (w(i−s) + w(i+s)) − w(i−2s) − w(i+2s)) / 6 − w(i) ),   w = 1/z,
// in which a plane has no curvature, with strides s from 8 px to 1 px. Neighbours count where that
// cubic explains what the pixel measured, within q/2: not across an edge, nor where the surface
// bends more. Detail of less than half a quantum over less than about 16 px is lost with the steps.

// quantum: step of the depth values [m].
void smooth_quanta(double quantum, DepthImage* image);

struct CleanedCounts {
  int measured = 0, edges = 0, specks = 0;  // [px]
  int kept() const { return measured - edges - specks; }
};

// Sets the depths of what is removed to NaN.
CleanedCounts clean(CapturedView* view);

// σ₁ of the view [m]: as it tells, or as its depths show.
double noise_at_1m(const CapturedView& view);

}  // namespace impedraw
