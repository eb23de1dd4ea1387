// Strokes whose ends meet are joined, and all are ordered for short travel in the air, unless this
// is disabled. Nothing else about them changes.
#include <algorithm>
#include <array>

#include "drawn_scenario.h"
#include "impedraw/drawing/artwork_file.h"
#include "impedraw/drawing/joined.h"
#include "impedraw/drawing/order.h"

namespace impedraw {
namespace {

Prepared koi(bool keep_order) {
  DrawOptions options;
  options.svg = "artwork/koi.svg";
  options.keep_order = keep_order;
  return prepare(resolve(options));
}

// The ends of every stroke, regardless of direction.
std::vector<std::array<double, 4>> ends(const std::vector<Stroke>& strokes) {
  std::vector<std::array<double, 4>> all;
  for (const Stroke& s : strokes) {
    Eigen::Vector2d a = s.points.front(), b = s.points.back();
    if (std::pair(b.x(), b.y()) < std::pair(a.x(), a.y())) std::swap(a, b);
    all.push_back({a.x(), a.y(), b.x(), b.y()});
  }
  std::sort(all.begin(), all.end());
  return all;
}

TEST(StrokeOrder, ShortensTheWayInTheAirAndKeepsTheStrokes) {
  const Artwork file = read_artwork("artwork/koi.svg");
  const Prepared kept = koi(true), ordered = koi(false);
  EXPECT_NEAR(pen_up_length(kept.artwork.shape.drawn.strokes), pen_up_length(file.strokes), 1e-9);
  EXPECT_LT(pen_up_length(ordered.artwork.shape.drawn.strokes), 0.9 * pen_up_length(file.strokes));
  ASSERT_EQ(ends(ordered.artwork.shape.drawn.strokes), ends(joined(file.strokes)));
  EXPECT_EQ(ends(kept.artwork.shape.drawn.strokes), ends(file.strokes));
  EXPECT_LT(ordered.plan.path.duration(), kept.plan.path.duration());
  ASSERT_EQ(ordered.artwork.shape.target().strokes.size(),
            ordered.artwork.shape.drawn.strokes.size());
  for (std::size_t i = 0; i < ordered.artwork.shape.drawn.strokes.size(); ++i)
    EXPECT_EQ(ordered.artwork.shape.target().strokes[i].points.front(),
              ordered.artwork.shape.drawn.strokes[i].points.front())
        << "the target goes with it";
}

}  // namespace
}  // namespace impedraw
