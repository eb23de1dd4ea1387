#include "impedraw/capture/png_image.h"

#include <csetjmp>
#include <cstring>
#include <string>

#include <fmt/format.h>
#include <png.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/input_file.h"
#include "impedraw/files/durable_file.h"

namespace impedraw {

namespace {

constexpr png_uint_32 kMostSide = 8192;            // [px]
constexpr std::size_t kMostPngBytes = 512u << 20;  // of a file

// libpng reports errors by longjmp: no object with a destructor may live in the function that it
// jumps out of, so that what is read stands here.
struct PngReading {
  std::string content;
  std::size_t at = 0;
  std::string error;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::vector<png_byte> rows;
  std::vector<png_bytep> row_starts;

  ~PngReading() { png_destroy_read_struct(&png, &info, nullptr); }
};

void png_failed(png_structp png, png_const_charp message) {
  static_cast<PngReading*>(png_get_error_ptr(png))->error = message;
  longjmp(png_jmpbuf(png), 1);
}

void png_warned(png_structp, png_const_charp) {}

void png_wants(png_structp png, png_bytep to, std::size_t count) {
  auto* reading = static_cast<PngReading*>(png_get_io_ptr(png));
  if (count > reading->content.size() - reading->at) png_error(png, "the file ends too early");
  std::memcpy(to, reading->content.data() + reading->at, count);
  reading->at += count;
}

// Reads rows of `bytes` a pixel. Returns false, with reading->error, if the file is damaged.
bool read_rows(PngReading* r, bool grey) {
  if (setjmp(png_jmpbuf(r->png))) return false;
  png_set_user_limits(r->png, kMostSide, kMostSide);
  png_set_read_fn(r->png, r, png_wants);
  png_read_info(r->png, r->info);
  const int depth = png_get_bit_depth(r->png, r->info);
  const int kind = png_get_color_type(r->png, r->info);
  if (grey) {
    if (kind != PNG_COLOR_TYPE_GRAY || depth != 16) png_error(r->png, "is no 16-bit grey image");
    png_set_swap(r->png);  // PNG is big-endian
  } else {
    png_set_expand(r->png);
    png_set_strip_16(r->png);
    png_set_strip_alpha(r->png);
    png_set_gray_to_rgb(r->png);
  }
  png_set_interlace_handling(r->png);
  png_read_update_info(r->png, r->info);
  const std::size_t row = png_get_rowbytes(r->png, r->info);
  const png_uint_32 height = png_get_image_height(r->png, r->info);
  r->rows.resize(row * height);
  r->row_starts.resize(height);
  for (png_uint_32 i = 0; i < height; ++i) r->row_starts[i] = r->rows.data() + i * row;
  png_read_image(r->png, r->row_starts.data());
  png_read_end(r->png, nullptr);
  return true;
}

void read_png(const std::filesystem::path& file, bool grey, PngReading* reading) {
  const InputFile input(file);
  if (input.size() > kMostPngBytes)
    throw InputError(fmt::format("{}: has {} bytes, at most {} are read", file.string(),
                                 input.size(), kMostPngBytes));
  reading->content = input.read(kMostPngBytes);
  const auto* start = reinterpret_cast<png_const_bytep>(reading->content.data());
  if (reading->content.size() < 8 || png_sig_cmp(start, 0, 8) != 0)
    throw InputError(file.string() + ": is no PNG image");
  reading->png = png_create_read_struct(PNG_LIBPNG_VER_STRING, reading, png_failed, png_warned);
  reading->info = reading->png ? png_create_info_struct(reading->png) : nullptr;
  if (!reading->info) throw std::bad_alloc();
  if (!read_rows(reading, grey))
    throw InputError(fmt::format("{}: {}", file.string(), reading->error));
}

}  // namespace

GreyImage read_grey_png(const std::filesystem::path& file) {
  PngReading reading;
  read_png(file, true, &reading);
  GreyImage image{static_cast<int>(png_get_image_width(reading.png, reading.info)),
                  static_cast<int>(png_get_image_height(reading.png, reading.info)),
                  {}};
  image.values.resize(reading.rows.size() / 2);
  std::memcpy(image.values.data(), reading.rows.data(), reading.rows.size());
  return image;
}

ColourImage read_colour_png(const std::filesystem::path& file) {
  PngReading reading;
  read_png(file, false, &reading);
  return {static_cast<int>(png_get_image_width(reading.png, reading.info)),
          static_cast<int>(png_get_image_height(reading.png, reading.info)),
          std::move(reading.rows)};
}

void write_grey_png(const std::filesystem::path& file, const GreyImage& image) {
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
  write_whole(file, content);
}

}  // namespace impedraw
