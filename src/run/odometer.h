// Measures progress along a path: strokes begun and pen-down length drawn.
#pragma once

#include <algorithm>
#include <vector>

#include "impedraw/planning/path/tip_path.h"
#include "impedraw/run/run.h"

namespace impedraw {

class Odometer {
 public:
  explicit Odometer(const TipPath& path) : path_(path), before_(1, 0.0) {
    for (const StrokeTimes& s : path.strokes()) before_.push_back(before_.back() + s.length);
  }
  void read(double t, RunProgress* progress) const {
    const auto& strokes = path_.strokes();
    const auto begun =
        std::upper_bound(strokes.begin(), strokes.end(), t,
                         [](double at, const StrokeTimes& s) { return at < s.approach; });
    const auto i = static_cast<std::size_t>(begun - strokes.begin());
    progress->stroke = static_cast<int>(i);
    progress->strokes = static_cast<int>(strokes.size());
    progress->length = before_.back();
    progress->drawn = before_[i];
    if (i == 0) return;
    const StrokeTimes& s = strokes[i - 1];
    const double share = s.end > s.start ? std::clamp((t - s.start) / (s.end - s.start), 0.0, 1.0)
                                         : (t >= s.end ? 1.0 : 0.0);
    progress->drawn -= (1.0 - share) * s.length;
  }

 private:
  const TipPath& path_;
  std::vector<double> before_;  // [m]
};

}  // namespace impedraw
