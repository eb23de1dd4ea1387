// Sources of the planner's surface (planning/surface_height.h): the true canvas, or the cameras'
// cloud. In the drawing frame P, whose z axis points out of the drawing plane. Each keeps what it
// reads.
#pragma once

#include <functional>
#include <memory>

#include "impedraw/canvas/canvas.h"
#include "impedraw/common/pose.h"
#include "impedraw/perception/plan_surface.h"
#include "impedraw/planning/surface_height.h"

namespace impedraw {

// Looking along −z of P.
SurfaceHeight canvas_height(std::shared_ptr<const Canvas> canvas, const Pose& X_WP);

// Descends to the surface along z by secant steps on the estimated distance. Starts from the last
// result if that is near, else from the nearest column of the cloud. Returns nothing beyond the
// cloud's edge.
SurfaceHeight perceived_height(std::shared_ptr<const PlanSurface> surface, const Pose& X_WP);
SurfaceHeight perceived_height(std::shared_ptr<const SurfaceEstimator> surface, const Pose& X_WP);

// The surface as triangles in P, on a grid of 4 mm over the cloud's extent, or of its 500th part.
// A place without surface or near points of the cloud, or where the surface rises by more than four
// cells across one, is a hole.
TriangleMesh surface_grid(const SurfaceHeight& surface, const PointCloud& cloud, const Pose& X_PW);

// A level plane at the height z of P [m].
SurfaceHeight level_surface(double z);

// The surface, which tells while a step looks at it what share of about `expected` looks is done.
// Threads may share the looks; the one that made it alone tells.
SurfaceHeight counted(SurfaceHeight surface, double expected,
                      std::function<void(double share)> tell);

// For judging a drawing: of the true canvas's sheets that show their front, the one nearest to a
// planned height. Cameras that err alike plan millimetres beside the sheet that the pen then feels.
// Where none lies within kMisjudged, the planned point itself; where nothing is planned, the upper
// sheet.
inline constexpr double kJudged = 5e-3, kMisjudged = 12e-3;  // [m]
SurfaceHeight nearest_sheet(std::shared_ptr<const Canvas> canvas, const Pose& X_WP,
                            SurfaceHeight planned);

}  // namespace impedraw
