// Stretches that crawl: of a line whose speed is limited by hand where it is known.
#include "impedraw/planning/preflight/crawl.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "impedraw/planning/path/tip_planner.h"
#include "planning/surfaces.h"

namespace impedraw {
namespace {

// No faster than `speed` where the spline's x is within [from, to].
SpanLimits slow_between(double from, double to, double speed) {
  return [=](const PathSpline& spline, std::vector<SpeedSpan>* spans) {
    for (std::size_t i = 0; i < spans->size(); ++i) {
      const double x = spline.at((spline.start(i) + spline.end(i)) / 2).p.x();
      if (x >= from && x <= to) (*spans)[i].speed = std::min((*spans)[i].speed, speed);
    }
  };
}

std::vector<CrawlingStretch> crawling(const std::vector<PlacedStroke>& strokes,
                                      const SpanLimits& limits, double least_speed = 10e-3,
                                      double draw_speed = 0.05) {
  PathSettings path;
  path.draw_speed = draw_speed;
  const TipPath slowed = plan_tip_path(strokes, surfaces::table, path, limits);
  const std::vector<std::size_t> slow = slow_strokes(slowed, least_speed);
  if (slow.empty()) return {};
  std::vector<PlacedStroke> suspects;
  for (const std::size_t s : slow) suspects.push_back(strokes[s]);
  return crawling_stretches(slowed, plan_tip_path(suspects, surfaces::table, path), slow,
                            least_speed);
}

TEST(Crawl, AStretchIsFoundWhereItIsAndItsNeighboursAreNot) {
  const PlacedStroke fast = surfaces::line({{0.5, 0.05}, {0.6, 0.05}}, 3),
                     slow = surfaces::line({{0.5, 0.0}, {0.6, 0.0}}, 4);
  const auto found = crawling({fast, slow}, [](const PathSpline& spline, auto* spans) {
    if (spline.at(0).p.y() < 0.02) slow_between(0.53, 0.56, 5e-3)(spline, spans);
  });
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].stroke, 1u);
  EXPECT_NEAR(found[0].from, 0.03, 2e-3);
  EXPECT_NEAR(found[0].to, 0.06, 2e-3);
  EXPECT_NEAR(found[0].speed, 5e-3, 1e-3);
  EXPECT_GT(found[0].slowest, found[0].from);
  EXPECT_LT(found[0].slowest, found[0].to);
  EXPECT_NEAR(found[0].p_W.x(), 0.5 + found[0].slowest, 1e-3);
}

// 2 mm at 12 mm/s: within a window of 10 mm they cost 0.1 s.
TEST(Crawl, AShortSlowPlaceIsNone) {
  EXPECT_TRUE(
      crawling({surfaces::line({{0.5, 0}, {0.6, 0}})}, slow_between(0.54, 0.542, 12e-3)).empty());
}

// A zigzag of 4 mm: its corners alone make it slower than asked.
TEST(Crawl, CornersAreTheLinesOwn) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < 12; ++i) points.push_back({0.5 + 2e-3 * i, i % 2 ? 4e-3 : 0.0});
  const PlacedStroke zigzag = surfaces::line(points);
  PathSettings slow_corners;
  slow_corners.draw_acceleration = 0.02;
  const TipPath path = plan_tip_path({zigzag}, surfaces::table, slow_corners);
  EXPECT_EQ(slow_strokes(path, 10e-3).size(), 1u);
  EXPECT_TRUE(crawling_stretches(path, path, {0}, 10e-3).empty());
  EXPECT_LT(path.mean_speed(), 10e-3);
}

// A line of 5.2 mm whose middle is slow enough for the whole, though no part of it is by itself
// once its ends are trimmed: stretches of 36 nm were left out, one in each plan.
TEST(Crawl, AStretchIsNoShorterThanAStep) {
  for (const double length : {3e-3, 5.2e-3, 9e-3, 12e-3, 30e-3}) {
    for (double slow = 0.2e-3; slow < length; slow *= 1.5) {
      for (const double speed : {1e-3, 4e-3, 7e-3, 9.5e-3}) {
        SCOPED_TRACE(testing::Message() << length << " m, " << slow << " m at " << speed << " m/s");
        const double begin = 0.5 + 0.4 * (length - slow);
        for (const CrawlingStretch& c : crawling({surfaces::line({{0.5, 0}, {0.5 + length, 0}})},
                                                 slow_between(begin, begin + slow, speed)))
          EXPECT_GT(c.to - c.from, 0.9 * std::min(kCrawlStep, length));
      }
    }
  }
}

TEST(Crawl, SlowAndUnhinderedIsNone) {
  EXPECT_TRUE(crawling({surfaces::line({{0.5, 0}, {0.6, 0}})}, {}, 10e-3, 5e-3).empty());
  EXPECT_TRUE(crawling({surfaces::line({{0.5, 0}, {0.5, 0}})}, {}).empty());  // a dot
}

}  // namespace
}  // namespace impedraw
