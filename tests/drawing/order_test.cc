#include "impedraw/drawing/order.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <random>

#include <gtest/gtest.h>

namespace impedraw {
namespace {

using Eigen::Vector2d;

std::vector<Stroke> random_strokes(unsigned seed, int count, double page, double length) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> place(0, page), step(-length, length);
  std::vector<Stroke> strokes(count);
  for (Stroke& stroke : strokes) {
    const Vector2d p(place(random), place(random));
    stroke.points = {p};
    if (length > 0) stroke.points.push_back(p + Vector2d(step(random), step(random)));
  }
  return strokes;
}

double travel(const std::vector<Stroke>& strokes, const std::vector<Visit>& order) {
  return pen_up_length(in_order(strokes, order));
}

void expect_each_once(const std::vector<Stroke>& strokes, const std::vector<Visit>& order) {
  ASSERT_EQ(order.size(), strokes.size());
  std::vector<int> seen(strokes.size(), 0);
  for (const Visit& visit : order) ++seen.at(visit.stroke);
  EXPECT_EQ(seen, std::vector<int>(strokes.size(), 1));
}

// Every order, and for each of them every way round.
double shortest_of_all(const std::vector<Stroke>& strokes) {
  std::vector<int> permutation(strokes.size());
  std::iota(permutation.begin(), permutation.end(), 0);
  double shortest = std::numeric_limits<double>::infinity();
  do {
    for (unsigned ways = 0; ways < 1u << strokes.size(); ++ways) {
      double length = 0;
      for (std::size_t i = 1; i < strokes.size() && length < shortest; ++i) {
        const auto& a = strokes[permutation[i - 1]].points;
        const auto& b = strokes[permutation[i]].points;
        length +=
            ((ways >> i & 1 ? b.back() : b.front()) - (ways >> (i - 1) & 1 ? a.front() : a.back()))
                .norm();
      }
      shortest = std::min(shortest, length);
    }
  } while (std::next_permutation(permutation.begin(), permutation.end()));
  return shortest;
}

TEST(Order, FewStrokesAgainstEveryOrder) {
  int exact = 0;
  for (unsigned seed = 0; seed < 60; ++seed) {
    SCOPED_TRACE(seed);
    const auto strokes =
        random_strokes(seed, 1 + static_cast<int>(seed % 6), 100, seed % 2 ? 60 : 10);
    const auto order = shortest_order(strokes);
    expect_each_once(strokes, order);
    const double best = shortest_of_all(strokes);
    EXPECT_GE(travel(strokes, order), best - 1e-9);
    EXPECT_LE(travel(strokes, order), 1.35 * best + 1e-9);
    exact += travel(strokes, order) < best + 1e-9;
  }
  EXPECT_GE(exact, 50);
}

TEST(Order, DotsOnAGrid) {
  std::vector<Stroke> grid;
  for (int i = 0; i < 900; ++i) grid.push_back({{Vector2d(i % 30, i / 30)}, false, 0});
  std::shuffle(grid.begin(), grid.end(), std::mt19937(3));
  const auto order = shortest_order(grid);
  expect_each_once(grid, order);
  EXPECT_LE(travel(grid, order), 1.06 * 899);  // from neighbour to neighbour: 899
}

TEST(Order, FiveThousandStrokes) {
  // n random points in an area A have a shortest tour of 0.7124 √(n A) (1 + 0.33 / n) (Johnson,
  // McGeoch), and a border's worth more.
  const auto dots = random_strokes(1, 5000, 200, 0);
  const auto order = shortest_order(dots);
  expect_each_once(dots, order);
  const double shortest = 0.7124 * std::sqrt(5000.0) * 200;
  EXPECT_GT(travel(dots, order), 0.98 * shortest);
  EXPECT_LT(travel(dots, order), 1.10 * shortest);
  RecordProperty("above_shortest_percent",
                 std::to_string(100 * (travel(dots, order) / shortest - 1)));
}

TEST(Order, LayersStayInTheirOrder) {
  auto strokes = random_strokes(5, 60, 100, 5);
  for (std::size_t i = 0; i < strokes.size(); ++i) strokes[i].layer = static_cast<int>(i % 3);
  const auto ordered = in_order(strokes, shortest_order(strokes));
  for (std::size_t i = 1; i < ordered.size(); ++i)
    EXPECT_LE(ordered[i - 1].layer, ordered[i].layer);
  OrderSettings free;
  free.keep_layers = false;
  EXPECT_LT(travel(strokes, shortest_order(strokes, free)), pen_up_length(ordered));
}

TEST(Order, SameTwiceAndNothingAtAll) {
  const auto strokes = random_strokes(7, 300, 100, 5);
  const auto a = shortest_order(strokes), b = shortest_order(strokes);
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_TRUE(a[i].stroke == b[i].stroke && a[i].backwards == b[i].backwards);
  EXPECT_TRUE(shortest_order({}).empty());
  const std::vector<Stroke> same(40, Stroke{{Vector2d(1, 2)}, false, 0});
  expect_each_once(same, shortest_order(same));
}

TEST(Order, StatisticsOfStrokes) {
  const std::vector<Stroke> strokes{{{{0, 0}, {3, 4}, {3, 9}}}, {{{3, 12}}}, {{{6, 16}, {6, 15}}}};
  const StrokeStatistics found = stroke_statistics(strokes);
  EXPECT_EQ(found.strokes, 3u);
  EXPECT_EQ(found.points, 6u);
  EXPECT_DOUBLE_EQ(found.pen_down_mm, 5 + 5 + 1);
  EXPECT_DOUBLE_EQ(found.pen_up_mm, 3 + 5);
  EXPECT_EQ(stroke_statistics({}).strokes, 0u);
  EXPECT_EQ(stroke_statistics({}).pen_up_mm, 0);
}

}  // namespace
}  // namespace impedraw
