#include "impedraw/drawing/hatch_rows.h"

#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "impedraw/drawing/line_pieces.h"
#include "impedraw/drawing/polyline.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Line = std::vector<Vector2d>;
constexpr double kShortest = 1e-5;  // [mm]

bool is_closed(const Line& line) { return line.size() > 2 && line.front() == line.back(); }

// A closed line whose first piece begins where its last one ends was cut there by chance.
void append_pieces(std::vector<LinePiece> pieces, const HatchLine& line,
                   std::vector<HatchLine>* lines) {
  if (pieces.size() > 1 && is_closed(line.points) &&
      pieces.front().points.front() == pieces.back().points.back()) {
    Line& last = pieces.back().points;
    last.insert(last.end(), pieces.front().points.begin() + 1, pieces.front().points.end());
    std::swap(pieces.front(), pieces.back());
    pieces.pop_back();
  }
  for (LinePiece& piece : pieces)
    if (length(piece.points) > kShortest) lines->push_back({std::move(piece.points), line.row});
}

double threshold(std::int64_t row) {
  constexpr int kBits = 5;
  unsigned reversed = 0;
  for (int bit = 0; bit < kBits; ++bit)
    reversed |= (static_cast<unsigned>(row) >> bit & 1u) << (kBits - 1 - bit);
  return (reversed + 0.5) / (1 << kBits);
}

// A place where a stroke may enter a line: its first point, its last, or any if it is closed.
struct Entry {
  double way;
  std::size_t line, segment;
  Vector2d place;
};

std::optional<Entry> nearest_entry(const HatchLine& line, std::size_t number, const Vector2d& p) {
  const Line& points = line.points;
  std::optional<Entry> nearest;
  const auto consider = [&](std::size_t segment, const Vector2d& place) {
    const double way = (place - p).norm();
    if (!nearest || way < nearest->way) nearest = Entry{way, number, segment, place};
  };
  if (!is_closed(points)) {
    consider(0, points.front());
    consider(points.size() - 1, points.back());
    return nearest;
  }
  for (std::size_t i = 0; i + 1 < points.size(); ++i)
    consider(i, nearest_on_segment(points[i], points[i + 1], p));
  return nearest;
}

void append_from(const Entry& entry, Line points, Line* stroke) {
  if (!is_closed(points)) {
    if (entry.segment > 0) std::reverse(points.begin(), points.end());
  } else {
    points.pop_back();
    std::rotate(points.begin(), points.begin() + static_cast<std::ptrdiff_t>(entry.segment) + 1,
                points.end());
    points.insert(points.begin(), entry.place);
    points.push_back(entry.place);
  }
  for (const Vector2d& p : points)
    if (stroke->empty() || (p - stroke->back()).norm() > kShortest) stroke->push_back(p);
}

}  // namespace

std::vector<HatchLine> lines_inside(const std::vector<HatchLine>& lines,
                                    const RegionIndex& region) {
  std::vector<HatchLine> inside;
  for (const HatchLine& line : lines)
    append_pieces(visible_pieces(line.points, 0, {&region},
                                 [&](const Spot& spot) { return region.inside(spot.p); }),
                  line, &inside);
  return inside;
}

std::vector<HatchLine> lines_of_tone(const std::vector<HatchLine>& lines, double step,
                                     const std::function<double(const Vector2d&)>& tone) {
  std::vector<HatchLine> inked;
  for (const HatchLine& line : lines)
    append_pieces(
        pieces_where(line.points, step,
                     [&](const Vector2d& p, const auto&) { return tone(p) > threshold(line.row); }),
        line, &inked);
  return inked;
}

std::vector<Line> flowing(std::vector<HatchLine> lines, const RegionIndex& region, double inset,
                          double farthest) {
  std::map<std::int64_t, std::vector<std::size_t>> rows;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    rows[lines[i].row].push_back(i);
    Line& points = lines[i].points;
    if (is_closed(points)) continue;
    const double whole = length(points), back = std::min(inset, 0.25 * whole);
    points = line_part(points, back, whole - back);
  }
  std::vector<double> crossings;
  const auto stays_inside = [&](const Vector2d& a, const Vector2d& b) {
    crossings.clear();
    region.crossings(a, b, crossings);
    return crossings.empty() && region.inside((a + b) / 2);
  };
  std::vector<Line> strokes;
  std::vector<char> used(lines.size(), false);
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (used[i]) continue;
    used[i] = true;
    strokes.push_back(lines[i].points);
    Line& stroke = strokes.back();
    for (std::int64_t row = lines[i].row;;) {
      std::optional<Entry> next;
      for (const std::int64_t beside : {row - 1, row, row + 1}) {
        const auto found = rows.find(beside);
        if (found == rows.end()) continue;
        for (const std::size_t k : found->second) {
          if (used[k] || (beside == row && !is_closed(lines[k].points))) continue;
          const auto entry = nearest_entry(lines[k], k, stroke.back());
          if (entry->way <= farthest && (!next || entry->way < next->way) &&
              stays_inside(stroke.back(), entry->place))
            next = entry;
        }
      }
      if (!next) break;
      used[next->line] = true;
      append_from(*next, lines[next->line].points, &stroke);
      row = lines[next->line].row;
    }
  }
  return strokes;
}

}  // namespace impedraw
