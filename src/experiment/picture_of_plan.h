// The picture of a plan: the surface as the plan knows it, the strokes, and where the
// surface is rougher than the cameras resolve.
#pragma once

#include "impedraw/experiment/experiment.h"
#include "impedraw/report/plan_picture.h"

namespace impedraw {

// Spacing of the points of a stroke, at most; corners that lie closer than the second are not told
// apart [m].
inline constexpr double kPictureSpacing = 2e-3, kPictureDetail = 1e-4;

// With cameras nothing in it is taken from the true canvas. `surface`: the planner's, in P.
PlanPicture picture_of_plan(const PlannedDrawing& drawing, const SurfaceHeight& surface);

// Lines that the pre-flight rejects, in the order of its findings, in P: on the surface, or as high
// as the finding where there is none.
std::vector<PlanLine> lines_of_findings(const PlannedDrawing& drawing,
                                        const SurfaceHeight& surface);

}  // namespace impedraw
