// Reads artwork from a file. The extension selects the format: .svg (svg.h), or .txt, .strokes
// and .csv (stroke_file.h).
#pragma once

#include <filesystem>

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/file_extension.h"
#include "impedraw/drawing/stroke.h"
#include "impedraw/drawing/stroke_file.h"
#include "impedraw/drawing/svg.h"

namespace impedraw {

// By extension, ignoring case.
inline bool is_artwork_file(const std::filesystem::path& file) {
  const std::string extension = lower_extension(file);
  return extension.starts_with(".svg") || extension == ".txt" || extension == ".strokes" ||
         extension == ".csv";
}

// `unit` is the unit of a stroke file's numbers. InputError: an error of the reader, an unknown
// extension, or a unit for an SVG, which has its own.
inline Artwork read_artwork(const std::filesystem::path& file, const SvgSettings& settings = {},
                            PageUnit unit = PageUnit::file) {
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
