// Layers are pens: they are drawn one after the other.
//
// A layer's name may say how it is drawn, as AxiDraw's software has it:
//
//   %     the layer is not drawn, and hides nothing
//   !     the pen waits before it
//   3     it stands where its number puts it among the numbered layers
//   +S50  speed, in percent of path.draw_speed
//   +D500 a wait before it [ms]
//   +H60  height of the pen: passed over, since force holds the pen
//
// as in "!2+S50 red". Whatever follows is the name.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "impedraw/drawing/stroke.h"

namespace impedraw {

// Where an SVG's layers come from. automatic: its groups, unless there is at most one, without a
// name, and what is painted has two to eight colours.
enum class LayerSource { automatic, groups, colours };

struct LayerMarks {
  bool off = false, pause = false, height = false;
  std::optional<int> number;
  double speed = 1;  // of path.draw_speed, more than 0
  double wait = 0;   // [s]
  std::string name;  // what follows
};
LayerMarks layer_marks(const std::string& layer);

// "red", or "#1c2a3a".
std::string colour_name(std::uint32_t colour);

// Puts numbered layers in order, and the strokes with them. Warnings name the marks that are not
// obeyed: pauses, waits, speeds and heights.
void order_layers(Artwork& artwork);

// Keeps the layers that are chosen: "2,black" are the layer of that number and the one of that
// name. A layer without a number has that of its place. InputError: there is no such layer.
void choose_layers(Artwork& artwork, const std::string& choice);

}  // namespace impedraw
