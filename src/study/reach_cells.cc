#include "impedraw/study/reach_cells.h"

namespace impedraw {

namespace {

const std::string kPackages = ".venv/lib/python3.11/site-packages/";

}  // namespace

std::vector<ReachDrawing> reach_drawings() {
  const std::string icons = kPackages + "matplotlib/mpl-data/images/",
                    made = "made by tests/data/make_reach_data.py";
  return {
      {"koi", "artwork/koi.svg", {}, "two koi in 64 strokes; own work"},
      {"logo",
       icons + "matplotlib.svg",
       {},
       "matplotlib's logo, from its wheel (matplotlib 3.11.2, matplotlib licence)"},
      {"hand",
       icons + "hand.svg",
       {},
       "the icon hand.svg, a cross in a ring of 3,389 points; the same wheel"},
      {"diskette",
       icons + "filesave.svg",
       {"drawing.hatch.spacing=8"},
       "the icon filesave.svg, filled, hatched 8 mm apart; the same wheel"},
      {"verse",
       "",
       {"drawing.text.text=What the hand\\ndares to seize\\nthe fire?", "drawing.text.font=scripts",
        "drawing.text.align=centre"},
       "three lines by W. Blake in the Hershey font scripts (Debian's hershey-fonts-data)"},
      {"hilbert",
       "tests/data/hilbert.strokes",
       {},
       "a Hilbert curve of 256 points in one stroke, nearly every point a corner; a stroke file " +
           made},
      {"spiral", "tests/data/spiral.csv", {}, "two arms of 3.5 turns; a CSV file " + made},
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
      {"bowl", "the standard bowl: a sphere of radius 0.30 m from inside, slopes to 37°; built in"},
      {"leaning", "a plane inclined by 27°, too small for the widest drawings; built in"},
      {"wave", "amplitude 15 mm, wavelength 0.2 m, slopes to 25°; built in"},
      {"saddle", "radius of curvature 0.25 m; built in"},
      {"cylinder", "radius 0.14 m, drawn on from outside, slopes to 59°; built in"},
      {"cone", "slope 20°, drawn over its apex and past its foot; built in"},
      {"terrain", "random hills and hollows of 30 mm; built in"},
      {"wall",
       "an upright plane in front of the arm, the drawing at the upper end of its reach; built in"},
      {"tile",
       "a relief of six petals, 0.3 m wide: tests/data/flower_tile.obj, in mm, made by "
       "tests/data/make_reach_data.py"},
      {"ball",
       "a sphere of 840 triangles, radius 0.13 m: examples/sphere.ply in PyVista's wheel (pyvista "
       "0.49.1, MIT), in mm"},
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
