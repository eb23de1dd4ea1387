// Page and picture of a plan. The page: the strokes and what of them cannot be drawn, the surface
// as the plan knows it, and the arm's posture along the path and at the worst places.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/metrics/pens.h"
#include "impedraw/page/plan_page.h"
#include "impedraw/planning/path/tip_path.h"
#include "impedraw/report/plan_picture.h"

namespace impedraw {

// The part of a drawing that each pen draws, and the flat picture of it (report/plan_picture.h).

// A pen's part of a path, with the ways to its strokes.
struct PenSum {
  std::size_t strokes = 0;
  double length = 0.0, time = 0.0;  // in the drawing plane [mm], [s]
};
std::vector<PenSum> sums_of(const DrawnPens& pens, const std::vector<PlacedStroke>& strokes,
                            const TipPath& path);

// "coast: 2 strokes, 310 mm, 12 s"
std::string pen_text(const DrawnPen& pen, const PenSum& sum);
// The same with its ink: "…; #204080, 0.6 mm wide at 3 N".
std::string ink_text(const DrawnPen& pen, const PenSum& sum);

// `pens`: one for each layer of the artwork, or one for all. Its subtitle is the size as drawn.
PreviewPicture preview_of(const Scenario& scenario, const SettingErrors& setting_errors,
                          const PlacedArtwork& artwork, const std::vector<DrawnPen>& pens,
                          const std::vector<PenSum>& sums);

// Postures follow each other as in the pre-flight, every 20 ms of the path's time, or in 6,000
// steps where it takes longer. `picture`: of the same plan; its lines and surface are taken over.
// `progress`: called now and then with the share done.
PlanPage page_of_plan(const PlannedDrawing& drawing, const PlanPicture& picture,
                      const std::function<void(double)>& progress = {});

// The picture of a plan: the surface as the plan knows it, the strokes, and where the
// surface is rougher than the cameras resolve.

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
