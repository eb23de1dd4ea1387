#include "impedraw/drawing/layers.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <numeric>
#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/text_fields.h"

namespace impedraw {
namespace {

constexpr std::array<std::pair<std::uint32_t, const char*>, 16> kNames{{
    {0x000000, "black"},
    {0xff0000, "red"},
    {0x00ff00, "lime"},
    {0x0000ff, "blue"},
    {0xffff00, "yellow"},
    {0x00ffff, "cyan"},
    {0xff00ff, "magenta"},
    {0xffffff, "white"},
    {0x808080, "grey"},
    {0x800000, "maroon"},
    {0x008000, "green"},
    {0x000080, "navy"},
    {0x808000, "olive"},
    {0x008080, "teal"},
    {0x800080, "purple"},
    {0xffa500, "orange"},
}};

// The number at the front of the text, which loses it.
std::optional<int> take_number(std::string_view& text) {
  int number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || number < 0) return {};
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

std::string lower(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

// order[i] is the layer that comes i-th.
void reorder(Artwork& artwork, const std::vector<int>& order) {
  std::vector<int> place(order.size());
  std::vector<std::string> layers;
  for (std::size_t i = 0; i < order.size(); ++i) {
    place[order[i]] = static_cast<int>(i);
    layers.push_back(artwork.layers[order[i]]);
  }
  artwork.layers = std::move(layers);
  for (Stroke& stroke : artwork.strokes) stroke.layer = place[stroke.layer];
  for (Area& area : artwork.areas) area.layer = place[area.layer];
  std::stable_sort(artwork.strokes.begin(), artwork.strokes.end(),
                   [](const Stroke& a, const Stroke& b) { return a.layer < b.layer; });
}

}  // namespace

LayerMarks layer_marks(const std::string& layer) {
  LayerMarks marks;
  std::string_view rest = layer;
  for (bool more = true; more;) {
    while (rest.starts_with(' ')) rest.remove_prefix(1);
    more = true;
    if (rest.starts_with('%') || rest.starts_with('!')) {
      (rest[0] == '%' ? marks.off : marks.pause) = true;
      rest.remove_prefix(1);
    } else if (!marks.number && !rest.empty() && rest[0] >= '0' && rest[0] <= '9') {
      marks.number = take_number(rest);
      more = marks.number.has_value();
    } else if (rest.size() > 2 && rest[0] == '+') {
      std::string_view after = rest.substr(2);
      const char what = static_cast<char>(rest[1] & ~0x20);
      const std::optional<int> value = take_number(after);
      more = value && (what == 'S' || what == 'H' || what == 'D');
      if (!more) break;
      if (what == 'S') marks.speed = std::clamp(*value, 1, 100) / 100.0;
      if (what == 'D') marks.wait = *value / 1000.0;
      if (what == 'H') marks.height = true;
      rest = after;
    } else {
      more = false;
    }
  }
  marks.name = trimmed(rest);
  return marks;
}

std::string colour_name(std::uint32_t colour) {
  for (const auto& [value, name] : kNames)
    if (value == colour) return name;
  return fmt::format("#{:06x}", colour);
}

std::optional<std::uint32_t> named_colour(const std::string& text) {
  for (const auto& [value, name] : kNames)
    if (text == name) return value;
  std::uint32_t value = 0;
  const char* const end = text.data() + text.size();
  if (text.size() != 7 || text[0] != '#') return {};
  const auto [stop, error] = std::from_chars(text.data() + 1, end, value, 16);
  return error == std::errc() && stop == end ? std::optional(value) : std::nullopt;
}

bool is_layer(const std::string& word, const std::string& layer, std::size_t place) {
  const LayerMarks marks = layer_marks(layer);
  const std::string wanted = lower(word);
  return wanted == std::to_string(marks.number.value_or(static_cast<int>(place) + 1)) ||
         wanted == lower(marks.name) || wanted == lower(layer);
}

void order_layers(Artwork& artwork) {
  std::vector<int> order(artwork.layers.size()), numbered;
  std::iota(order.begin(), order.end(), 0);
  std::vector<LayerMarks> marks;
  std::string unheeded;
  for (const std::string& layer : artwork.layers) {
    marks.push_back(layer_marks(layer));
    if (marks.back().number) numbered.push_back(static_cast<int>(marks.size()) - 1);
    const LayerMarks& m = marks.back();
    if (m.height) unheeded += (unheeded.empty() ? "'" : ", '") + layer + "'";
  }
  if (!unheeded.empty())
    artwork.warnings.push_back(
        "heights in layer names are passed over, since force holds the pen: " + unheeded);
  std::vector<int> sorted = numbered;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](int a, int b) { return *marks[a].number < *marks[b].number; });
  if (sorted == numbered) return;
  for (std::size_t i = 0; i < numbered.size(); ++i) order[numbered[i]] = sorted[i];
  reorder(artwork, order);
}

void choose_layers(Artwork& artwork, const std::string& choice) {
  std::vector<char> chosen(artwork.layers.size(), false);
  std::string_view rest = choice;
  while (!rest.empty()) {
    const std::size_t comma = std::min(rest.find(','), rest.size());
    const std::string asked(trimmed(rest.substr(0, comma))), word = lower(asked);
    rest.remove_prefix(std::min(comma + 1, rest.size()));
    bool found = false;
    for (std::size_t i = 0; i < chosen.size(); ++i) {
      if (is_layer(word, artwork.layers[i], i)) chosen[i] = found = true;
    }
    if (!found)
      throw InputError(fmt::format("{}: no layer '{}'; there are {}", artwork.name, asked,
                                   fmt::join(artwork.layers, ", ")));
  }
  std::erase_if(artwork.strokes, [&](const Stroke& stroke) { return !chosen[stroke.layer]; });
  std::erase_if(artwork.areas, [&](const Area& area) { return !chosen[area.layer]; });
  drop_empty_layers(artwork, true);
}

}  // namespace impedraw
