#include "impedraw/study/reach_cells.h"

namespace impedraw {

namespace {

const std::string kPackages = ".venv/lib/python3.11/site-packages/";

}  // namespace

std::vector<ReachDrawing> reach_drawings() {
  const std::string icons = kPackages + "matplotlib/mpl-data/images/",
                    made = "made for it by tests/data/make_reach_data.py";
  return {
      {"koi", "artwork/koi.svg", {}, "two koi in 64 strokes; own work"},
      {"logo",
       icons + "matplotlib.svg",
       {},
       "matplotlib's logo, in its wheel (matplotlib 3.11.2, its own licence, like Python's)"},
      {"hand",
       icons + "hand.svg",
       {},
       "the icon hand.svg of matplotlib, a cross in a ring of 3,389 points; the same wheel"},
      {"diskette",
       icons + "filesave.svg",
       {"drawing.hatch.spacing=8"},
       "another, filled, so hatched 8 mm apart; the same wheel"},
      {"verse",
       "",
       {"drawing.text.text=What the hand\\ndares to seize\\nthe fire?", "drawing.text.font=scripts",
        "drawing.text.align=centre"},
       "words of W. Blake's in three lines in the Hershey font scripts (Debian's "
       "hershey-fonts-data)"},
      {"hilbert",
       "tests/data/hilbert.strokes",
       {},
       "a Hilbert curve of 256 points in one stroke, nearly each a corner; a stroke file, " + made},
      {"spiral", "tests/data/spiral.csv", {}, "two arms of 3.5 turns; a CSV, " + made},
      {"leaf",
       "artwork/leaf.svg",
       {"drawing.hatch.spacing=7", "drawing.hatch.angle=30"},
       "a filled blade, hatched 7 mm apart, with veins; " + made},
      {"compass", "artwork/compass.svg", {}, "rings and spokes in three dash patterns; " + made},
      {"island",
       "artwork/island.svg",
       {},
       "a map in five layers: coasts, contours, a river, a dashed road, towns; " + made},
  };
}

std::vector<ReachCanvas> reach_canvases() {
  return {
      {"bowl", "the standard bowl, a sphere of 0.30 m from inside, to 37°; built in"},
      {"leaning", "a plane that leans by 27°, too small for the widest drawings; built in"},
      {"wave", "15 mm high, 0.2 m long, to 25°; built in"},
      {"saddle", "a radius of curvature of 0.25 m; built in"},
      {"cylinder", "of 0.14 m from outside, to 59°; built in"},
      {"cone", "of 20°, over its apex and past its foot; built in"},
      {"terrain", "hills and hollows of 30 mm from a seed; built in"},
      {"wall", "an upright plane before the arm, the drawing as high as its reach ends; built in"},
      {"tile",
       "a relief of six petals, 0.3 m wide: tests/data/flower_tile.obj, in mm, made by "
       "tests/data/make_reach_data.py"},
      {"ball",
       "of 840 flat triangles, 0.13 m in radius: examples/sphere.ply in PyVista's wheel (pyvista "
       "0.49.1, MIT), taken as mm"},
  };
}

std::vector<Cell> reach_cells() {
  std::vector<Cell> cells;
  for (const ReachDrawing& drawing : reach_drawings())
    for (const ReachCanvas& canvas : reach_canvases()) {
      Cell cell;
      cell.name = drawing.name + "-on-" + canvas.name;
      cell.group = "reach";
      cell.base = "scenarios/reach-" + canvas.name + ".yaml";
      cell.svg = drawing.svg;
      cell.assignments = drawing.assignments;
      cell.row = drawing.name;
      cell.column = canvas.name;
      cells.push_back(cell);
    }
  return cells;
}

}  // namespace impedraw
