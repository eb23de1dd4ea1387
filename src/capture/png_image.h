// Images of a capture, as PNG files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

namespace impedraw {

struct GreyImage {
  int width = 0, height = 0;          // [px]
  std::vector<std::uint16_t> values;  // row by row
};

struct ColourImage {
  int width = 0, height = 0;      // [px]
  std::vector<std::uint8_t> rgb;  // three bytes a pixel, row by row
};

// A 16-bit grey PNG, values as they stand in the file. Throws InputError for any other kind, and
// for a file that is damaged, cut short or larger than 8192 px on a side.
GreyImage read_grey_png(const std::filesystem::path& file);

// A PNG of any kind, as 8-bit RGB.
ColourImage read_colour_png(const std::filesystem::path& file);

// Throws std::runtime_error if the file cannot be written.
void write_grey_png(const std::filesystem::path& file, const GreyImage& image);

}  // namespace impedraw
