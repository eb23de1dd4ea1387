// The wrap where the surface ends, and what it refuses.
#include <filesystem>
#include <fstream>

#include <unistd.h>

#include <fmt/core.h>
#include <gmock/gmock.h>

#include "impedraw/common/errors.h"
#include "impedraw/planning/wrap/convex_hull.h"
#include "impedraw/planning/wrap/wrap.h"
#include "wrap_surfaces.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using surfaces::circle;
using surfaces::line;
using testing::HasSubstr;
const Vector2d kCentre(0.60, 0);

SurfaceHeight without(const SurfaceHeight& surface,
                      const std::function<bool(const Vector2d&)>& hole) {
  return [=](double x, double y) { return hole({x, y}) ? std::nullopt : surface(x, y); };
}

std::string refusal(const SurfaceHeight& surface, const Vector2d& centre,
                    const std::vector<PlacedStroke>& strokes, const WrapSettings& settings = {}) {
  try {
    const Wrap wrap(surface, centre, strokes, settings);
  } catch (const InputError& error) {
    EXPECT_THAT(std::string(error.what()), testing::Not(HasSubstr("\n")));
    return error.what();
  }
  return "nothing was refused";
}

TEST(WrapCuts, AtTheRimAndCountsWhatIsLost) {
  PlacedStroke stroke = line({kCentre, kCentre + Vector2d(0.30, 0)});
  stroke.page = {Vector2d(0, 0), Vector2d(300, 0)};
  stroke.number = 4;
  const Wrap wrap(surfaces::bowl, kCentre, {stroke});
  const WrappedStrokes wrapped = wrap.wrap({stroke});
  ASSERT_EQ(wrapped.strokes.size(), 1u);
  ASSERT_EQ(wrapped.lost.size(), 1u);
  EXPECT_EQ(wrapped.strokes[0].number, 4);
  EXPECT_EQ(wrapped.lost[0].stroke, 4);
  // Whole cells only, so it may end a spacing before the rim (0.18 m away seen along z), and not
  // beyond it.
  const double end = (wrapped.strokes[0].p_P.back() - kCentre).norm();
  EXPECT_LE(end, 0.18 + 1e-9);
  EXPECT_GT(end, 0.18 - 0.0031);
  EXPECT_NEAR(wrapped.lost[0].to, 0.30, 1e-12);
  EXPECT_NEAR(wrapped.strokes[0].page.back().x(), 1e3 * wrapped.lost[0].from,
              3e-3);  // kept and lost meet within the cut's 1 µm
}

TEST(WrapCuts, AHoleMakesTwoParts) {
  const Vector2d hole(0.64, 0.001);
  const SurfaceHeight surface =
      without(surfaces::table, [&](const Vector2d& p) { return (p - hole).norm() < 0.01; });
  PlacedStroke stroke = line({kCentre - Vector2d(0.05, 0), kCentre + Vector2d(0.08, 0)});
  stroke.number = 2;
  const WrappedStrokes wrapped = Wrap(surface, kCentre, {stroke}).wrap({stroke});
  ASSERT_EQ(wrapped.strokes.size(), 2u);
  ASSERT_EQ(wrapped.lost.size(), 1u);
  const double width = 2 * std::sqrt(0.01 * 0.01 - 0.001 * 0.001);
  EXPECT_GE(wrapped.lost[0].length(), width);
  EXPECT_LT(wrapped.lost[0].length(), width + 0.006);
  for (const PlacedStroke& part : wrapped.strokes) EXPECT_EQ(part.number, 2);
  // On a table flat and plane are one.
  EXPECT_NEAR(wrapped.strokes[1].start, wrapped.lost[0].to, 2e-6);
  EXPECT_NEAR((wrapped.strokes[0].p_P.back() - stroke.p_P[0]).norm(), wrapped.lost[0].from, 2e-6);
}

TEST(WrapCuts, AtAStepWhichAHeightFieldDoesNotShow) {
  const SurfaceHeight surface = [](double x, double y) -> std::optional<SurfaceSample> {
    return SurfaceSample{{x, y, x < 0.65 ? 0.1 : 0.3}};
  };
  const PlacedStroke stroke = line({kCentre, kCentre + Vector2d(0.10, 0)});
  const WrappedStrokes wrapped = Wrap(surface, kCentre, {stroke}).wrap({stroke});
  ASSERT_EQ(wrapped.strokes.size(), 1u);
  EXPECT_LT(wrapped.strokes[0].p_P.back().x(), 0.65);
  EXPECT_GT(wrapped.strokes[0].p_P.back().x(), 0.65 - 0.0031);
  EXPECT_THAT(wrapped.lost, testing::SizeIs(1));
}

TEST(WrapCuts, ADotStaysADotOrIsLost) {
  PlacedStroke here = line({kCentre + Vector2d(0.05, 0.02)}),
               off = line({kCentre + Vector2d(0.25, 0)});
  here.number = 0, off.number = 1;
  const WrappedStrokes wrapped = Wrap(surfaces::bowl, kCentre, {here, off}).wrap({here, off});
  ASSERT_EQ(wrapped.strokes.size(), 1u);
  EXPECT_EQ(wrapped.strokes[0].p_P.size(), 1u);
  ASSERT_EQ(wrapped.lost.size(), 1u);
  EXPECT_EQ(wrapped.lost[0].stroke, 1);
  EXPECT_EQ(wrapped.lost[0].length(), 0);
}

TEST(WrapCuts, InsertsPointsUntilTheImageIsFollowed) {
  const PlacedStroke stroke =
      line({kCentre + Vector2d(-0.08, 0.05), kCentre + Vector2d(0.08, 0.03)});
  WrapSettings settings;
  const Wrap wrap(surfaces::waves, kCentre, {stroke}, settings);
  const PlacedStroke wrapped = wrap.wrap({stroke}).strokes.at(0);
  double worst = 0, straight = 0;
  for (std::size_t k = 1; k < wrapped.p_P.size(); ++k) {
    for (const double share : {0.1, 0.37, 0.5, 0.8}) {
      const Vector2d flat =
          wrapped.page[k - 1] +
          share * (wrapped.page[k] - wrapped.page[k - 1]);  // page points are flat points here
      const Vector2d chord = wrapped.p_P[k - 1] + share * (wrapped.p_P[k] - wrapped.p_P[k - 1]);
      worst = std::max(worst, (*wrap.to_plane(flat) - chord).norm());
      const double along = (flat - stroke.p_P[0]).norm() / (stroke.p_P[1] - stroke.p_P[0]).norm();
      const Vector2d ends =
          wrapped.p_P.front() + along * (wrapped.p_P.back() - wrapped.p_P.front());
      straight = std::max(straight, (*wrap.to_plane(flat) - ends).norm());
    }
  }
  EXPECT_LT(worst, 1.2 * settings.tolerance);
  EXPECT_GT(straight, 1e-3) << "nothing to follow";
  EXPECT_LT(wrapped.p_P.size(), 200u);
}

TEST(WrapErrors, NameWhatIsWrong) {
  const PlacedStroke stroke = circle(kCentre, 0.05);
  EXPECT_THAT(
      refusal(surfaces::bowl, {0.90, 0}, {stroke}),
      HasSubstr("no point above the drawing's centre, (0.9000, 0.0000) m in the drawing plane"));
  EXPECT_THAT(refusal(surfaces::bowl, kCentre, {}), HasSubstr("no strokes"));
  WrapSettings settings;
  settings.spacing = 1e-4;
  EXPECT_THAT(refusal(surfaces::bowl, kCentre, {stroke}, settings),
              HasSubstr("wrap.spacing is 1e-04 m, allowed is 5e-04 to 0.02 m"));
  settings = {};
  settings.margin = 0.001;
  EXPECT_THAT(refusal(surfaces::bowl, kCentre, {stroke}, settings),
              HasSubstr("wrap.margin is 0.001 m, allowed is two spacings or more: 0.006 m"));
  const SurfaceHeight thread =
      without(surfaces::table, [](const Vector2d& p) { return std::abs(p.y()) > 1e-4; });
  EXPECT_THAT(refusal(thread, kCentre, {stroke}),
              HasSubstr("the surface ends or is steeper than 80°"));
}

TEST(WrapErrors, TellWhereTheSurfaceFoldsOver) {
  const Vector2d apex =
      kCentre +
      Vector2d(
          0.04,
          0);  // of a cone of 70°: a third of a turn of paper, and all of it about the apex is page
  const SurfaceHeight cone = surfaces::height_field(
      [&](double x, double y) { return -2.75 * (Vector2d(x, y) - apex).norm(); });
  EXPECT_THAT(refusal(cone, kCentre, {circle(kCentre, 0.10)}),
              testing::ContainsRegex("fold over, the first at \\(0\\.6[34]"));
}

// A needle of 79° at a grid point of a table: no paper fits on it, the rest lies flat.
TEST(WrapCuts, LeavesOutWhatFoldsOver) {
  const Vector2d apex = kCentre + Vector2d(0.048, 0);
  const SurfaceHeight needle = surfaces::height_field([&](double x, double y) {
    return std::max(0.0, 0.016 - 5.3 * (Vector2d(x, y) - apex).norm());
  });
  const PlacedStroke across = line({kCentre - Vector2d(0.08, 0), kCentre + Vector2d(0.10, 0)}),
                     beside =
                         line({kCentre + Vector2d(-0.08, 0.05), kCentre + Vector2d(0.1, 0.05)});
  const Wrap wrap(needle, kCentre, {across, beside});
  const WrappedStrokes wrapped = wrap.wrap({across, beside});
  ASSERT_EQ(wrapped.strokes.size(), 3u);
  ASSERT_EQ(wrapped.lost.size(), 1u);
  const StrokePart& lost = wrapped.lost[0];
  EXPECT_GT(lost.from, 0.10);
  EXPECT_LT(lost.to, 0.16);
  for (const Vector2d& p : wrapped.strokes[2].p_P) EXPECT_NEAR(p.y(), 0.05, 3e-4);
}

TEST(WrapErrors, PassOnWhatTheScriptSays) {
  const PlacedStroke stroke = circle(kCentre, 0.05);
  WrapSettings settings;
  settings.python = "/no/such/python";
  EXPECT_THAT(refusal(surfaces::bowl, kCentre, {stroke}, settings), HasSubstr("/no/such/python"));
  const std::filesystem::path mute =
      std::filesystem::temp_directory_path() / fmt::format("impedraw_wrap_test_{}.sh", ::getpid());
  std::ofstream(mute)
      << "#!/bin/sh\necho 'Traceback' >&2\necho 'ImportError: libigl is not here' >&2\nexit 1\n";
  std::filesystem::permissions(mute, std::filesystem::perms::owner_all);
  settings.python = mute;
  EXPECT_THAT(refusal(surfaces::bowl, kCentre, {stroke}, settings),
              HasSubstr("failed: ImportError: libigl is not here"));
  std::filesystem::remove(mute);
  settings.python = "/bin/true";  // says that all is well and writes nothing
  EXPECT_THAT(refusal(surfaces::bowl, kCentre, {stroke}, settings), HasSubstr("gave 0 bytes"));
}

TEST(ConvexHull, HoldsAllPointsAndNothingMore) {
  const std::vector<Vector2d> hull =
      convex_hull({{0, 0}, {2, 0}, {1, 0}, {2, 1}, {1, 0.5}, {0, 1}, {0, 0}});
  EXPECT_THAT(hull,
              testing::ElementsAre(Vector2d(0, 0), Vector2d(2, 0), Vector2d(2, 1), Vector2d(0, 1)));
  EXPECT_EQ(distance_to_hull(hull, {1, 0.7}), 0);
  EXPECT_DOUBLE_EQ(distance_to_hull(hull, {3, 2}), std::sqrt(2));
  EXPECT_DOUBLE_EQ(distance_to_hull(hull, {1, -0.25}), 0.25);
  EXPECT_DOUBLE_EQ(distance_to_hull(convex_hull({{1, 1}, {1, 1}}), {1, 3}), 2);
  EXPECT_DOUBLE_EQ(distance_to_hull(convex_hull({{0, 0}, {1, 1}, {2, 2}}), {2, 0}), std::sqrt(2));
}

}  // namespace
}  // namespace impedraw
