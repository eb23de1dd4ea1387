// Where the pen left ink, and when the plan was drawing which stroke: rows of a log cut into
// ranges.
//
// Ink      f > 0.1 N, f = contact force · outward normal of the canvas
// Stroke   s ≥ 0 from the instant the desired point leaves the stroke's first point until it
//          reaches
//          its last, else −1 (from the plan alone)
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace impedraw {

inline constexpr double kInkForce = 0.1;  // [N]

// f so small, or not a number (out of contact), leaves nothing.
inline bool is_ink(double f) { return f > kInkForce; }

// One line of ink: consecutive rows [begin, end), all with ink and all of one stroke (−1: drawn
// while the plan was drawing none).
struct InkLine {
  int stroke = -1;
  std::size_t begin = 0, end = 0;
};

std::vector<InkLine> ink_lines(std::span<const double> f, std::span<const int> stroke);

// One pass over a stroke of the plan: rows [begin, end). A stroke that comes back later, to be
// drawn again or to its end, has one for each.
//
// Its first touch is the first row with ink from the end of the pass before (of whatever stroke)
// on, or from 2 s before its own start where that is later; none if there is no ink until the pass
// ends. The pen may touch before the pass begins, while it approaches.
struct StrokeSpan {
  int stroke = 0;
  std::size_t begin = 0, end = 0;
  std::optional<std::size_t> first_touch;
};

// `time` [s] must not decrease. The three have one length.
std::vector<StrokeSpan> stroke_spans(std::span<const double> time, std::span<const double> f,
                                     std::span<const int> stroke);

}  // namespace impedraw
