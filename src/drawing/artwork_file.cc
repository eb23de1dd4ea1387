#include "impedraw/drawing/artwork_file.h"

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/file_extension.h"

namespace impedraw {

bool is_artwork_file(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  return extension.starts_with(".svg") || extension == ".txt" || extension == ".strokes" ||
         extension == ".csv";
}

Artwork read_artwork(const std::filesystem::path& file, const SvgSettings& settings,
                     PageUnit unit) {
  const std::string extension = lower_extension(file);
  if (extension == ".png" || extension == ".jpg" || extension == ".jpeg")
    throw InputError(
        fmt::format("{}: a picture; --image in place of --svg draws it by lines that "
                    "show its tone",
                    file.string()));
  if (!is_artwork_file(file)) {
    throw InputError(fmt::format("{}: not a kind of artwork; valid are .svg, .txt, .strokes, .csv",
                                 file.string()));
  }
  if (!extension.starts_with(".svg"))  // .svgz is named by its reader
    return read_strokes(file, {.unit = unit, .may_be_empty = settings.may_be_empty});
  if (unit != PageUnit::file)
    throw InputError(
        fmt::format("{}: an SVG defines its own unit; the only valid unit is file", file.string()));
  return read_svg(file, settings);
}

}  // namespace impedraw
