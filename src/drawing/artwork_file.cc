#include "drawing/artwork_file.h"

#include <fmt/core.h>

#include "common/errors.h"
#include "common/file_extension.h"
#include "drawing/stroke_file.h"

namespace impedraw {

bool is_artwork_file(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  return extension == ".svg" || extension == ".txt" || extension == ".strokes" || extension == ".csv";
}

Artwork read_artwork(const std::filesystem::path& file, const SvgSettings& settings) {
  if (!is_artwork_file(file)) {
    throw InputError(fmt::format("{}: not a kind of artwork; valid are .svg, .txt, .strokes, .csv", file.string()));
  }
  if (lower_extension(file) == ".svg") return read_svg(file, settings);
  return read_strokes(file, {.may_be_empty = settings.may_be_empty});
}

}  // namespace impedraw
