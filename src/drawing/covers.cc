#include "impedraw/drawing/covers.h"

#include "impedraw/common/cross.h"

namespace impedraw {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;

bool holds(const Outlines& region, const AlignedBox2d& box) {
  int winding = 0;
  const Vector2d p = box.min();
  for (const auto& outline : region) {
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const Vector2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
      if (AlignedBox2d(a.cwiseMin(b), a.cwiseMax(b)).intersects(box)) return false;
      if ((a.y() <= p.y()) == (b.y() <= p.y())) continue;
      const bool up = a.y() <= p.y();
      if (up == (cross(Vector2d(b - a), Vector2d(p - a)) > 0)) winding += up ? 1 : -1;
    }
  }
  return winding != 0;
}

}  // namespace impedraw
