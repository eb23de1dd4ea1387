// Reads artwork from a file. The extension selects the format: .svg (svg.h), .txt, .strokes and
// .csv (stroke_file.h), or .png, .jpg and .jpeg (picture.h).
#pragma once

#include <filesystem>

#include "impedraw/drawing/picture.h"
#include "impedraw/drawing/stroke.h"
#include "impedraw/drawing/stroke_file.h"
#include "impedraw/drawing/svg.h"

namespace impedraw {

bool is_artwork_file(const std::filesystem::path& file);  // by extension, ignoring case

// `unit` is the unit of a stroke file's numbers. With the picture style trace, an SVG's areas are
// traced. InputError: an error of the reader, an unknown
// extension, or a unit for an SVG or
// a picture, which have their own.
Artwork read_artwork(const std::filesystem::path& file, const SvgSettings& settings = {},
                     PageUnit unit = PageUnit::file, const ImageSettings& picture = {});

}  // namespace impedraw
