#include "drawing/placement.h"

#include <cmath>

#include <fmt/core.h>

#include "common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

void require_positive(const char* name, double value, const char* unit) {
  if (!(value > 0) || !std::isfinite(value)) throw InputError(fmt::format("placement {}: {}{}; must be a number > 0", name, value, unit));
}

double fitted(const char* name, double wanted, double present) {
  require_positive(name, wanted, " mm");
  if (!(present > 0)) throw InputError(fmt::format("placement {}: the artwork has no extent that way to be scaled", name));
  return wanted / present;
}

}  // namespace

PlacementSettings shape_placement(const Vector2d& centre_m) {
  PlacementSettings settings;
  settings.centre_m = centre_m;
  settings.scale = 1.0;
  settings.about_page_origin = true;
  return settings;
}

Placement place(const Artwork& artwork, const PlacementSettings& settings) {
  Eigen::AlignedBox2d box;
  for (const Stroke& stroke : artwork.strokes) {
    for (const Vector2d& p : stroke.points) box.extend(p);
  }
  if (box.isEmpty()) throw InputError(fmt::format("{}: there are no strokes to place", artwork.name));
  if (settings.scale.has_value() + settings.width_mm.has_value() + settings.height_mm.has_value() > 1) {
    throw InputError("placement: of scale, width_mm and height_mm only one can be given");
  }
  if (!settings.centre_m.allFinite() || !std::isfinite(settings.rotate_deg)) {
    throw InputError("placement: centre_m and rotate_deg must be finite numbers");
  }

  Placement placement;
  placement.centre_m = settings.centre_m;
  placement.origin_mm = settings.about_page_origin ? Vector2d::Zero() : Vector2d(box.center());

  double scale = 1;
  if (settings.scale) {
    require_positive("scale", *settings.scale, "");
    scale = *settings.scale;
  } else if (settings.width_mm) {
    scale = fitted("width_mm", *settings.width_mm, box.sizes().x());
  } else if (settings.height_mm) {
    scale = fitted("height_mm", *settings.height_mm, box.sizes().y());
  } else {
    require_positive("fit_radius_m", settings.fit_radius_m, " m");
    double farthest = 0;
    for (const Stroke& stroke : artwork.strokes) {
      for (const Vector2d& p : stroke.points) farthest = std::max(farthest, (p - placement.origin_mm).norm());
    }
    if (farthest > 0) scale = settings.fit_radius_m * 1e3 / farthest;  // a lone dot has no size
  }

  // On the page as seen: X right, Y down, mirrored or not; then up is +x_W and right is −y_W.
  const Eigen::Matrix2d page_to_world = (Eigen::Matrix2d() << 0, -1, -1, 0).finished();
  const Eigen::Matrix2d flip = Eigen::Vector2d(settings.mirror ? -1 : 1, 1).asDiagonal();
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(settings.rotate_deg * M_PI / 180).toRotationMatrix();
  placement.A = 1e-3 * scale * turn * page_to_world * flip;
  return placement;
}

std::vector<PlacedStroke> placed_strokes(const Artwork& artwork, const Placement& placement) {
  std::vector<PlacedStroke> placed;
  placed.reserve(artwork.strokes.size());
  for (const Stroke& stroke : artwork.strokes) {
    PlacedStroke p;
    p.page = stroke.points;
    p.world.reserve(p.page.size());
    for (const Vector2d& q : p.page) p.world.push_back(placement.to_world(q));
    placed.push_back(std::move(p));
  }
  return placed;
}

}  // namespace impedraw
