// C ABI of the Rust library in this folder. It reads an SVG document and returns its visible
// outlines as flat arrays.
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

// The part of what lies beneath that a fill hides. A veil is white and lets show what lies beneath,
// on which its edge is seen.
enum ImpedrawSvgHides : std::uint8_t {
  IMPEDRAW_SVG_NOTHING = 0,
  IMPEDRAW_SVG_BENEATH = 1,
  IMPEDRAW_SVG_WHITE_STROKE = 2,  // what lies beneath, as a white stroke's area
  IMPEDRAW_SVG_VEIL = 3,
};

// One visible path element, in painting order, or a shape of a clip path or mask. Its verbs and
// points follow those of the previous path.
struct ImpedrawSvgPath {
  std::size_t verbs;  // how many
  std::uint32_t layer;
  std::uint8_t stroked;
  std::uint8_t filled;
  std::uint8_t caps;      // round or square line caps: a subpath without length is a dot
  std::uint8_t even_odd;  // fill rule; else nonzero
  ImpedrawSvgHides hides;
  std::uint32_t fill, stroke;  // colours, 0xRRGGBB; a gradient's is the mean of its stops
  double width;                // of the stroke [mm]
  std::size_t hides_from;   // the first path that it hides: a faint group hides nothing around it
  std::uint8_t covers;      // the stroke hides what lies beneath its width
  std::size_t covers_from;  // the first path that it hides
  std::uint32_t group;      // ImpedrawSvg::groups, counted from 1, around it; 0: none
  double soft;              // deviation of a blur that leaves it no edge [mm]; else 0
  float opacity, stroke_opacity;  // of the fill and the stroke, without that of groups
  std::uint8_t shaded[2];         // fill and stroke have a gradient: impedraw_svg_shade()
  std::uint32_t clip;             // ImpedrawSvg::clips, counted from 1, that cuts it; 0: none
  std::uint32_t shapes;           // the clip that it is a part of, counted from 1; 0: it is painted
  float value, alpha;             // of a mask's shape: luminance and opacity
  std::size_t dash_count;         // of ImpedrawSvg::dashes, even; 0: unbroken
  double dash_offset;             // like the dashes, in the unit before the transform
  double path_length;   // what the dashes take the path's whole length for; NaN: that length
  double transform[4];  // rows of the 2 × 2 matrix from that unit to millimetres on the page
  // A letter of a text and a mark on it, in Unicode; 0: none. Its points are where its advance
  // starts and ends on the baseline, and the first one raised by the height of the capitals.
  std::uint32_t letter[2];
};

// A clip path shows the union of its shapes. A mask shows where its shapes, painted in order, are
// lighter than one half.
struct ImpedrawSvgClip {
  std::uint32_t parent;  // cuts it, counted from 1; 0: none
  std::uint8_t mask;
};

// A group that is painted as a whole: its opacity, and how it mixes with what lies beneath, as usvg
// counts its blend modes.
struct ImpedrawSvgGroup {
  std::uint32_t parent;  // counted from 1; 0: none
  float opacity;
  std::uint8_t blend;
};

struct ImpedrawSvg {
  const char* error;  // null on success; else one line, and the rest is empty
  double width_mm, height_mm;
  const ImpedrawSvgPath* paths;
  std::size_t path_count;
  const ImpedrawSvgClip* clips;
  std::size_t clip_count;
  const ImpedrawSvgGroup* groups;
  std::size_t group_count;
  const std::uint8_t* verbs;
  const double* points;  // x, y [mm] on the page, every transform applied; 1 px = 1/96 inch
  // alternating lengths drawn and left out; each path's follow those of the previous path
  const double* dashes;
  const char* const* layers;
  std::size_t layer_count;
  std::uint8_t named;  // a layer has a name of the author's
  const char* const* warnings;
  std::size_t warning_count;
};

// Never returns null, never throws. Free the result with impedraw_svg_free().
const ImpedrawSvg* impedraw_svg_read(const std::uint8_t* data, std::size_t size) noexcept;
// The same, with letters in place of the outlines of text.
const ImpedrawSvg* impedraw_svg_letters(const std::uint8_t* data, std::size_t size) noexcept;
// An SVG 1.1 font: no paths; the warnings are a document with a layer glyph-N for each character N
// that has lines, y up as in fonts; the capitals' height (0: not given); and for each character its
// number and its advance. In the font's units, px of the document.
const ImpedrawSvg* impedraw_svg_font(const std::uint8_t* data, std::size_t size) noexcept;
// Red, green, blue and opacity, from 0 to 1, of a path's gradient at a place [mm].
void impedraw_svg_shade(const ImpedrawSvg* svg, std::size_t path, std::uint8_t of_stroke, double x,
                        double y, float* rgba) noexcept;
void impedraw_svg_free(const ImpedrawSvg* svg) noexcept;

}  // extern "C"
