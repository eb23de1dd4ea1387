#include "impedraw/planning/stroke_part.h"

#include <random>

#include <gtest/gtest.h>

#include "impedraw/drawing/polyline.h"
#include "impedraw/planning/path/tip_planner.h"
#include "impedraw/planning/stroke_ruler.h"
#include "planning/surfaces.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

PlacedStroke random_stroke(std::mt19937& random, int number) {
  std::uniform_real_distribution<double> step(-0.02, 0.02);
  PlacedStroke stroke{{}, {}, number};
  Vector2d p(0.6, 0.0);
  for (int i = 0; i < 12; ++i) {
    stroke.p_P.push_back(p);
    stroke.page.push_back(1e3 * p);
    p += Vector2d(step(random), step(random));
  }
  return stroke;
}

// Against a walk from the first point on, as the length is defined.
TEST(StrokePart, TheRulerFindsWhatAWalkFinds) {
  std::mt19937 random(12);
  PlacedStroke stroke = random_stroke(random, 3);
  stroke.p_P.insert(stroke.p_P.begin() + 4, stroke.p_P[4]);  // a point twice
  stroke.page.insert(stroke.page.begin() + 4, stroke.page[4]);
  stroke.start = 0.05;
  const StrokeRuler ruler(stroke);
  EXPECT_EQ(ruler.length(), plane_length(stroke));
  for (int i = -2; i <= 202; ++i) {
    const double along = stroke.start + ruler.length() * i / 200;
    double left = std::max(0.0, along - stroke.start);
    Vector2d at = stroke.p_P.back();
    for (std::size_t k = 1; k < stroke.p_P.size(); ++k) {
      const double step = (stroke.p_P[k] - stroke.p_P[k - 1]).norm();
      if (step > 0 && left <= step) {
        at = stroke.p_P[k - 1] + left / step * (stroke.p_P[k] - stroke.p_P[k - 1]);
        break;
      }
      left -= step;
    }
    EXPECT_LT((ruler.at(along).p_P - at).norm(), 1e-12) << along;
    EXPECT_LT((ruler.at(along).page - 1e3 * at).norm(), 1e-9) << along;
  }
  const PlacedStroke part = ruler.part(stroke.start, stroke.start + ruler.length());
  EXPECT_NEAR(plane_length(part), ruler.length(), 1e-12);
  EXPECT_EQ(part.number, 3);
}

// Against a search over closely spaced places.
TEST(StrokePart, NearestPlaceIsWhereTheStrokeComesClosest) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> aside(-0.03, 0.03);
  for (int round = 0; round < 50; ++round) {
    SCOPED_TRACE("seed 11, round " + std::to_string(round));
    const PlacedStroke whole = random_stroke(random, 0);
    const double length = plane_length(whole);
    const PlacedStroke stroke = part_of(whole, 0.2 * length, 0.9 * length);
    const Vector2d p = whole.p_P[6] + Vector2d(aside(random), aside(random));
    double least = 1.0;
    for (int i = 0; i <= 20000; ++i) {
      const double along = (0.2 + 0.7 * i / 20000) * length;
      least = std::min(least, (place_on(stroke, along).p_P - p).norm());
    }
    const double along = nearest_place(stroke, p);
    EXPECT_GE(along, stroke.start - 1e-12);
    EXPECT_LE(along, 0.9 * length + 1e-12);
    EXPECT_NEAR((place_on(stroke, along).p_P - p).norm(), least, 1e-5);
    EXPECT_LE((place_on(stroke, along).p_P - p).norm(), least + 1e-12);
  }
  EXPECT_EQ(nearest_place({{Vector2d(1, 2)}, {Vector2d(0, 0)}, 0}, Vector2d(5, 5)), 0.0) << "a dot";
}

TEST(StrokePart, PartsOfAPartAreThoseOfTheWhole) {
  std::mt19937 random(7);
  for (int round = 0; round < 200; ++round) {
    SCOPED_TRACE("seed 7, round " + std::to_string(round));
    const PlacedStroke whole = random_stroke(random, 3);
    const double length = plane_length(whole);
    std::uniform_real_distribution<double> place(0, length);
    double a = place(random), d = place(random);
    if (a > d) std::swap(a, d);
    const double b = a + 0.3 * (d - a), c = a + 0.8 * (d - a);
    const PlacedStroke outer = part_of(whole, a, d), inner = part_of(outer, b, c);
    EXPECT_NEAR(plane_length(outer), d - a, 1e-12);
    EXPECT_NEAR(plane_length(inner), c - b, 1e-12);
    EXPECT_EQ(inner.number, 3);
    EXPECT_NEAR(inner.start, b, 1e-15);
    EXPECT_NEAR((inner.p_P.front() - place_on(whole, b).p_P).norm(), 0, 1e-12);
    EXPECT_NEAR((inner.p_P.back() - place_on(whole, c).p_P).norm(), 0, 1e-12);
    for (std::size_t i = 0; i < inner.p_P.size(); ++i) {
      EXPECT_NEAR(distance(inner.p_P[i], whole.p_P, 0, whole.p_P.size() - 1), 0, 1e-12);
      EXPECT_NEAR((inner.page[i] - 1e3 * inner.p_P[i]).norm(), 0, 1e-9);
    }
  }
}

TEST(StrokePart, BeyondItsEndsAStrokeIsCutOff) {
  const PlacedStroke line = surfaces::line({{0.6, 0}, {0.7, 0}});
  EXPECT_EQ(part_of(line, -1, 1).p_P, line.p_P);
  const PlacedStroke dot = part_of(line, 0.2, 0.3);
  ASSERT_EQ(dot.p_P.size(), 1u);
  EXPECT_EQ(dot.p_P[0], Vector2d(0.7, 0));
}

// Against a table of covered millionths.
TEST(StrokePart, TheRestAndThePartsMakeTheWhole) {
  std::mt19937 random(11);
  for (int round = 0; round < 100; ++round) {
    SCOPED_TRACE("seed 11, round " + std::to_string(round));
    const std::vector<PlacedStroke> strokes{surfaces::line({{0, 0}, {1, 0}}),
                                            surfaces::line({{0, 1}, {1, 1}}, 1)};
    std::uniform_int_distribution<int> many(0, 6), at(0, 1000);
    std::vector<StrokePart> parts;
    std::vector<std::vector<bool>> covered(2, std::vector<bool>(1000, false));
    for (int n = many(random); n > 0; --n) {
      const int stroke = at(random) % 2;
      int from = at(random), to = at(random);
      if (from > to) std::swap(from, to);
      parts.push_back({stroke, from / 1000.0, to / 1000.0});
      for (int k = from; k < to; ++k) covered[stroke][k] = true;
    }
    std::vector<std::vector<bool>> left(2, std::vector<bool>(1000, false));
    for (const StrokePart& rest : rest_of(strokes, parts))
      for (int k = 0; k < 1000; ++k)
        if (k / 1000.0 + 5e-4 > rest.from && k / 1000.0 + 5e-4 < rest.to)
          left[rest.stroke][k] = true;
    for (int s = 0; s < 2; ++s)
      for (int k = 0; k < 1000; ++k)
        ASSERT_NE(covered[s][k], left[s][k]) << "stroke " << s << " at " << k;
  }
}

TEST(StrokePart, AShortGapIsNoneButAStrokeNeverTouchedIs) {
  const std::vector<PlacedStroke> strokes{surfaces::line({{0, 0}, {1, 0}}),
                                          surfaces::line({{0, 1}}, 1)};
  const auto rest = rest_of(strokes, {{0, 0.0, 0.5}, {0, 0.5009, 1.0}}, 1e-3);
  ASSERT_EQ(rest.size(), 1u);
  EXPECT_EQ(rest[0].stroke, 1);
  EXPECT_TRUE(rest_of(strokes, {{0, 0, 1}, {1, 0, 0}}, 1e-3).empty());
}

// The plan gives the place on the stroke; for a part, in lengths of the whole stroke.
TEST(StrokePart, ThePlanKnowsWhereOnTheStrokeItIs) {
  const PlacedStroke bent = surfaces::line({{0.55, -0.04}, {0.65, -0.04}, {0.65, 0.06}}, 4);
  for (const auto& [from, to] : {std::pair{0.0, 0.2}, std::pair{0.03, 0.17}}) {
    const TipPath path = plan_tip_path({part_of(bent, from, to)}, surfaces::bowl);
    const StrokeTimes& times = path.strokes()[0];
    EXPECT_EQ(times.number, 4);
    double last = from;
    for (double t = times.start + 1e-6; t < times.end; t += 0.01) {
      const PathSample sample = path.at(t);
      ASSERT_EQ(sample.stroke, 4);
      ASSERT_GE(sample.along, last - 1e-12);
      last = sample.along;
      ASSERT_LT((place_on(bent, sample.along).p_P - sample.reference.p_WD.head<2>()).norm(), 1e-4)
          << t;  // interpolated between knots
    }
    EXPECT_NEAR(path.at(times.end - 1e-6).along, to, 1e-6);
  }
}

// A tilted drawing plane: the same motion, turned.
TEST(StrokePart, ATiltedPlaneTurnsThePath) {
  const PlacedStroke line = surfaces::line({{0.55, -0.04}, {0.65, 0.03}});
  PathSettings level, tilted;
  tilted.X_WP.R = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  tilted.X_WP.p = {0.1, -0.2, 0.3};
  tilted.start_p_WE = tilted.X_WP * level.start_p_WE;
  tilted.start_n_W = tilted.X_WP.R * level.start_n_W;
  const TipPath a = plan_tip_path({line}, surfaces::bowl, level),
                b = plan_tip_path({line}, surfaces::bowl, tilted);
  ASSERT_NEAR(a.duration(), b.duration(), 1e-12);
  for (double t = 0; t < a.duration(); t += 0.037) {
    const TipReference x = a.at(t).reference, y = b.at(t).reference;
    EXPECT_LT((tilted.X_WP * x.p_WD - y.p_WD).norm(), 1e-12);
    EXPECT_LT((tilted.X_WP.R * x.v_WD - y.v_WD).norm(), 1e-12);
    EXPECT_LT((tilted.X_WP.R * x.n_WD - y.n_WD).norm(), 1e-12);
    EXPECT_LT((tilted.X_WP.R * x.alpha_WD - y.alpha_WD).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace impedraw
