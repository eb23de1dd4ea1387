#include "impedraw/drawing/joined.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <utility>

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/order.h"
#include "impedraw/drawing/polyline.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

bool alike(const Stroke& a, const Stroke& b) {
  return a.layer == b.layer && a.dash == b.dash && a.edge == b.edge && a.colour == b.colour &&
         a.width == b.width && a.press.empty() == b.press.empty() && a.by_force == b.by_force;
}

class Joiner {
 public:
  explicit Joiner(std::vector<Stroke>& strokes) : strokes_(strokes), taken_(strokes.size(), 0) {
    for (std::size_t s = 0; s < strokes.size(); ++s) {
      if (strokes[s].closed || strokes[s].points.size() < 2) continue;
      for (const bool last : {false, true}) ends_[cell(end(s, last))].push_back({s, last});
    }
  }

  std::vector<Stroke> all() {
    std::vector<Stroke> lines;
    for (std::size_t s = 0; s < strokes_.size(); ++s) {
      if (std::exchange(taken_[s], 1)) continue;
      Stroke line = std::move(strokes_[s]);
      if (!line.closed && line.points.size() > 1) {
        extend(line);
        reverse(line);
        extend(line);
        reverse(line);
      }
      lines.push_back(std::move(line));
    }
    return lines;
  }

 private:
  using Cell = std::pair<long, long>;
  struct End {
    std::size_t stroke;
    bool last;
  };

  static Cell cell(const Vector2d& p) {
    return {std::lround(p.x() / kJoined), std::lround(p.y() / kJoined)};
  }
  const Vector2d& end(std::size_t s, bool last) const {
    return last ? strokes_[s].points.back() : strokes_[s].points.front();
  }

  // The end that `line` goes on at; null if there is none.
  const End* next(const Stroke& line) const {
    const Vector2d p = line.points.back(), before = *(line.points.end() - 2);
    const auto [i, j] = cell(p);
    const End* best = nullptr;
    double most = -2.0;
    for (long x = i - 1; x <= i + 1; ++x)
      for (long y = j - 1; y <= j + 1; ++y) {
        const auto found = ends_.find({x, y});
        if (found == ends_.end()) continue;
        for (const End& e : found->second) {
          if (taken_[e.stroke] || !alike(line, strokes_[e.stroke])) continue;
          const std::vector<Vector2d>& q = strokes_[e.stroke].points;
          if ((end(e.stroke, e.last) - p).norm() > kJoined) continue;
          const Vector2d on = e.last ? *(q.end() - 2) - q.back() : q[1] - q[0];
          const double cosine = on.normalized().dot((p - before).normalized());
          if (cosine <= most) continue;
          most = cosine;
          best = &e;
        }
      }
    return best;
  }

  void extend(Stroke& line) {
    while (const End* found = next(line)) {
      taken_[found->stroke] = 1;
      Stroke& piece = strokes_[found->stroke];
      if (found->last) reverse(piece);
      const auto same = static_cast<std::ptrdiff_t>(piece.points.front() == line.points.back());
      line.points.insert(line.points.end(), piece.points.begin() + same, piece.points.end());
      if (!line.press.empty())
        line.press.insert(line.press.end(), piece.press.begin() + same, piece.press.end());
      piece = {};
    }
    line.closed = line.points.front() == line.points.back() && line.press.empty();
  }

  std::vector<Stroke>& strokes_;
  std::vector<char> taken_;
  std::map<Cell, std::vector<End>> ends_;
};

}  // namespace

std::vector<Stroke> joined(std::vector<Stroke> strokes) { return Joiner(strokes).all(); }

}  // namespace impedraw
