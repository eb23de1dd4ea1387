#include "impedraw/drawing/picture.h"

#include <algorithm>
#include <mutex>
#include <utility>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/file_extension.h"
#include "impedraw/common/input_file.h"
#include "impedraw/drawing/stroke_file.h"
#include "impedraw/files/data_folder.h"
#include "impedraw/files/run_python.h"

namespace impedraw {

namespace {

namespace fs = std::filesystem;

const char* name_of(PictureStyle style) {
  switch (style) {
    case PictureStyle::stipple:
      return "stipple";
    case PictureStyle::hatch:
      return "hatch";
    case PictureStyle::cross_hatch:
      return "cross-hatch";
    case PictureStyle::flow:
      return "flow";
    case PictureStyle::contour:
      return "contour";
    case PictureStyle::trace:
      return "trace";
  }
  return "";
}

// Of the source tree's extra, which ./impedraw installs; else the one that runs the package.
fs::path interpreter(const std::string& name) {
  std::error_code error;
  if (!fs::exists(data_folder() / "setup/extra.sh", error)) return python_interpreter();
  const fs::path python = data_folder() / "build/image-venv/bin/python";
  if (!fs::exists(python, error))
    throw InputError(
        fmt::format("{}: pictures need SciPy, scikit-image and Pillow; bash setup/extra.sh image "
                    "installs them",
                    name));
  return python;
}

struct Made {
  Artwork artwork;
  std::string said;  // about it, in one line
};

// What impedraw.image makes of the input, a picture or areas.
Made make_strokes(const std::string& name, const MemoryFile& input,
                  const std::vector<std::string>& options) {
  const MemoryFile strokes, said;
  std::vector<std::string> words = {"-m",    "impedraw.image", "/dev/fd/3", "--out", "/dev/fd/4",
                                    "--name", name};
  words.insert(words.end(), options.begin(), options.end());
  const int code = run_python({.python = interpreter(name).string(),
                               .arguments = words,
                               .files = {{&input, 3}, {&strokes, 4}, {&said, 1}}});
  std::string line = said.content();
  line.resize(std::min(line.size(), line.find('\n')));
  if (code != 0)
    throw InputError(
        line.empty() ? fmt::format("{}: the program for pictures ended with {}", name, code) : line);
  return {parse_strokes(strokes.content(), name, true, {.unit = PageUnit::mm, .may_be_empty = true}),
          line};
}

}  // namespace

bool is_picture_file(const fs::path& file) {
  const std::string extension = lower_extension(file);
  return extension == ".png" || extension == ".jpg" || extension == ".jpeg";
}

Artwork read_picture(const fs::path& file, const ImageSettings& s) {
  constexpr double kLargestMb = 512;
  const InputFile in(file);
  if (static_cast<double>(in.size()) > 1e6 * kLargestMb)
    throw InputError(fmt::format("{}: {:.0f} MB; a picture may have up to {:.0f} MB", file.string(),
                                 static_cast<double>(in.size()) / 1e6, kLargestMb));
  std::string content = in.read(static_cast<std::size_t>(1e6 * kLargestMb));
  std::vector<std::string> options = {"--style",  name_of(s.style),
                                      "--size",   fmt::format("{}", s.size_mm),
                                      "--pen",    fmt::format("{}", s.pen_mm),
                                      "--points", fmt::format("{}", s.points),
                                      fmt::format("--angle={}", s.angle_deg)};
  static std::mutex mutex;
  static std::pair<std::string, std::vector<std::string>> last;
  static Artwork kept;
  const std::scoped_lock lock(mutex);
  std::pair key{std::move(content), std::move(options)};
  if (kept.strokes.empty() || key != last) {
    Made made = make_strokes(file.string(), MemoryFile(key.first), key.second);
    kept = std::move(made.artwork);
    kept.layers = {"picture"};
    kept.warnings = {std::move(made.said)};
    last = std::move(key);
  }
  Artwork artwork = kept;
  artwork.name = file.string();
  return artwork;
}

void trace_areas(Artwork& artwork, bool text) {
  if (!text) std::erase_if(artwork.strokes, [](const Stroke& stroke) { return stroke.edge; });
  // One layer at a time: a layer's lines are its own.
  for (int layer = 0; layer < static_cast<int>(artwork.layers.size()); ++layer) {
    std::string areas;
    std::uint32_t colour = 0;
    for (const Area& area : artwork.areas) {
      if (area.layer != layer || (text && !area.text)) continue;
      colour = area.colour;
      areas += fmt::format(R"({}{{"even_odd":{},"outlines":[)", areas.empty() ? "[" : ",",
                           area.even_odd);
      for (std::size_t i = 0; i < area.outlines.size(); ++i) {
        areas += i > 0 ? ",[" : "[";
        for (std::size_t k = 0; k < area.outlines[i].size(); ++k)
          areas += fmt::format("{}[{},{}]", k > 0 ? "," : "", area.outlines[i][k].x(),
                               area.outlines[i][k].y());
        areas += "]";
      }
      areas += "]}";
    }
    if (areas.empty()) continue;
    Made made = make_strokes(artwork.name, MemoryFile(areas + "]"), {"--areas"});
    for (Stroke& stroke : made.artwork.strokes) {
      stroke.layer = layer;
      stroke.colour = colour;
      artwork.strokes.push_back(std::move(stroke));
    }
    artwork.warnings.push_back(fmt::format("layer {}: {}", artwork.layers[layer], made.said));
  }
  std::erase_if(artwork.areas, [&](const Area& area) { return !text || area.text; });
  drop_empty_layers(artwork, true);
}

}  // namespace impedraw
