// The pens of a run, as the log keeps them: the root attribute `pens` of run.h5, JSON. There where
// the width of a line changes with the force, or layers have pens of their own.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/ink/pen.h"

namespace impedraw {

struct DrawnPen {
  PenSettings line;
  std::string name = {};                     // of the layer; may be empty
  std::optional<std::uint32_t> colour = {};  // 0xRRGGBB; none: the pictures' own ink
  // The pen that a person puts in, by its place in `pens`; -1: that of `pen`. Not in the log.
  int number = -1;
};

struct DrawnPens {
  std::vector<DrawnPen> pens = {};  // at least one
  std::vector<int> of_stroke = {};  // of each stroke of the log; beyond its end the first pen

  int number_of(int stroke) const {
    const bool known = stroke >= 0 && stroke < static_cast<int>(of_stroke.size());
    return known ? of_stroke[static_cast<std::size_t>(stroke)] : 0;
  }
  const DrawnPen& of(int stroke) const { return pens[static_cast<std::size_t>(number_of(stroke))]; }
};

inline constexpr const char* kPensAttribute = "pens";

std::string pens_text(const DrawnPens& pens);
// None without the attribute, or if another program's text stands there.
std::optional<DrawnPens> read_pens(const std::map<std::string, std::string>& attributes);

}  // namespace impedraw
