#include "drawing/artwork_file.h"

#include <algorithm>
#include <cctype>

#include <fmt/core.h>

#include "common/errors.h"
#include "drawing/stroke_file.h"

namespace impedraw {
namespace {

std::string extension_of(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(), [](unsigned char c) { return std::tolower(c); });
  return extension;
}

}  // namespace

bool is_artwork_file(const std::filesystem::path& file) {
  const std::string extension = extension_of(file);
  return extension == ".svg" || extension == ".txt" || extension == ".strokes" || extension == ".csv";
}

Artwork read_artwork(const std::filesystem::path& file, const SvgSettings& settings) {
  if (!is_artwork_file(file)) {
    throw InputError(fmt::format("{}: not a kind of artwork; valid are .svg, .txt, .strokes, .csv", file.string()));
  }
  if (extension_of(file) == ".svg") return read_svg(file, settings);
  return read_strokes(file, {.may_be_empty = settings.may_be_empty});
}

}  // namespace impedraw
