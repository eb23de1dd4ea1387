// C ABI of the Rust library in this folder: an SVG document in, its visible outlines as flat arrays
// out.
#pragma once

#include <cstddef>
#include <cstdint>

extern "C" {

enum ImpedrawSvgVerb : std::uint8_t {  // points taken: 1, 1, 2, 3, 0
  IMPEDRAW_SVG_MOVE = 0,
  IMPEDRAW_SVG_LINE = 1,
  IMPEDRAW_SVG_QUAD = 2,
  IMPEDRAW_SVG_CUBIC = 3,
  IMPEDRAW_SVG_CLOSE = 4,
};

// One visible path element. Its verbs and points follow those of the path before.
struct ImpedrawSvgPath {
  std::size_t verbs;  // how many
  std::uint32_t layer;
  std::uint8_t stroked;
  std::uint8_t filled;
  std::uint8_t caps;       // line caps that make a dot of a subpath without length (round, square)
  std::uint8_t even_odd;   // fill rule; else nonzero
  std::uint8_t white;      // filled with white
  std::size_t dash_count;  // of ImpedrawSvg::dashes, even; 0: unbroken
  double dash_offset;      // as the dashes, in the unit before the transform
  double transform[4];     // rows of the 2 × 2 matrix from that unit to millimetres on the page
};

struct ImpedrawSvg {
  const char* error;  // null if the document was read; one line otherwise, and all else is empty
  double width_mm, height_mm;
  const ImpedrawSvgPath* paths;
  std::size_t path_count;
  const std::uint8_t* verbs;
  const double* points;  // x, y [mm] on the page, every transform applied; 1 px = 1/96 inch
  const double*
      dashes;  // lengths drawn and left out in turn; each path's follow those of the path before
  const char* const* layers;
  std::size_t layer_count;
  const char* const* warnings;
  std::size_t warning_count;
};

// Never null, never throws. To be given back to impedraw_svg_free.
const ImpedrawSvg* impedraw_svg_read(const std::uint8_t* data, std::size_t size) noexcept;
void impedraw_svg_free(const ImpedrawSvg* svg) noexcept;

}  // extern "C"
