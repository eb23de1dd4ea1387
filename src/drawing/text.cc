#include "impedraw/drawing/text.h"

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/drawing/letters.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
constexpr int kMostNamed = 8;  // characters in one error
constexpr std::size_t kMostCharacters = 100'000;

std::vector<std::u32string> lines_of(const std::u32string& text) {
  std::vector<std::u32string> lines(1);
  for (std::size_t i = 0; i < text.size(); ++i) {
    const bool spelled = text[i] == '\\' && i + 1 < text.size() && text[i + 1] == 'n';
    if (spelled) ++i;
    if (spelled || text[i] == '\n')
      lines.emplace_back();
    else if (text[i] != '\r')
      lines.back() += text[i] == '\t' ? U' ' : text[i];
  }
  return lines;
}

std::string shown(char32_t c) {
  const std::string code = fmt::format("U+{:04X}", static_cast<unsigned>(c));
  return c < 32 || (c >= 127 && c < 160) ? code : fmt::format("'{}' ({})", encoded_utf8(c), code);
}

struct TextLine {
  std::vector<std::vector<Vector2d>> strokes;  // [grid], from the pen at 0
  double left = 0, right = 0;                  // extent of its ink and of the blanks at its ends
};

class Typesetter {
 public:
  explicit Typesetter(const HersheyFont& font) : font_(font) {}

  TextLine set(const std::u32string& text, std::size_t line_number) {
    TextLine line;
    Eigen::AlignedBox1d ink;
    double pen = 0, leading = 0, trailing = 0;
    for (std::size_t i = 0; i < text.size();) {
      std::size_t next = i + 1;
      while (next < text.size() && is_combining_mark(text[next])) ++next;
      const auto glyph =
          glyph_of(font_, text[i], std::u32string_view(text).substr(i + 1, next - i - 1));
      if (!glyph) lacks(text[i], line_number, i + 1);
      i = next;
      if (!glyph) continue;
      const double width = glyph->right - glyph->left;
      for (std::vector<Vector2d> stroke : glyph->strokes) {
        for (Vector2d& p : stroke) {
          p.x() += pen - glyph->left;
          ink.extend(Eigen::Matrix<double, 1, 1>(p.x()));
        }
        line.strokes.push_back(std::move(stroke));
      }
      trailing = glyph->strokes.empty() ? trailing + width : 0;
      if (line.strokes.empty()) leading += width;
      pen += width;
    }
    if (!ink.isEmpty()) line.left = ink.min()[0] - leading, line.right = ink.max()[0] + trailing;
    return line;
  }

  // Call after every line is set.
  void require_all() const {
    if (lacking_ == 0) return;
    if (lacking_ > kMostNamed) {
      throw InputError(
          fmt::format("text: {} and {} more: {}", named_, lacking_ - kMostNamed, what_there_is()));
    }
    throw InputError(fmt::format("text: {}: {}", named_, what_there_is()));
  }

 private:
  void lacks(char32_t c, std::size_t line, std::size_t place) {
    if (++lacking_ > kMostNamed) return;
    named_ += fmt::format("{}{} at line {}, character {}", named_.empty() ? "" : "; ", shown(c),
                          line, place);
  }

  std::string what_there_is() const {
    if (font_.glyphs.empty())
      return fmt::format("font {} has {} characters, and those that accents make of them",
                         font_.name, font_.more.size());
    std::string empty;
    for (char32_t c = 33; c < 127; ++c) {
      if (!font_.find(c)) empty += static_cast<char>(c);
    }
    const std::string ascii = empty.empty() ? "ASCII" : fmt::format("ASCII without {}", empty);
    return fmt::format(
        "font {} has {}, the letters of Latin-1 and Latin Extended-A (U+00C0 to U+017F), Greek, "
        "Cyrillic, "
        "and ° · × ÷ ± « » ‹ › ¡ ¿ µ €",
        font_.name, ascii);
  }

  const HersheyFont& font_;
  std::string named_;
  int lacking_ = 0;
};

}  // namespace

Artwork make_text(const TextSettings& settings) {
  const double size = settings.size_mm.value_or(10);
  require_in_range("text", TextSettings::Limits::size, size);
  require_in_range("text", TextSettings::Limits::line_spacing, settings.line_spacing);
  const std::u32string text = decoded_utf8(settings.text);
  if (text.size() > kMostCharacters) {
    throw InputError(
        fmt::format("text: {} characters; at most {} are drawn", text.size(), kMostCharacters));
  }
  const HersheyFont font = read_hershey_font(settings.font);

  Artwork artwork;
  artwork.name = "text";
  artwork.layers = {"text"};
  const double scale = size / kCapHeight, share = settings.align == TextAlign::left     ? 0
                                                  : settings.align == TextAlign::centre ? 0.5
                                                                                        : 1;
  Typesetter typesetter(font);
  double down = 0;
  std::size_t number = 0;
  for (const std::u32string& characters : lines_of(text)) {
    const TextLine line = typesetter.set(characters, ++number);
    const double anchor = line.left + share * (line.right - line.left);
    for (const auto& points : line.strokes) {
      Stroke stroke;
      for (const Vector2d& p : points) {
        const Vector2d q((p.x() - anchor) * scale, down + (p.y() - kCapTop) * scale);
        if (stroke.points.empty() || stroke.points.back() != q) stroke.points.push_back(q);
        artwork.page.extend(q);
      }
      stroke.closed = stroke.points.size() > 2 && stroke.points.front() == stroke.points.back();
      artwork.strokes.push_back(std::move(stroke));
    }
    down += settings.line_spacing * size;
  }
  typesetter.require_all();
  if (artwork.strokes.empty())
    throw InputError("text: has nothing to draw: it is empty or only blanks");
  return artwork;
}

}  // namespace impedraw
