// Reads artwork from a file. The extension selects the format: .svg (svg.h), or .txt, .strokes
// and .csv (stroke_file.h).
#pragma once

#include <filesystem>

#include "impedraw/drawing/stroke.h"
#include "impedraw/drawing/stroke_file.h"
#include "impedraw/drawing/svg.h"

namespace impedraw {

bool is_artwork_file(const std::filesystem::path& file);  // by extension, ignoring case

// `unit` is the unit of a stroke file's numbers. InputError: an error of the reader, an unknown
// extension, or a unit for an SVG, which has its own.
Artwork read_artwork(const std::filesystem::path& file, const SvgSettings& settings = {},
                     PageUnit unit = PageUnit::file);

}  // namespace impedraw
