// Artwork from a file, of the kind that its extension says: .svg (svg.h), .txt, .strokes and .csv
// (stroke_file.h).
#pragma once

#include <filesystem>

#include "impedraw/drawing/stroke.h"
#include "impedraw/drawing/stroke_file.h"
#include "impedraw/drawing/svg.h"

namespace impedraw {

bool is_artwork_file(const std::filesystem::path& file);  // by its extension, in capitals or not

// `unit`: of a stroke file's numbers. InputError: of the reader, an extension that is none of
// these, a unit for an SVG, which has its own.
Artwork read_artwork(const std::filesystem::path& file, const SvgSettings& settings = {},
                     PageUnit unit = PageUnit::file);

}  // namespace impedraw
