// The combinations of ./impedraw reach: public drawings and made ones on canvases of every kind.
#pragma once

#include <string>
#include <vector>

#include "impedraw/study/cell.h"

namespace impedraw {

struct ReachDrawing {
  std::string name;
  std::string svg;  // as Cell::svg; empty: the assignments say what
  std::vector<std::string> assignments;
  std::string source;  // what it is and where it comes from
};
std::vector<ReachDrawing> reach_drawings();

struct ReachCanvas {
  std::string name;  // scenarios/reach-NAME.yaml
  std::string source;
};
std::vector<ReachCanvas> reach_canvases();

// Each drawing on each canvas: "koi-on-bowl".
std::vector<Cell> reach_cells();

}  // namespace impedraw
