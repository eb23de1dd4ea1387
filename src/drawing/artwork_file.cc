#include "impedraw/drawing/artwork_file.h"

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/file_extension.h"

namespace impedraw {

bool is_artwork_file(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  return extension == ".svg" || extension == ".txt" || extension == ".strokes" ||
         extension == ".csv" || is_picture_file(file);
}

Artwork read_artwork(const std::filesystem::path& file, const SvgSettings& settings, PageUnit unit,
                     const ImageSettings& picture) {
  if (!is_artwork_file(file)) {
    throw InputError(
        fmt::format("{}: not a kind of artwork; valid are .svg, .txt, .strokes, .csv, "
                    ".png, .jpg",
                    file.string()));
  }
  const bool picture_file = is_picture_file(file);
  if (!picture_file && lower_extension(file) != ".svg")
    return read_strokes(file, {.unit = unit, .may_be_empty = settings.may_be_empty});
  if (unit != PageUnit::file)
    throw InputError(fmt::format("{}: {} defines its own unit; the only valid unit is file",
                                 file.string(), picture_file ? "a picture" : "an SVG"));
  if (picture_file) return read_picture(file, picture);
  const bool trace = picture.style == PictureStyle::trace;
  if (!trace && settings.text_as != TextAs::centre) return read_svg(file, settings);
  SvgSettings open = settings;
  open.may_be_empty = true;
  Artwork artwork = read_svg(file, open);
  trace_areas(artwork, !trace);
  if (artwork.strokes.empty() && !settings.may_be_empty)
    throw InputError(
        fmt::format("{}: has nothing to draw: no area has a centre line", file.string()));
  return artwork;
}

}  // namespace impedraw
