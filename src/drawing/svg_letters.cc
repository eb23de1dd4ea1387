#include "impedraw/drawing/svg_letters.h"

#include <fmt/core.h>

#include "impedraw/drawing/letters.h"

namespace impedraw {

using Eigen::Vector2d;
constexpr std::size_t kMostNamed = 8;  // letters in one warning

std::vector<std::vector<Vector2d>> SvgLetters::strokes_of(const SvgSubpath& place) {
  if (!font_) font_ = read_hershey_font(name_);
  const char32_t letter = place.path->letter[0], mark = place.path->letter[1];
  const auto glyph = glyph_of(*font_, letter, std::u32string(mark > 0 ? 1 : 0, mark));
  if (!glyph) {
    if (lacking_.find(letter) == std::u32string::npos) lacking_ += letter;
    return {};
  }
  const Vector2d origin = place.start, along = place.segments[0].end() - origin,
                 up = place.segments[1].end() - origin;
  std::vector<std::vector<Vector2d>> strokes = glyph->strokes;
  for (std::vector<Vector2d>& stroke : strokes) {
    for (Vector2d& p : stroke)
      p = origin + (p.x() - glyph->left) / (glyph->right - glyph->left) * along +
          (kBaseline - p.y()) / kCapHeight * up;
  }
  return strokes;
}

std::string SvgLetters::lacking() const {
  if (lacking_.empty()) return {};
  std::string named;
  for (const char32_t c : lacking_.substr(0, kMostNamed)) named += " '" + encoded_utf8(c) + "'";
  if (lacking_.size() > kMostNamed)
    named += fmt::format(" and {} more", lacking_.size() - kMostNamed);
  return fmt::format("the font {} has no{}: left out; drawing.text.as=outline draws them", name_,
                     named);
}

}  // namespace impedraw
