// drawn_strokes [--ordered] FILE…: what read_svg() and dashed() draw of each, a line of JSON a
// file; with --ordered as a plan would draw it.
#include <cstdio>
#include <string_view>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/dashes.h"
#include "impedraw/drawing/joined.h"
#include "impedraw/drawing/order.h"
#include "impedraw/drawing/svg.h"

namespace {

void print(const char* file, bool ordered) {
  const impedraw::Artwork artwork = impedraw::read_svg(file, {.may_be_empty = true});
  const Eigen::Vector2d page = artwork.page.sizes();
  fmt::print("{{\"page\":[{:.9g},{:.9g}],\"strokes\":[", page.x(), page.y());
  const char* between = "";
  std::vector<impedraw::Stroke> strokes = impedraw::dashed(artwork.strokes, artwork.dashes);
  if (ordered) {
    strokes = impedraw::joined(std::move(strokes));
    strokes = in_order(strokes, impedraw::shortest_order(strokes));
  }
  for (const impedraw::Stroke& stroke : strokes) {
    fmt::print("{}{{\"edge\":{},\"colour\":{},\"width\":{:.6g},\"points\":[", between, stroke.edge,
               stroke.colour, stroke.edge ? 0.0 : stroke.width);
    between = "";
    for (const Eigen::Vector2d& p : stroke.points) {
      fmt::print("{}[{:.9g},{:.9g}]", between, p.x(), p.y());
      between = ",";
    }
    fmt::print("]}}");
    between = ",";
  }
  fmt::print("]}}\n");
}

}  // namespace

int main(int argc, char** argv) {
  const bool ordered = argc > 1 && std::string_view(argv[1]) == "--ordered";
  for (int i = 1 + ordered; i < argc; ++i) {
    try {
      print(argv[i], ordered);
    } catch (const impedraw::InputError& error) {
      std::fprintf(stderr, "%s\n", error.what());
      std::puts("null");
    }
    std::fflush(stdout);
  }
}
