#include "impedraw/drawing/placement.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

using Limits = PlacementSettings::Limits;

constexpr double kReach = 10.0;  // of the placed drawing, from its centre [m]

double fitted(const Limit& limit, double desired, double present) {
  require_in_range("placement", limit, desired);
  if (!(present > 0))
    throw InputError(
        fmt::format("placement.{}: the artwork has no extent that way to be scaled", limit.name));
  return desired / present;
}

// All points to be placed.
std::vector<Vector2d> points_of(const Artwork& artwork) {
  std::vector<Vector2d> points;
  for (const Stroke& stroke : artwork.strokes)
    points.insert(points.end(), stroke.points.begin(), stroke.points.end());
  for (const Area& area : artwork.areas) {
    for (const auto& outline : area.outlines)
      points.insert(points.end(), outline.begin(), outline.end());
  }
  return points;
}

void require_one_size(const PlacementSettings& s) {
  const bool rectangle = s.fit_width_m || s.fit_height_m;
  if (s.scale.has_value() + s.width_mm.has_value() + s.height_mm.has_value() + rectangle > 1) {
    throw InputError(
        "placement: of scale, width, height and the rectangle fit_width × fit_height only one can "
        "be given");
  }
  if (!rectangle && (s.margin_mm != 0 || s.fit_page)) {
    throw InputError(
        fmt::format("placement: {} needs a rectangle: give fit_width or fit_height, too",
                    s.fit_page ? "fit_page" : "margin"));
  }
}

// Half a side of the rectangle, less the margin [mm].
double half_side(const Limit& limit, double side_m, double margin_mm) {
  require_in_range("placement", limit, side_m);
  require_in_range("placement", Limits::margin, margin_mm);
  const double half = 500 * side_m - margin_mm;
  if (!(half > 0)) {
    throw InputError(
        fmt::format("placement.margin is {} mm, allowed is less than {:.6g} mm, half of {}",
                    margin_mm, 500 * side_m, limit.name));
  }
  return half;
}

// The largest scale at which the points, rotated and mirrored by `to_view`, stay in the rectangle
// about the origin.
double rectangle_scale(const std::vector<Vector2d>& points, const Eigen::Matrix2d& to_view,
                       const PlacementSettings& s) {
  Vector2d reach = Vector2d::Zero();
  for (const Vector2d& p : points) reach = reach.cwiseMax((to_view * p).cwiseAbs());
  double scale = std::numeric_limits<double>::infinity();
  if (s.fit_width_m)
    scale = std::min(scale, half_side(Limits::fit_width, *s.fit_width_m, s.margin_mm) / reach.y());
  if (s.fit_height_m)
    scale =
        std::min(scale, half_side(Limits::fit_height, *s.fit_height_m, s.margin_mm) / reach.x());
  if (!std::isfinite(scale)) {
    if (reach.isZero()) return 1;  // a lone dot has no size
    throw InputError(fmt::format("placement.{}: the artwork has no extent that way to be scaled",
                                 s.fit_width_m ? "fit_width" : "fit_height"));
  }
  return scale;
}

}  // namespace

bool has_size(const PlacementSettings& s) {
  return s.scale || s.width_mm || s.height_mm || s.fit_width_m || s.fit_height_m;
}

PlacementSettings shape_placement(const Vector2d& centre_m) {
  PlacementSettings settings;
  settings.centre_m = centre_m;
  settings.scale = 1.0;
  settings.about_page_origin = true;
  return settings;
}

Placement place(const Artwork& artwork, const PlacementSettings& settings) {
  const std::vector<Vector2d> points = points_of(artwork);
  Eigen::AlignedBox2d box;
  for (const Vector2d& p : points) box.extend(p);
  if (box.isEmpty())
    throw InputError(fmt::format("{}: there are no strokes to place", artwork.name));
  require_one_size(settings);
  require_in_range("placement", Limits::centre, settings.centre_m);
  require_in_range("placement", Limits::rotate, settings.rotate_deg);

  Placement placement;
  placement.centre_m = settings.centre_m;
  placement.origin_mm = settings.about_page_origin
                            ? Vector2d::Zero()
                            : Vector2d(settings.fit_page ? artwork.page.center() : box.center());

  // As seen on the page: X right, Y down, mirrored or not. Up becomes +x_W, right becomes −y_W.
  const Eigen::Matrix2d page_to_world = (Eigen::Matrix2d() << 0, -1, -1, 0).finished();
  const Eigen::Matrix2d flip = Eigen::Vector2d(settings.mirror ? -1 : 1, 1).asDiagonal();
  const Eigen::Matrix2d turn =
      Eigen::Rotation2Dd(settings.rotate_deg * std::numbers::pi / 180).toRotationMatrix();
  const Eigen::Matrix2d turned = turn * page_to_world * flip;

  double scale = 1;
  if (settings.scale) {
    require_in_range("placement", Limits::scale, *settings.scale);
    scale = *settings.scale;
  } else if (settings.width_mm) {
    scale = fitted(Limits::width, *settings.width_mm, box.sizes().x());
  } else if (settings.height_mm) {
    scale = fitted(Limits::height, *settings.height_mm, box.sizes().y());
  } else if (settings.fit_width_m || settings.fit_height_m) {
    std::vector<Vector2d> fitted_points = points;
    if (settings.fit_page) {
      fitted_points.clear();
      using Box = Eigen::AlignedBox2d;
      for (const auto c : {Box::BottomLeft, Box::BottomRight, Box::TopLeft, Box::TopRight})
        fitted_points.push_back(artwork.page.corner(c));
    }
    for (Vector2d& p : fitted_points) p -= placement.origin_mm;
    scale = rectangle_scale(fitted_points, turned, settings);
  } else {
    require_in_range("placement", Limits::fit_radius, settings.fit_radius_m);
    double farthest = 0;
    for (const Vector2d& p : points)
      farthest = std::max(farthest, (p - placement.origin_mm).norm());
    if (farthest > 0) scale = settings.fit_radius_m * 1e3 / farthest;  // a lone dot has no size
  }

  placement.A = 1e-3 * scale * turned;
  using Box = Eigen::AlignedBox2d;
  Eigen::Vector4d reach;
  int i = 0;
  for (const auto c : {Box::BottomLeft, Box::BottomRight, Box::TopLeft, Box::TopRight})
    reach[i++] = (placement.A * (box.corner(c) - placement.origin_mm)).norm();
  const double farthest = reach.maxCoeff<Eigen::PropagateNaN>();
  if (!(farthest <= kReach)) {
    throw InputError(fmt::format(
        "placement: at a scale of {:.4g} the drawing reaches {:.4g} m from its centre, allowed is "
        "at most {:g} m",
        scale, farthest, kReach));
  }
  return placement;
}

std::vector<PlacedStroke> placed_strokes(const Artwork& artwork, const Placement& placement) {
  std::vector<PlacedStroke> placed;
  placed.reserve(artwork.strokes.size());
  for (const Stroke& stroke : artwork.strokes) {
    PlacedStroke p;
    p.number = static_cast<int>(placed.size());
    p.page = stroke.points;
    p.p_P.reserve(p.page.size());
    for (const Vector2d& q : p.page) p.p_P.push_back(placement.to_plane(q));
    placed.push_back(std::move(p));
  }
  return placed;
}

}  // namespace impedraw
