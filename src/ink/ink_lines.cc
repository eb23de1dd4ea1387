#include "impedraw/ink/ink_lines.h"

#include <algorithm>

namespace impedraw {

std::vector<InkLine> ink_lines(std::span<const double> f, std::span<const int> stroke) {
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

std::vector<StrokeSpan> stroke_spans(std::span<const double> time, std::span<const double> f,
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
