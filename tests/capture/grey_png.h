// Writes 16-bit grey PNGs, as depth cameras leave them.
#pragma once

#include <filesystem>
#include <fstream>
#include <string>

#include <png.h>

#include "impedraw/capture/capture.h"

namespace impedraw {

inline void write_grey_png(const std::filesystem::path& file, const GreyImage& image) {
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
  png_infop info = png_create_info_struct(png);
  std::string content;
  png_set_write_fn(
      png, &content,
      [](png_structp p, png_bytep bytes, std::size_t count) {
        static_cast<std::string*>(png_get_io_ptr(p))
            ->append(reinterpret_cast<const char*>(bytes), count);
      },
      nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.width),
               static_cast<png_uint_32>(image.height), 16, PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  png_set_swap(png);
  for (int j = 0; j < image.height; ++j)
    png_write_row(png, reinterpret_cast<png_const_bytep>(
                           image.values.data() + static_cast<std::size_t>(j) * image.width));
  png_write_end(png, nullptr);
  png_destroy_write_struct(&png, &info);
  std::ofstream(file, std::ios::binary) << content;
}

}  // namespace impedraw
