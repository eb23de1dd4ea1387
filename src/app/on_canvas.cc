#include "app/on_canvas.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "common/errors.h"

namespace impedraw {

namespace {

using Eigen::Vector2d;

// From p to the canvas [m]: towards its nearest vertex, up to where the canvas begins.
double distance_off(const Vector2d& p, const TriangleMesh& mesh, const SurfaceHeight& canvas) {
  double nearest = std::numeric_limits<double>::infinity();
  Vector2d on = p;
  for (const Eigen::Vector3d& v : mesh.vertices) {
    const double distance = (v.head<2>() - p).squaredNorm();
    if (distance < nearest) nearest = distance, on = v.head<2>();
  }
  double off = 0.0, reached = 1.0;  // shares of the way from p
  for (int i = 0; i < 20; ++i) {
    const double middle = (off + reached) / 2;
    const Vector2d at = p + middle * (on - p);
    (canvas(at.x(), at.y()) ? reached : off) = middle;
  }
  return reached * (on - p).norm();
}

struct Farthest {
  double by = 0.0;  // [m]; 0: nowhere
  Vector2d world = Vector2d::Zero(), page = Vector2d::Zero();
};

// Where along the stroke, looked at every `step` metres and at each of its points, `by` is largest.
template <class By>
Farthest farthest_along(const PlacedStroke& stroke, double step, const By& by) {
  Farthest worst;
  for (std::size_t i = 0; i < stroke.world.size(); ++i) {
    const std::size_t next = std::min(i + 1, stroke.world.size() - 1);
    const int pieces = std::max(1, static_cast<int>(std::ceil((stroke.world[next] - stroke.world[i]).norm() / step)));
    for (int k = 0; k < pieces; ++k) {
      const double share = static_cast<double>(k) / pieces;
      const Vector2d at = stroke.world[i] + share * (stroke.world[next] - stroke.world[i]);
      const double off = by(at);
      if (off > worst.by) worst = {off, at, stroke.page[i] + share * (stroke.page[next] - stroke.page[i])};
    }
  }
  return worst;
}

}  // namespace

void require_on_canvas(const std::vector<PlacedStroke>& strokes, const TriangleMesh& mesh, const SurfaceHeight& canvas) {
  for (std::size_t s = 0; s < strokes.size(); ++s) {
    const Farthest worst = farthest_along(strokes[s], 1e-3, [&](const Vector2d& at) {
      return canvas(at.x(), at.y()) ? 0.0 : distance_off(at, mesh, canvas);
    });
    if (worst.by <= 0.0) continue;
    Eigen::AlignedBox3d box;
    for (const Eigen::Vector3d& v : mesh.vertices) box.extend(v);
    throw InputError(
        fmt::format("stroke {} leaves the canvas by up to {:.1f} mm, farthest at page ({:.1f}, {:.1f}) mm, "
                    "world ({:.4f}, {:.4f}) m; the canvas fills x {:.2f} to {:.2f} m, y {:.2f} to {:.2f} m: draw smaller, or move "
                    "drawing.placement.centre",
                    s, 1e3 * worst.by, worst.page.x(), worst.page.y(), worst.world.x(), worst.world.y(), box.min().x(), box.max().x(),
                    box.min().y(), box.max().y()));
  }
}

void require_strokes_in_reach(const std::vector<PlacedStroke>& strokes, const SurfaceHeight& canvas, bool vertical_pen,
                              const ShortOf& short_of) {
  for (std::size_t s = 0; s < strokes.size(); ++s) {
    Eigen::Vector2d asked = Vector2d::Constant(std::numeric_limits<double>::infinity());
    const Farthest worst = farthest_along(strokes[s], 1e-2, [&](const Vector2d& at) {
      if ((at - asked).norm() < 5e-3) return 0.0;  // finely flattened curves have many points
      asked = at;
      const auto sample = canvas(at.x(), at.y());
      return sample ? short_of(sample->p_W, vertical_pen ? Eigen::Vector3d::UnitZ() : sample->n_W) : 0.0;
    });
    if (worst.by <= 0.0) continue;
    throw InputError(fmt::format("stroke {} leaves the arm's reach by up to {:.1f} mm, farthest at page ({:.1f}, {:.1f}) mm, "
                                 "world ({:.4f}, {:.4f}) m; move drawing and canvas nearer to the arm, which stands at (0, 0)",
                                 s, 1e3 * worst.by, worst.page.x(), worst.page.y(), worst.world.x(), worst.world.y()));
  }
}

}  // namespace impedraw
