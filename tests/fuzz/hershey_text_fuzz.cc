// Text in single strokes. The first byte says what the rest is: 'f', a font file; else a text.
#include "fuzz.h"
#include "impedraw/drawing/letters.h"
#include "impedraw/drawing/text.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace impedraw;
  fuzz::Input input(data, size);
  const std::uint8_t kind = input.byte();
  const TextAlign aligns[] = {TextAlign::left, TextAlign::centre, TextAlign::right};
  return fuzz::expect_value_or_input_error([&] {
    if (kind == 'f') {
      const HersheyFont font = parse_jhf(input.rest(), "fuzz");
      for (char32_t letter = 0; letter < 0x180; ++letter) glyph_of(font, letter, U"\u0301\u0327");
    } else {
      TextSettings text;
      text.text = input.rest();
      text.align = aligns[kind % 3];
      make_text(text);
    }
  });
}
