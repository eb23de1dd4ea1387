#include "impedraw/planning/target.h"

#include "impedraw/common/in_parallel.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
constexpr int kDeepest = 12;  // halvings below the spacing, at a fold of the canvas
// At a fold one halving follows another. A surface that is rough at any scale, as one estimated
// from noisy points, would ask for all of them everywhere.
constexpr int kMostHalvings = 4 * kDeepest;
// Points this close, seen along z, end the search for a step of the canvas [m]. Beside a steep wall
// an estimated surface may step back and forth within it.
constexpr double kClosest = 1e-5;

struct Point {
  Vector2d p_P, page;
  Vector3d on_canvas;
};

class Projection {
 public:
  Projection(const SurfaceHeight& canvas, const TargetSettings& settings, TargetLine& line)
      : canvas_(canvas), settings_(settings), line_(line) {}

  void add(const PlacedStroke& stroke) {
    number_ = stroke.number;
    Point last = projected(stroke.p_P.front(), stroke.page.front());
    push(last);
    for (std::size_t i = 1; i < stroke.p_P.size(); ++i) {
      const Point next = projected(stroke.p_P[i], stroke.page[i]);
      join(last, next, 0);
      last = next;
    }
  }

 private:
  Point projected(const Vector2d& p_P, const Vector2d& page) {
    return {p_P, page, sample_or_throw(canvas_, p_P, page, number_, last_).p_P};
  }
  void push(const Point& p) {
    line_.points.push_back(p.on_canvas);
    line_.stroke.push_back(number_);
  }

  // Appends the points after a, up to and including b.
  void join(const Point& a, const Point& b, int depth) {
    const double gap = (b.on_canvas - a.on_canvas).norm();
    if (gap == 0) return;
    const bool wide = gap > settings_.spacing;
    if (wide && (b.p_P - a.p_P).norm() < kClosest) return push(b);
    if (depth == 0) left_ = kMostHalvings;
    if (wide || (depth < kDeepest && left_ > 0)) {
      const Point middle = projected((a.p_P + b.p_P) / 2, (a.page + b.page) / 2);
      if (wide ||
          (middle.on_canvas - (a.on_canvas + b.on_canvas) / 2).norm() > settings_.tolerance) {
        if (!wide) --left_;
        join(a, middle, wide ? 0 : depth + 1);
        join(middle, b, wide ? 0 : depth + 1);
        return;
      }
    }
    push(b);
  }

  const SurfaceHeight& canvas_;
  const TargetSettings& settings_;
  TargetLine& line_;
  SurfaceHeight::Sample last_;
  int number_ = 0;
  int left_ = 0;  // halvings, within one spacing
};

}  // namespace

TargetLine project_target(const std::vector<PlacedStroke>& strokes, const SurfaceHeight& canvas,
                          const TargetSettings& settings) {
  std::vector<TargetLine> lines(strokes.size());
  in_parallel(static_cast<int>(strokes.size()), [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    if (!strokes[k].p_P.empty()) Projection(canvas, settings, lines[k]).add(strokes[k]);
  });
  TargetLine whole;
  for (const TargetLine& line : lines) {
    whole.points.insert(whole.points.end(), line.points.begin(), line.points.end());
    whole.stroke.insert(whole.stroke.end(), line.stroke.begin(), line.stroke.end());
  }
  return whole;
}

}  // namespace impedraw
