#include "impedraw/experiment/way_leans.h"

#include <set>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

TEST(WayLeans, TriesEachAtOneEndAndThenTakesTheFirst) {
  WayLeans leans;
  PlacedStroke stroke;
  leans.give(&stroke);
  EXPECT_EQ(stroke.lean_there, PlacedStroke::kWayLean);
  EXPECT_EQ(stroke.lean_off, PlacedStroke::kWayLean);
  std::set<double> tried{stroke.lean_there};
  while (leans.try_next(WayEnd::first)) {
    leans.give(&stroke);
    EXPECT_TRUE(tried.insert(stroke.lean_there).second);
    EXPECT_EQ(stroke.lean_off, PlacedStroke::kWayLean);
  }
  EXPECT_EQ(tried.size(), 4u);
  leans.give(&stroke);
  EXPECT_EQ(stroke.lean_there, PlacedStroke::kWayLean);
  EXPECT_FALSE(leans.try_next(WayEnd::first));
  EXPECT_TRUE(leans.try_next(WayEnd::last));
  leans.give(&stroke);
  EXPECT_EQ(stroke.lean_there, PlacedStroke::kWayLean);
  EXPECT_NE(stroke.lean_off, PlacedStroke::kWayLean);
}

}  // namespace
}  // namespace impedraw
