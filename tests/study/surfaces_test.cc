// Some cells of ./impedraw robustness --part surfaces, and what their table says.
#include "impedraw/study/surfaces.h"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "scratch_folder.h"

namespace impedraw {
namespace {

TEST(SurfaceCells, CoverTheRangeThatWasAskedFor) {
  const std::vector<Cell> cells = surface_cells();
  EXPECT_GE(cells.size(), 120u);
  std::set<std::string> names, kinds, drawings;
  for (const Cell& cell : cells) {
    EXPECT_TRUE(names.insert(cell.name).second) << cell.name << " stands there twice";
    kinds.insert(cell.group);
    drawings.insert(cell.column);
    EXPECT_TRUE(cell_scenario(cell).drawing.skip_unreachable) << cell.name;
  }
  EXPECT_EQ(drawings, (std::set<std::string>{"hatch", "spiral", "text"}));
  for (const char* kind : {"fractal", "facets", "ridges", "ripple", "step", "hole", "lip", "mesh"})
    EXPECT_TRUE(kinds.contains(kind)) << kind;
}

TEST(SurfaceCells, EachLimitCanBeMissed) {
  const Cell cell = surface_cells().front();  // 2 mm: not gentle
  Record good = {{"unnamed_mm", "0"},       {"promised", "100"},     {"coverage", "0.99"},
                 {"contact_fraction", "1"}, {"touchdown_peak", "5"}, {"force_sd", "1.2"},
                 {"speed_mean", "20"}};
  EXPECT_EQ(missed_limits(cell, good), "");
  for (const auto& [name, value] : Record{{"unnamed_mm", "5"},
                                          {"coverage", "0.9"},
                                          {"contact_fraction", "0.98"},
                                          {"touchdown_peak", "9"},
                                          {"force_sd", "1.6"},
                                          {"speed_mean", "14"}}) {
    Record bad = good;
    bad[name] = value;
    EXPECT_NE(missed_limits(cell, bad).find(name), std::string::npos) << name;
    bad.erase(name);
    EXPECT_NE(missed_limits(cell, bad), "") << name << " is lacking";
  }
}

class Surface : public ScratchFolder, public ::testing::WithParamInterface<const char*> {};

TEST_P(Surface, IsDrawnOnWithinItsLimits) {
  const std::vector<Cell> cells = surface_cells();
  const auto cell =
      std::find_if(cells.begin(), cells.end(), [](const Cell& c) { return c.name == GetParam(); });
  ASSERT_NE(cell, cells.end());
  ProcessEnd end;
  end.text = measure_surface(*cell, folder_ / "run.h5");
  EXPECT_EQ(field(surface_record(*cell, end), "cause"), "") << end.text;
}

INSTANTIATE_TEST_SUITE_P(Cells, Surface,
                         ::testing::Values("fractal-20deg-08mm-spiral", "fractal-20deg-15mm-hatch",
                                           "facets-10mm-hatch", "ripple-15mm-spiral",
                                           "hole-20mm-spiral", "lip-10mm-hatch",
                                           // Waves and edges that the cameras do not resolve
                                           "fractal-40deg-02mm-text", "fractal-30deg-02mm-hatch",
                                           "facets-02mm-spiral", "facets-10mm-text",
                                           "fractal-30deg-08mm-text", "step-02mm-text"),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

}  // namespace
}  // namespace impedraw
