// The text of an SVG in single pen strokes.
//
// Each letter of a font (hershey.h, letters.h) is drawn where the SVG's own font has it: as wide as
// that one's advance, and its capitals as high.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "impedraw/drawing/hershey.h"
#include "impedraw/drawing/svg_subpaths.h"

namespace impedraw {

class SvgLetters {
 public:
  explicit SvgLetters(std::string font) : name_(std::move(font)) {}

  // The strokes of the letter whose place the subpath is [mm on the page]. InputError: the font is
  // not known.
  std::vector<std::vector<Eigen::Vector2d>> strokes_of(const SvgSubpath& place);
  // Names the letters that the font lacks; empty: none.
  std::string lacking() const;

 private:
  std::string name_;
  std::optional<HersheyFont> font_;  // read for the first letter
  std::u32string lacking_;
};

}  // namespace impedraw
