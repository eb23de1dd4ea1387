#include "impedraw/planning/stroke_part.h"

#include <algorithm>
#include <limits>

#include "impedraw/drawing/polyline.h"
#include "impedraw/planning/stroke_ruler.h"

namespace impedraw {

double plane_length(const PlacedStroke& stroke) { return length(stroke.p_P); }

double plane_length(const std::vector<PlacedStroke>& strokes) {
  double sum = 0.0;
  for (const PlacedStroke& stroke : strokes) sum += plane_length(stroke);
  return sum;
}

StrokeRuler::StrokeRuler(const PlacedStroke& stroke)
    : stroke_(stroke), length_(plane_length(stroke)) {
  along_.reserve(stroke.p_P.size());
  along_.push_back(stroke.start);
  for (std::size_t i = 1; i < stroke.p_P.size(); ++i)
    along_.push_back(along_.back() + (stroke.p_P[i] - stroke.p_P[i - 1]).norm());
}

StrokePlace StrokeRuler::at(double along) const {
  const PlacedStroke& stroke = stroke_;
  auto i = static_cast<std::size_t>(std::lower_bound(along_.begin() + 1, along_.end(), along) -
                                    along_.begin());
  for (; i < along_.size(); ++i) {
    const double step = (stroke.p_P[i] - stroke.p_P[i - 1]).norm();
    if (!(step > 0)) continue;
    const double share = std::max(0.0, (along - along_[i - 1]) / step);
    return {stroke.p_P[i - 1] + share * (stroke.p_P[i] - stroke.p_P[i - 1]),
            stroke.page[i - 1] + share * (stroke.page[i] - stroke.page[i - 1]),
            stroke.force.empty()
                ? 0.0
                : stroke.force[i - 1] + share * (stroke.force[i] - stroke.force[i - 1])};
  }
  return {stroke.p_P.back(), stroke.page.back(), stroke.force.empty() ? 0.0 : stroke.force.back()};
}

StrokePlace place_on(const PlacedStroke& stroke, double along) {
  return StrokeRuler(stroke).at(along);
}

double nearest_place(const PlacedStroke& stroke, const Eigen::Vector2d& p_P) {
  double place = stroke.start, nearest = std::numeric_limits<double>::infinity();
  double before = stroke.start;
  for (std::size_t i = 0; i < stroke.p_P.size(); ++i) {
    if (i > 0) before += (stroke.p_P[i] - stroke.p_P[i - 1]).norm();
    const Eigen::Vector2d a = stroke.p_P[i], way = i + 1 < stroke.p_P.size()
                                                       ? Eigen::Vector2d(stroke.p_P[i + 1] - a)
                                                       : Eigen::Vector2d::Zero();
    const double share = way.squaredNorm() > 0.0
                             ? std::clamp((p_P - a).dot(way) / way.squaredNorm(), 0.0, 1.0)
                             : 0.0;
    const double distance = (a + share * way - p_P).norm();
    if (distance < nearest) nearest = distance, place = before + share * way.norm();
  }
  return place;
}

PlacedStroke StrokeRuler::part(double from, double to) const {
  const PlacedStroke& stroke = stroke_;
  const double end = stroke.start + length_;
  from = std::clamp(from, stroke.start, end);
  to = std::clamp(to, from, end);
  PlacedStroke part;
  part.number = stroke.number;
  part.start = from;
  part.speed = stroke.speed;
  part.depth = stroke.depth;
  part.lean_there = stroke.lean_there;
  part.lean_off = stroke.lean_off;
  if (from == 0.0) {
    part.wait = stroke.wait;
    part.pause = stroke.pause;
  }
  const auto add = [&](const StrokePlace& place) {
    part.p_P.push_back(place.p_P);
    part.page.push_back(place.page);
    if (!stroke.force.empty()) part.force.push_back(place.force);
  };
  add(at(from));
  const auto inside = std::upper_bound(along_.begin() + 1, along_.end(), from) - along_.begin();
  for (auto i = static_cast<std::size_t>(inside); i < along_.size() && along_[i] < to; ++i)
    add({stroke.p_P[i], stroke.page[i], stroke.force.empty() ? 0.0 : stroke.force[i]});
  if (to > from) add(at(to));
  return part;
}

PlacedStroke part_of(const PlacedStroke& stroke, double from, double to) {
  return StrokeRuler(stroke).part(from, to);
}

std::vector<StrokePart> merged(std::vector<StrokePart> parts, double gap) {
  std::sort(parts.begin(), parts.end(), [](const StrokePart& a, const StrokePart& b) {
    return a.stroke != b.stroke ? a.stroke < b.stroke : a.from < b.from;
  });
  std::vector<StrokePart> result;
  for (const StrokePart& part : parts) {
    if (!result.empty() && result.back().stroke == part.stroke &&
        part.from <= result.back().to + gap) {
      result.back().to = std::max(result.back().to, part.to);
    } else {
      result.push_back(part);
    }
  }
  return result;
}

std::vector<StrokePart> rest_of(const std::vector<PlacedStroke>& strokes,
                                const std::vector<StrokePart>& parts, double shortest) {
  const std::vector<StrokePart> covered = merged(parts);
  std::vector<StrokePart> rest;
  for (const PlacedStroke& stroke : strokes) {
    const double length = plane_length(stroke);
    auto part = std::lower_bound(covered.begin(), covered.end(), stroke.number,
                                 [](const StrokePart& p, int n) { return p.stroke < n; });
    if (part == covered.end() || part->stroke != stroke.number) {
      rest.push_back({stroke.number, 0, length});
      continue;
    }
    double at = 0;
    for (; part != covered.end() && part->stroke == stroke.number; ++part) {
      if (part->from - at > shortest) rest.push_back({stroke.number, at, part->from});
      at = std::max(at, part->to);
    }
    if (length - at > shortest) rest.push_back({stroke.number, at, length});
  }
  return rest;
}

}  // namespace impedraw
