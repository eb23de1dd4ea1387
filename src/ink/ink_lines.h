// Splits the rows of a log into ranges, by ink and by planned stroke.
//
// Ink      f > 0.1 N, f = contact force · outward normal of the canvas
// Stroke   s ≥ 0 from the instant the desired point leaves the stroke's first point until it
//          reaches its last, else −1 (from the plan alone)
#pragma once

#include <algorithm>
#include <cstddef>
#include <optional>
#include <span>
#include <vector>

namespace impedraw {

inline constexpr double kInkForce = 0.1;  // [N]

// A smaller f, or NaN (no contact), leaves no ink.
inline bool is_ink(double f) { return f > kInkForce; }

// One line of ink: consecutive rows [begin, end), all with ink and all of the same stroke (−1: no
// planned stroke).
struct InkLine {
  int stroke = -1;
  std::size_t begin = 0, end = 0;
};

inline std::vector<InkLine> ink_lines(std::span<const double> f, std::span<const int> stroke) {
  std::vector<InkLine> lines;
  bool open = false;
  for (std::size_t i = 0; i < f.size(); ++i) {
    if (!is_ink(f[i])) {
      open = false;
    } else if (open && lines.back().stroke == stroke[i]) {
      lines.back().end = i + 1;
    } else {
      lines.push_back({stroke[i], i, i + 1});
      open = true;
    }
  }
  return lines;
}

// One pass over a planned stroke: rows [begin, end). A stroke that is resumed or drawn again has
// one span per pass.
//
// The first touch is the first row with ink after the end of the previous pass (of any stroke), but
// no earlier than 2 s before this pass begins; none if there is no ink until the pass ends. The pen
// may touch during the approach, before the pass begins.
struct StrokeSpan {
  int stroke = 0;
  std::size_t begin = 0, end = 0;
  std::optional<std::size_t> first_touch;
};

// `time` [s] must not decrease. All three must have the same length.
inline std::vector<StrokeSpan> stroke_spans(std::span<const double> time, std::span<const double> f,
                                            std::span<const int> stroke) {
  constexpr double kEarliest = 2.0;  // [s] before the stroke's start
  std::vector<StrokeSpan> spans;
  for (std::size_t i = 0; i < stroke.size(); ++i) {
    if (stroke[i] < 0) continue;
    if (!spans.empty() && spans.back().stroke == stroke[i] && spans.back().end == i) {
      spans.back().end = i + 1;
    } else {
      spans.push_back({stroke[i], i, i + 1, std::nullopt});
    }
  }
  std::size_t before = 0;  // end of the previous stroke
  for (StrokeSpan& span : spans) {
    const double earliest = time[span.begin] - kEarliest - 1e-9;
    std::size_t i =
        std::lower_bound(time.begin() + before, time.begin() + span.begin, earliest) - time.begin();
    while (i < span.end && !is_ink(f[i])) ++i;
    if (i < span.end) span.first_touch = i;
    before = span.end;
  }
  return spans;
}

}  // namespace impedraw
