// Layers are pens: they are drawn one after the other.
//
// A layer's name may say how it is drawn, as AxiDraw's software has it:
//
//   %     the layer is not drawn, and hides nothing
//   !     the pen waits before it, until it is told to go on
//   3     it stands where its number puts it among the numbered layers
//   +S50  speed, in percent of path.draw_speed
//   +D500 a wait before it [ms]
//   +H60  height of the pen: passed over, since force holds the pen
//
// as in "!2+S50 red". Whatever follows is the name.
#pragma once

#include <optional>
#include <string>

#include "impedraw/drawing/stroke.h"

namespace impedraw {

// The source of an SVG's layers. automatic: its groups, unless there is at most one, without a
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
// The same read; none if the text is neither.
std::optional<std::uint32_t> named_colour(const std::string& text);

// True if `word` is the layer's number or name, or all of it; case does not count. A layer without
// a number has that of its place, from 0 here.
bool is_layer(const std::string& word, const std::string& layer, std::size_t place);

// Puts numbered layers in order, and the strokes with them. A warning names the layers whose
// heights are passed over.
void order_layers(Artwork& artwork);

// Keeps the layers that are chosen: "2,black" are the layer of that number and the one of that
// name. A layer without a number has that of its place. InputError: there is no such layer.
void choose_layers(Artwork& artwork, const std::string& choice);

}  // namespace impedraw
