// Artwork from a file, of the kind that its extension says: .svg (svg.h), .txt, .strokes and .csv (stroke_file.h).
#pragma once

#include <filesystem>

#include "drawing/stroke.h"
#include "drawing/svg.h"

namespace impedraw {

bool is_artwork_file(const std::filesystem::path& file);  // by its extension, in capitals or not

// InputError: of the reader, or an extension that is none of these.
Artwork read_artwork(const std::filesystem::path& file, const SvgSettings& settings = {});

}  // namespace impedraw
