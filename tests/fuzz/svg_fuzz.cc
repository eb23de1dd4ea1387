// SVG documents, with the dashes and fills that they ask for.
#include "fuzz.h"
#include "impedraw/drawing/dashes.h"
#include "impedraw/drawing/hatch.h"
#include "impedraw/drawing/svg.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace impedraw;
  return fuzz::expect_value_or_input_error([&] {
    const std::string_view document(reinterpret_cast<const char*>(data), size);
    Artwork artwork = parse_svg(document, "fuzz.svg");
    artwork.strokes = dashed(artwork.strokes, artwork.dashes);
    apply_hatch(artwork, {.spacing_mm = 5}, 1);
  });
}
