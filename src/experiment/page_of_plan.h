// The page of a plan: the strokes and what of them cannot be drawn, the surface as the
// plan knows it, and the arm's posture along the path and at the worst places.
#pragma once

#include <functional>

#include "impedraw/experiment/experiment.h"
#include "impedraw/page/plan_page.h"
#include "impedraw/report/plan_picture.h"

namespace impedraw {

// Postures follow each other as in the pre-flight, every 20 ms of the path's time, or in 6,000
// steps where it takes longer. `picture`: of the same plan; its lines and surface are taken over.
// `progress`: called now and then with the share done.
PlanPage page_of_plan(const PlannedDrawing& drawing, const PlanPicture& picture,
                      const std::function<void(double)>& progress = {});

}  // namespace impedraw
