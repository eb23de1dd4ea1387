#include "impedraw/simulation/tip_touches.h"

#include <algorithm>
#include <cmath>

namespace impedraw {

using Eigen::Vector3d;

namespace {

constexpr double kRounding = 1e-9;  // [m]

// Nothing between c and the place.
bool is_seen(const Canvas& canvas, const Vector3d& c, const SurfacePoint& place) {
  const auto hit = canvas.ray(c, place.p_W - c);
  return !hit || hit->t * std::abs(place.distance) > std::abs(place.distance) - 1e-6;
}

}  // namespace

// A new place is on the side of the last one that is nearest to it.
TipTouches::Side TipTouches::side_of(const Vector3d& c, const SurfacePoint& place,
                                     double radius) const noexcept {
  const double depth = std::abs(place.distance), sign = place.distance < 0.0 ? -1.0 : 1.0;
  if (place.on_edge) return {sign, false};
  if (!begun_) return {sign, sign < 0.0 && depth <= radius};
  if (count_ == 0) return {sign, false};
  int last = 0;
  for (int i = 1; i < count_; ++i)
    if ((touches_[i].p - place.p_W).squaredNorm() < (touches_[last].p - place.p_W).squaredNorm())
      last = i;
  if (sides_[last].sign == sign) return {sign, sides_[last].through};
  return {sign, !sides_[last].through && depth <= (c - c_).norm() + kRounding};
}

bool TipTouches::went_on(const Vector3d& n) const noexcept {
  return std::any_of(touches_.begin(), touches_.begin() + count_,
                     [&](const TipTouch& last) { return n.dot(last.n) > kSame; });
}

std::span<const TipTouch> TipTouches::update(const Canvas& canvas, const Vector3d& c,
                                             double radius) noexcept {
  // The distance to the canvas changes by no more than c moves.
  double look = 10.0 * radius, reach = radius;
  bool through = false;
  const double way = (c - c_).norm() + kRounding;
  if (count_ > 0) look = std::min(look, std::abs(touches_[0].clear) + way);
  for (int i = 0; i < count_; ++i) {
    through = through || sides_[i].through;
    if (sides_[i].through) reach = std::max(reach, way - touches_[i].clear);
  }
  std::array<SurfacePoint, 2 * kMost> places;
  const int found = canvas.closest_places(c, reach, look, places);

  std::array<TipTouch, kMost> touches;
  std::array<Side, kMost> sides;
  int count = 0;
  // The nearest place goes on if c was through and none does.
  for (const bool any : {false, true}) {
    for (int i = 0; i < found && count < kMost && (count == 0 || !any); ++i) {
      const SurfacePoint& place = places[i];
      const Side side = side_of(c, place, radius);
      const double depth = std::abs(place.distance);
      TipTouch touch{place.p_W, side.sign * place.n_W, depth};
      if (place.on_edge && depth > kRounding)
        touch.n = (c - place.p_W) / depth;
      else if (side.through)
        touch = {place.p_W, -side.sign * place.n_W, -depth};
      const bool same =
          std::any_of(touches.begin(), touches.begin() + count,
                      [&](const TipTouch& other) { return touch.n.dot(other.n) > kSame; });
      if (same || (through && !any && !went_on(touch.n))) continue;
      if (count > 0 && (touch.clear >= radius || (!through && !is_seen(canvas, c, place))))
        continue;
      through = through || side.through;
      touches[count] = touch;
      sides[count++] = side;
    }
    if (count > 0) break;
  }
  begun_ = true;
  c_ = c;
  count_ = count;
  std::copy_n(sides.begin(), count, sides_.begin());
  for (int i = 0; i < count; ++i) {
    for (int j = 0; j < count; ++j) {
      if (i == j) continue;
      const double o = (touches[i].n.dot(touches[j].n) - kApart) / (kSame - kApart);
      const double mine = radius - touches[i].clear, other = radius - touches[j].clear;
      if (o > 0.0) touches[i].share *= 1.0 - o * other * other / (mine * mine + other * other);
    }
    touches_[i] = touches[i];
  }
  return std::span(touches_).first(count);
}

}  // namespace impedraw
