#include "impedraw/drawing/hershey.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <memory>
#include <utility>

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/file_extension.h"
#include "impedraw/common/input_file.h"
#include "impedraw/drawing/svg.h"
#include "impedraw/drawing/usvg/impedraw_usvg.h"
#include "impedraw/files/data_folder.h"

namespace impedraw {

using Eigen::Vector2d;

Eigen::AlignedBox2d Glyph::box() const {
  Eigen::AlignedBox2d box;
  for (const auto& stroke : strokes) {
    for (const Vector2d& p : stroke) box.extend(p);
  }
  return box;
}

const Glyph* HersheyFont::find(char32_t c) const {
  if (const auto found = more.find(c); found != more.end()) return &found->second;
  if (c < 32 || c > 126 || c - 32 >= glyphs.size()) return nullptr;
  const Glyph& glyph = glyphs[c - 32];
  return glyph.strokes.empty() && c != ' ' ? nullptr : &glyph;
}

Glyph hershey_glyph(std::string_view codes, std::vector<std::vector<Vector2d>> more) {
  Glyph glyph{static_cast<double>(codes[0] - 'R'), static_cast<double>(codes[1] - 'R'), {}};
  bool down = false;
  for (std::size_t i = 2; i < codes.size(); i += 2) {
    if (codes[i] == ' ' && codes[i + 1] == 'R') {
      down = false;
      continue;
    }
    if (!down) glyph.strokes.emplace_back();
    down = true;
    glyph.strokes.back().emplace_back(codes[i] - 'R', codes[i + 1] - 'R');
  }
  glyph.strokes.insert(glyph.strokes.end(), more.begin(), more.end());
  return glyph;
}

HersheyFont parse_jhf(std::string_view text, const std::string& name) {
  HersheyFont font{name, {}};
  const auto fail = [&](const std::string& what) {
    throw InputError(fmt::format("font {}: glyph {}: {}", name, font.glyphs.size(), what));
  };
  const auto line_end = [](char c) { return c == '\n' || c == '\r'; };
  std::size_t at = 0;
  const auto skip_line_ends = [&] {
    while (at < text.size() && line_end(text[at])) ++at;
  };
  for (skip_line_ends(); at < text.size(); skip_line_ends()) {
    if (text.size() - at < 8) fail("the file ends inside its header");
    std::string_view head = text.substr(at + 5, 3);
    while (head.starts_with(' ')) head.remove_prefix(1);
    int pairs = 0;
    const auto [end, error] = std::from_chars(head.data(), head.data() + head.size(), pairs);
    if (error != std::errc() || end != head.data() + head.size() || pairs < 1)
      fail("no number of pairs in columns 6 to 8");
    at += 8;
    std::string codes;
    for (; at < text.size() && codes.size() < 2 * static_cast<std::size_t>(pairs); ++at) {
      if (!line_end(text[at])) codes += text[at];
    }
    if (codes.size() < 2 * static_cast<std::size_t>(pairs))
      fail("the file ends before its last pair");
    Glyph glyph = hershey_glyph(codes);
    // Without a width, as in rowmant's J, the ink determines it.
    if (!glyph.strokes.empty() && glyph.right <= glyph.left) {
      const Eigen::AlignedBox2d ink = glyph.box();
      glyph.left = ink.min().x() - 2, glyph.right = ink.max().x() + 2;
    }
    font.glyphs.push_back(std::move(glyph));
    while (at < text.size() && !line_end(text[at])) {
      if (text[at++] != ' ') fail("more pairs than it says");
    }
  }
  if (font.glyphs.empty()) throw InputError(fmt::format("font {}: no glyph in it", name));
  return font;
}

std::filesystem::path hershey_folder() {
  std::error_code error;
  const std::filesystem::path own = data_folder() / "hershey-fonts";  // of the Python package
  return std::filesystem::is_directory(own, error) ? own : "/usr/share/hershey-fonts";
}

std::vector<std::string> hershey_font_names() {
  std::vector<std::string> names;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(hershey_folder(), error)) {
    if (entry.path().extension() == ".jhf") names.push_back(entry.path().stem());
  }
  if (names.empty()) {
    throw InputError(
        fmt::format("{}: has no fonts for text; Debian's package hershey-fonts-data provides them",
                    hershey_folder().string()));
  }
  std::sort(names.begin(), names.end());
  return names;
}

namespace {

HersheyFont read_jhf(const std::string& name) {
  std::ifstream in(hershey_folder() / (name + ".jhf"), std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), {});
  if (!in) throw InputError(fmt::format("font {}: cannot be read", name));
  return parse_jhf(text, name);
}

// Letters of other alphabets, where their fonts have them: a font's character and the letter.
void add_alphabet(HersheyFont& font, const std::string& from, std::u32string_view characters,
                  std::u32string_view letters) {
  const HersheyFont other = read_jhf(from);
  for (std::size_t i = 0; i < letters.size(); ++i)
    if (const Glyph* glyph = other.find(characters[i])) font.more[letters[i]] = *glyph;
}

void add_alphabets(HersheyFont& font) {
  constexpr std::u32string_view kSmall = U"abcdefghijklmnopqrstuvwxyz",
                                kLarge = U"ABCDEFGHIJKLMNOPQRSTUVWXYZ";
  add_alphabet(font, "greeks", kLarge, U"ΑΒΓΔΕΖΗΘΙΚΛΜΝΞΟΠΡΣΤΥΦΧΨΩ");
  add_alphabet(font, "greeks", kSmall, U"αβγδεζηθικλμνξοπρστυφχψω");
  add_alphabet(font, "cyrilc_1", kLarge, U"АБВГДЕЖЗИЙКЛМНОПРСТУФХЦЧШЩ");
  add_alphabet(font, "cyrilc_1", kSmall, U"абвгдежзийклмнопрстуфхцчшщ");
  add_alphabet(font, "cyrillic", U"]$_CU^|&~u}C", U"ЪЫЬЭЮЯъыьюяэ");
  if (const auto small = font.more.find(U'э'); small != font.more.end()) {
    constexpr double kShare = 14.0 / 21.0;  // the font has only the capital
    Glyph& glyph = small->second;
    glyph.left *= kShare, glyph.right *= kShare;
    for (auto& stroke : glyph.strokes)
      for (Vector2d& p : stroke)
        p = Vector2d(kShare * p.x(), kBaseline + kShare * (p.y() - kBaseline));
  }
  for (const auto& [letter, same] :
       {std::pair{U'І', U'I'}, {U'і', U'i'}, {U'Ј', U'J'}, {U'ј', U'j'}})
    if (const Glyph* glyph = font.find(same)) font.more[letter] = Glyph(*glyph);
}

HersheyFont read_svg_font(const std::filesystem::path& file) {
  constexpr double kLargestMb = 64;
  const InputFile in(file);
  if (static_cast<double>(in.size()) > 1e6 * kLargestMb)
    throw InputError(fmt::format("font {}: over {:.0f} MB", file.string(), kLargestMb));
  const std::string text = in.read(static_cast<std::size_t>(1e6 * kLargestMb));
  const std::unique_ptr<const ImpedrawSvg, decltype(&impedraw_svg_free)> read(
      impedraw_svg_font(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()),
      impedraw_svg_free);
  if (read->error) throw InputError(fmt::format("font {}: {}", file.string(), read->error));
  HersheyFont font{file.string(), {}};
  std::map<std::string, char32_t> of_layer;
  constexpr double kMm = 25.4 / 96;  // of a unit of the font, taken for a pixel
  for (std::size_t i = 2; i < read->warning_count; ++i) {
    const std::string line = read->warnings[i];
    const std::size_t blank = line.find(' ');
    const auto letter = static_cast<char32_t>(std::stoul(line.substr(0, blank)));
    font.more[letter].right = kMm * std::stod(line.substr(blank));
    of_layer["glyph-" + line.substr(0, blank)] = letter;
  }
  const Artwork drawn =
      parse_svg(read->warnings[0], font.name,
                {.may_be_empty = true, .visible = Visible::all, .layers = LayerSource::groups});
  for (const Stroke& stroke : drawn.strokes)
    font.more[of_layer.at(drawn.layers[stroke.layer])].strokes.push_back(stroke.points);
  double capitals = kMm * std::stod(read->warnings[1]);
  for (const char32_t c : {U'H', U'E', U'I', U'A', U'x'})
    if (const Glyph* glyph = font.find(c); glyph && capitals <= 0 && !glyph->strokes.empty())
      capitals = glyph->box().max().y();  // y is up in the font
  if (!(capitals > 0)) capitals = 0.7 * drawn.page.sizes().y();
  const double scale = kCapHeight / capitals;
  for (auto& [letter, glyph] : font.more) {
    glyph.right *= scale;
    for (auto& stroke : glyph.strokes)
      for (Vector2d& p : stroke) p = Vector2d(scale * p.x(), kBaseline - scale * p.y());
  }
  return font;
}

}  // namespace

HersheyFont read_hershey_font(const std::string& name) {
  if (lower_extension(name) == ".svg") return read_svg_font(name);
  const std::vector<std::string> names = hershey_font_names();
  if (std::find(names.begin(), names.end(), name) == names.end()) {
    std::string known;
    for (const std::string& n : names) known += (known.empty() ? "" : ", ") + n;
    throw InputError(fmt::format(
        "font '{}' is not known; there are {}, and files of SVG fonts (.svg)", name, known));
  }
  HersheyFont font = read_jhf(name);
  add_alphabets(font);
  return font;
}

}  // namespace impedraw
