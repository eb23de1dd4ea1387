// Stroke files and CSV. The first byte holds the settings; the rest is the file.
#include "fuzz.h"
#include "impedraw/drawing/stroke_file.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace impedraw;
  fuzz::Input input(data, size);
  const std::uint8_t settings = input.byte();
  const PageUnit units[] = {PageUnit::file, PageUnit::mm, PageUnit::in, PageUnit::m};
  return fuzz::expect_value_or_input_error([&] {
    parse_strokes(input.rest(), "fuzz.strokes", settings & 1,
                  {.unit = units[settings >> 1 & 3], .may_be_empty = (settings & 8) != 0});
  });
}
