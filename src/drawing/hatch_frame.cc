#include "impedraw/drawing/hatch_frame.h"

#include <algorithm>
#include <cmath>

namespace impedraw {
namespace {

using Eigen::Vector2d;

template <class Map>
std::vector<Vector2d> in_pieces(const std::vector<Vector2d>& line, double longest, const Map& map) {
  std::vector<Vector2d> points = {map(line[0])};
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vector2d a = line[i - 1], way = line[i] - a;
    const int pieces = longest > 0.0 ? 1 + static_cast<int>(way.norm() / longest) : 1;
    for (int k = 1; k < pieces; ++k) points.push_back(map(a + way * k / pieces));
    points.push_back(map(line[i]));
  }
  return points;
}

}  // namespace

HatchFrame::HatchFrame(double angle, const SurfaceDistances& distances,
                       const Eigen::AlignedBox2d& box, double step)
    : along_(std::cos(angle), -std::sin(angle)), across_(std::sin(angle), std::cos(angle)) {
  if (!distances) return;
  const SurfaceDistance distance = distances(across_);
  Eigen::AlignedBox2d turned;
  for (int corner = 0; corner < 4; ++corner)
    turned.extend(to_H(box.corner(static_cast<Eigen::AlignedBox2d::CornerType>(corner))));
  step_ = step;
  low_ = turned.min();
  columns_ = static_cast<std::size_t>(turned.sizes().x() / step) + 2;
  rows_ = static_cast<std::size_t>(turned.sizes().y() / step) + 2;
  for (std::size_t i = 0; i < columns_; ++i)
    for (std::size_t j = 0; j < rows_; ++j) {
      constexpr double kLeastRise = 0.1;  // as a share of the step
      const Vector2d p = low_ + step * Vector2d(static_cast<double>(i), static_cast<double>(j));
      const double there = distance(p.x() * along_ + p.y() * across_);
      table_.push_back(j == 0 ? there : std::max(there, table_.back() + kLeastRise * step));
    }
}

double HatchFrame::sample(double x, std::size_t row) const {
  const double at = std::clamp((x - low_.x()) / step_, 0.0, static_cast<double>(columns_ - 1));
  const std::size_t i = std::min(columns_ - 2, static_cast<std::size_t>(at)), k = i * rows_ + row;
  return table_[k] + (at - static_cast<double>(i)) * (table_[k + rows_] - table_[k]);
}

Vector2d HatchFrame::to_H(const Vector2d& page_mm) const {
  const Vector2d p(along_.dot(page_mm), across_.dot(page_mm));
  if (step_ == 0.0) return p;
  const double at = (p.y() - low_.y()) / step_;
  const auto row = static_cast<std::size_t>(std::clamp(at, 0.0, static_cast<double>(rows_ - 2)));
  const double below = sample(p.x(), row);
  return {p.x(), below + (at - static_cast<double>(row)) * (sample(p.x(), row + 1) - below)};
}

Vector2d HatchFrame::to_page(const Vector2d& p_H) const {
  if (step_ == 0.0) return p_H.x() * along_ + p_H.y() * across_;
  std::size_t row = 0, end = rows_ - 1;  // y_H lies between their samples, but for the ends
  while (end - row > 1) {
    const std::size_t middle = (row + end) / 2;
    (sample(p_H.x(), middle) <= p_H.y() ? row : end) = middle;
  }
  const double below = sample(p_H.x(), row),
               share = (p_H.y() - below) / (sample(p_H.x(), row + 1) - below);
  return p_H.x() * along_ + (low_.y() + step_ * (static_cast<double>(row) + share)) * across_;
}

std::vector<Vector2d> HatchFrame::outline_to_H(std::vector<Vector2d> page_mm) const {
  if (step_ > 0.0) page_mm.push_back(Vector2d(page_mm.front()));
  return in_pieces(page_mm, step_, [this](const Vector2d& p) { return to_H(p); });
}

std::vector<Vector2d> HatchFrame::line_to_page(const std::vector<Vector2d>& line_H) const {
  return in_pieces(line_H, step_, [this](const Vector2d& p) { return to_page(p); });
}

}  // namespace impedraw
