#include "impedraw/planning/wrap/wrap.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <sstream>
#include <string>

#include <fmt/core.h>
#include <fmt/format.h>
#include <Eigen/LU>

#include "impedraw/common/cross.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/range_check.h"
#include "impedraw/files/child_process.h"
#include "impedraw/files/data_folder.h"
#include "impedraw/planning/wrap/convex_hull.h"
#include "impedraw/planning/wrap/surface_patch.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

std::string patch_data(const SurfacePatch& patch) {
  std::string data;
  const auto put = [&data](const auto* values, std::size_t count) {
    data.append(reinterpret_cast<const char*>(values), count * sizeof *values);
  };
  const std::int64_t head[] = {static_cast<std::int64_t>(patch.samples.size()),
                               static_cast<std::int64_t>(patch.triangles.size()), patch.centre};
  put(head, 3);
  for (const SurfaceSample& s : patch.samples) put(s.p_P.data(), 3);
  for (const Eigen::Vector3i& t : patch.triangles) {
    const std::int64_t row[] = {t[0], t[1], t[2]};
    put(row, 3);
  }
  return data;
}

std::string last_line(const std::string& text) {
  std::istringstream in(text);
  std::string last;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

std::string script_file() {
  return (data_folder() / "src/planning/wrap/flatten_patch.py").string();
}

// Runs the script on the patch's data. Returns what it makes of them.
std::string run_script(const std::string& data, const std::filesystem::path& wanted_python) {
  const std::string python =
      (wanted_python.empty() ? python_interpreter() : wanted_python).string();
  const std::string script = script_file();
  const MemoryFile patch(data), flat, said;
  const int code = run_python({.python = python,
                               .arguments = {script, "/dev/fd/3", "/dev/fd/4"},
                               .files = {{&patch, 3}, {&flat, 4}, {&said, 1}, {&said, 2}}});
  if (code < 0) throw InputError(fmt::format("wrap: {} does not start", python));
  if (code == 0) return flat.content();
  const std::string why = last_line(said.content());
  throw InputError(
      fmt::format("wrap: {} failed: {}", script, why.empty() ? "it said nothing" : why));
}

std::vector<Vector2d> flatten_patch(const SurfacePatch& patch,
                                    const std::filesystem::path& python) {
  const std::string made = run_script(patch_data(patch), python);
  std::vector<Vector2d> flat(patch.samples.size());
  const std::size_t size = flat.size() * sizeof(Vector2d);
  if (made.size() != size)
    throw InputError(
        fmt::format("wrap: {} gave {} bytes, not {}", script_file(), made.size(), size));
  std::memcpy(static_cast<void*>(flat.data()), made.data(), size);
  return flat;
}

// The triangles that fold over in the flat positions or are stretched there more than fourfold,
// ascending.
std::vector<int> folded_triangles(const SurfacePatch& patch, const std::vector<Vector2d>& flat) {
  constexpr double kMostStretch = 4.0;  // a sheet that gives 400 % is torn
  std::vector<int> folded;
  for (std::size_t k = 0; k < patch.triangles.size(); ++k) {
    const Eigen::Vector3i& t = patch.triangles[k];
    const Vector2d a = flat[t[1]] - flat[t[0]], b = flat[t[2]] - flat[t[0]];
    const Eigen::Vector3d u = patch.samples[t[1]].p_P - patch.samples[t[0]].p_P,
                          v = patch.samples[t[2]].p_P - patch.samples[t[0]].p_P;
    // Squares of the singular values of the map from the surface to the page: their sum, product.
    Eigen::Matrix2d page, surface;
    page << a.squaredNorm(), a.dot(b), a.dot(b), b.squaredNorm();
    surface << u.squaredNorm(), u.dot(v), u.dot(v), v.squaredNorm();
    const Eigen::Matrix2d ratio = page * surface.inverse();
    const double half = ratio.trace() / 2;
    const double largest = half + std::sqrt(std::max(0.0, half * half - ratio.determinant()));
    const double smallest = ratio.determinant() / largest;
    if (cross(a, b) > 0 && largest < kMostStretch * kMostStretch &&
        smallest > 1 / (kMostStretch * kMostStretch))
      continue;
    folded.push_back(static_cast<int>(k));
  }
  return folded;
}

// spacings of the first patch, which only locates the second one
constexpr double kCoarse = 2;
constexpr double kDetour = 1.1;  // grid paths are up to 1.08 times as long as straight ones
constexpr int kWidenings = 3;    // of the margin, if the first patch was misleading
constexpr double kCutTo = 1e-6;  // how close to the patch's edge a stroke is cut [m]
constexpr int kDeepest = 20;     // halvings of a segment

// Cells that fold over are left out, and the rest is flattened anew: one grid point beside a sharp
// edge must not refuse the whole page. Throws InputError where more than kFoldedShare fold.
constexpr double kFoldedShare = 0.05;
constexpr int kFoldings = 4;

std::shared_ptr<const FlatChart> chart_of(SurfacePatch patch, const Vector2d& centre,
                                          const WrapSettings& settings) {
  std::string refusal;
  std::size_t all = 0, most = 0;
  for (int k = 0;; ++k) {
    std::vector<Vector2d> flat = flatten_patch(patch, settings.python);
    const std::vector<int> folded = folded_triangles(patch, flat);
    if (folded.empty())
      return std::make_shared<const FlatChart>(std::move(patch), std::move(flat), centre);
    if (k == 0) {
      const Eigen::Vector3d first = patch.samples[patch.triangles[folded.front()][0]].p_P;
      refusal = fmt::format(
          "wrap: the surface cannot be flattened, {} of {} triangles fold over, the first at "
          "({:.4f}, {:.4f}) m in the drawing plane; make the drawing smaller, move it, or set "
          "drawing.mapping=project",
          folded.size(), patch.triangles.size(), first.x(), first.y());
      most = static_cast<std::size_t>(kFoldedShare * static_cast<double>(patch.triangles.size()));
    }
    all += folded.size();
    std::optional<SurfacePatch> rest;
    if (k < kFoldings && all <= most) rest = without_triangles(patch, folded);
    if (!rest) throw InputError(refusal);
    patch = *std::move(rest);
  }
}

// Follows one flat stroke, point by point.
class Follower {
 public:
  Follower(const FlatChart& chart, const WrapSettings& settings, WrappedStrokes& result)
      : chart_(chart),
        tolerance_(settings.tolerance),
        step_(chart.patch().spacing / 2),
        result_(result) {}

  void follow(const PlacedStroke& stroke) {
    number_ = stroke.number;
    dot_ = stroke.p_P.size() == 1;  // else a single point is where the line only touches the patch
    page_length_ = stroke.start;
    lost_from_ = -1;
    part_ = {};
    stroke_ = &stroke;
    pressed_ = !stroke.force.empty();
    Point last = point(stroke, 0);
    begin(last);
    for (std::size_t k = 1; k < stroke.p_P.size(); ++k) {
      const Point next = point(stroke, k);
      const int pieces =
          std::max(1, static_cast<int>(std::ceil((next.flat - last.flat).norm() / (4 * step_))));
      Point from = last;
      for (int i = 1; i <= pieces; ++i) {
        const Point to = i == pieces ? next : between(last, next, static_cast<double>(i) / pieces);
        join(from, to, 0);
        from = to;
      }
      last = next;
    }
    end();
  }

 private:
  struct Point {
    Vector2d flat, page;
    std::optional<Vector2d> plane;
    double force;
  };

  Point point(const Vector2d& flat, const Vector2d& page, double force) const {
    return {flat, page, chart_.to_plane(flat), force};
  }
  Point point(const PlacedStroke& stroke, std::size_t k) const {
    return point(stroke.p_P[k], stroke.page[k], stroke.force.empty() ? 0.0 : stroke.force[k]);
  }
  Point between(const Point& a, const Point& b, double share) const {
    return point(a.flat + share * (b.flat - a.flat), a.page + share * (b.page - a.page),
                 a.force + share * (b.force - a.force));
  }

  // Appends the points after a, up to and including b.
  void join(const Point& a, const Point& b, int depth) {
    const double length = (b.flat - a.flat).norm();
    bool halve = false;
    bool all = a.plane && b.plane, none = !a.plane && !b.plane;
    for (const double share : {0.25, 0.5, 0.75}) {
      const Point p = between(a, b, share);
      all = all && p.plane;
      none = none && !p.plane;
      if (!all) continue;
      if ((*p.plane - (1 - share) * *a.plane - share * *b.plane).norm() > tolerance_) halve = true;
    }
    if (!all && !none) halve = length > kCutTo;
    if (halve && depth < kDeepest) {
      const Point middle = between(a, b, 0.5);
      join(a, middle, depth + 1);
      join(middle, b, depth + 1);
      return;
    }
    step_to(a, b, length);
  }

  void step_to(const Point& a, const Point& b, double length) {
    if (a.plane && !b.plane) {
      finish_part();
      lost_from_ = page_length_;
    }
    page_length_ += length;
    if (a.plane && b.plane) {
      if (length > 0) add(b);
      return;
    }
    if (!a.plane && b.plane) {
      if (lost_from_ >= 0) result_.lost.push_back({number_, lost_from_, page_length_});
      begin(b);
    }
  }

  void begin(const Point& p) {
    lost_from_ = p.plane ? -1 : page_length_;
    if (!p.plane) return;
    part_.number = number_;
    part_.start = page_length_;
    part_.speed = stroke_->speed;
    part_.depth = stroke_->depth;
    if (page_length_ == 0.0) {
      part_.wait = stroke_->wait;
      part_.pause = stroke_->pause;
    }
    add(p);
  }
  void add(const Point& p) {
    part_.p_P.push_back(*p.plane);
    part_.page.push_back(p.page);
    if (pressed_) part_.force.push_back(p.force);
  }
  void finish_part() {
    if (part_.p_P.size() > 1 || (dot_ && !part_.p_P.empty()))
      result_.strokes.push_back(std::move(part_));
    part_ = {};
  }
  void end() {
    finish_part();
    if (lost_from_ >= 0) result_.lost.push_back({number_, lost_from_, page_length_});
  }

  const FlatChart& chart_;
  double tolerance_, step_;
  WrappedStrokes& result_;
  PlacedStroke part_;
  const PlacedStroke* stroke_ = nullptr;
  int number_ = 0;
  bool dot_ = false, pressed_ = false;
  double page_length_ = 0, lost_from_ = -1;
};

}  // namespace

void validate(const WrapSettings& s) {
  RangeChecks("wrap")
      .field("spacing", s.spacing, {5e-4, 0.02}, "m")
      .field("margin", s.margin, {0.001, 0.5}, "m")
      .field("tolerance", s.tolerance, {1e-7, 1e-2}, "m");
  if (s.margin < 2 * s.spacing)
    throw InputError(fmt::format("wrap.margin is {} m, allowed is two spacings or more: {} m",
                                 s.margin, 2 * s.spacing));
}

Wrap::Wrap(const SurfaceHeight& surface, const Vector2d& centre,
           const std::vector<PlacedStroke>& strokes, const WrapSettings& settings)
    : settings_(settings), centre_(centre) {
  validate(settings);
  std::vector<Vector2d> points;
  for (const PlacedStroke& stroke : strokes)
    points.insert(points.end(), stroke.p_P.begin(), stroke.p_P.end());
  if (points.empty()) throw InputError("wrap: there are no strokes to wrap");
  points.push_back(centre);
  const std::vector<Vector2d> hull = convex_hull(points);
  double farthest = 0;
  for (const Vector2d& p : hull) farthest = std::max(farthest, (p - centre).norm());

  // A path along the surface is never shorter than its projection on the plane. A disc in the plane
  // therefore contains everything needed.
  const double radius = farthest + settings.margin;
  const auto coarse = chart_of(
      make_patch(surface, centre, kCoarse * settings.spacing, kDetour * radius, kDetour * radius,
                 [&](const Vector2d& p) { return (p - centre).norm() <= kDetour * radius; }),
      centre, settings);
  double margin = settings.margin;
  for (int k = 0; k < kWidenings; ++k, margin *= 2) {
    const auto desired = [&](const Vector2d& p) {
      const std::optional<Vector2d> flat = coarse->to_flat(p, true);
      return flat && distance_to_hull(hull, *flat) <= margin;
    };
    chart_ = chart_of(make_patch(surface, centre, settings.spacing, kDetour * radius,
                                 std::numeric_limits<double>::infinity(), desired),
                      centre, settings);
    bool missed = false;  // although there is surface
    for (const Vector2d& p : points)
      missed = missed || (!chart_->to_plane(p) && coarse->to_plane(p));
    if (!missed) return;
  }
}

Wrap Wrap::laid_on(const SurfaceHeight& with) const {
  SurfacePatch patch = chart_->patch();
  for (SurfaceSample& sample : patch.samples)
    if (const auto other = with(sample.p_P.x(), sample.p_P.y())) sample = *other;
  Wrap wrap = *this;
  wrap.chart_ = chart_of(std::move(patch), centre_, settings_);
  return wrap;
}

WrappedStrokes Wrap::wrap(const std::vector<PlacedStroke>& strokes) const {
  WrappedStrokes result;
  Follower follower(*chart_, settings_, result);
  for (const PlacedStroke& stroke : strokes) {
    if (!stroke.p_P.empty()) follower.follow(stroke);
  }
  return result;
}

}  // namespace impedraw
