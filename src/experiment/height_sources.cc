#include "impedraw/experiment/height_sources.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "impedraw/experiment/top_sheet.h"

namespace impedraw {
namespace {

// The cloud in P, to find the points nearest to a line along z.
class Columns {
 public:
  // Heights of the points nearest to a line, the highest first [m]. A wall beside it has many.
  static constexpr int kMost = 64;
  struct Heights {
    std::array<double, kMost> z;
    int n = 0;
    const double* begin() const { return z.data(); }
    const double* end() const { return z.data() + n; }
  };

  Columns(const PointCloud& cloud, const Pose& X_PW) {
    for (const Eigen::Vector3d& p_W : cloud.points) {
      points_.push_back(X_PW * p_W);
      flat_.emplace_back(points_.back().x(), points_.back().y(), 0.0);
    }
    tree_.emplace(flat_);
  }

  const std::vector<Eigen::Vector3d>& points() const { return points_; }
  Heights heights_at(double x, double y) const {
    constexpr double kAnywhere = 1e9;  // [m]
    std::array<int, kMost> nearest;
    Heights heights;
    heights.n = tree_->nearest({x, y, 0.0}, kMost, kAnywhere, nearest.data(), heights.z.data());
    for (int i = 0; i < heights.n; ++i)
      heights.z[i] = points_[static_cast<std::size_t>(nearest[i])].z();
    std::sort(heights.z.begin(), heights.z.begin() + heights.n, std::greater());
    return heights;
  }

 private:
  std::vector<Eigen::Vector3d> points_, flat_;
  std::optional<NeighbourTree> tree_;
};

// True if a height found at p says something of the one at (x, y).
bool is_near(const Eigen::Vector3d& p, double x, double y) {
  return std::hypot(p.x() - x, p.y() - y) < 0.01;
}

// Height over (x, y) of the tangent plane at a sample.
double height_beside(const SurfaceSample& at, double x, double y) {
  const Eigen::Vector2d way = Eigen::Vector2d(x, y) - at.p_P.head<2>();
  return at.p_P.z() - way.dot(at.n_P.head<2>()) / std::max(at.n_P.z(), 0.1);
}

// Answers that were given, by the place and the height from which it was looked for. Several stages
// of a plan ask the same. Where two questions share a slot, the older answer is lost.
class Answers {
 public:
  using Question = std::array<double, 3>;

  template <class Ask>
  SurfaceHeight::Sample operator()(const Question& question, const Ask& ask) {
    std::size_t hash = 0;
    for (const double x : question)
      hash = (hash ^ std::bit_cast<std::uint64_t>(x)) * 0x9e3779b97f4a7c15u;
    const std::size_t at = hash >> (64 - kBits);
    {
      const std::lock_guard guard(locks_[at % kLocks]);
      if (slots_[at].question == question) return slots_[at].answer;
    }
    const SurfaceHeight::Sample answer = ask();
    const std::lock_guard guard(locks_[at % kLocks]);
    slots_[at] = {question, answer};
    return answer;
  }

 private:
  static constexpr int kBits = 16, kLocks = 64;
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  struct Slot {
    Question question{kNone, kNone, kNone};
    SurfaceHeight::Sample answer;
  };
  std::vector<Slot> slots_ = std::vector<Slot>(std::size_t(1) << kBits);
  std::array<std::mutex, kLocks> locks_;
};

// A sheet higher than this above another hides it from the pen [m].
constexpr double kOverhang = 0.012;

// Starts at p. The paper's neighbourhoods jump as points enter and leave, so that the steps may not
// shrink to nothing: the last one is taken if it is within kSettled. A step that is shorter than
// kConverged leaves less than a thousandth of itself.
template <class Surface>
SurfaceHeight::Sample descend(const Surface& surface, const Pose& X_WP, Eigen::Vector3d p) {
  constexpr double kConverged = 5e-6, kNear = 5e-4;  // [m]
  double step = std::numeric_limits<double>::infinity();
  Eigen::Vector3d n;
  for (int i = 0; i < 12 && std::abs(step) > kConverged; ++i) {
    const SurfaceEstimate estimate = surface.estimate(X_WP * p);
    n = X_WP.R.transpose() * estimate.n_W;
    if (estimate.status != SurfaceStatus::ok || n.z() < 0.05) return std::nullopt;
    step = estimate.distance / n.z();
    p.z() -= step;
  }
  if (std::abs(step) > kNear) return std::nullopt;
  return SurfaceSample{p, n};
}

// The cloud's surface over (x, y), and what is needed to find it.
template <class Surface>
class CloudHeight {
 public:
  // `followed`: what the pen will follow, for the steepest slope; `surface` keeps it.
  CloudHeight(std::shared_ptr<const Surface> surface, const SurfaceEstimator& followed,
              const Pose& X_WP)
      : surface_(std::move(surface)),
        followed_(followed),
        X_WP_(X_WP),
        columns_(surface_->cloud(), X_WP.inverse()),
        tops_(columns_.points()) {}

  SurfaceHeight::Sample operator()(double x, double y, SurfaceHeight::Sample& last) {
    constexpr double kNowhere = std::numeric_limits<double>::infinity();
    const double start = last && is_near(last->p_P, x, y) ? height_beside(*last, x, y) : kNowhere;
    const auto sample = answers_({x, y, start}, [&] { return found(x, y, start); });
    if (sample) last = sample;
    return sample;
  }

 private:
  SurfaceHeight::Sample found(double x, double y, double start) const {
    constexpr double kSteep = 0.5;  // cosine of the slope from which the finer normal is asked for
    SurfaceHeight::Sample sample;
    const double top = tops_.top(x, y), lid = tops_.lid(x, y);
    std::optional<Columns::Heights> heights;
    const auto heights_here = [&]() -> const Columns::Heights& {
      return heights ? *heights : heights.emplace(columns_.heights_at(x, y));
    };
    // Another sheet lies above: the pen cannot reach this one.
    const auto covered = [&] {
      const double over = sample->p_P.z() + kOverhang + TopSheet::rise(sample->n_P);
      return lid > over && !passes_beside(x, y, over, heights_here());
    };
    bool found = false;
    const auto look_from = [&](double z) {
      sample = descend(*surface_, X_WP_, {x, y, z});
      found = sample && !covered();
    };
    if (std::isfinite(start)) look_from(start);
    // Beside an overhang the cell's highest point is on another sheet.
    for (const double from : {top, lid})
      if (!found && std::isfinite(from)) look_from(from);
    // On a steep flank, and just beyond an overhang, what is found lies far below.
    if (!found) {
      double tried = std::numeric_limits<double>::infinity();
      for (const double from : heights_here()) {
        if (tried - from < kOverhang) continue;
        look_from(tried = from);
        if (found) break;
      }
    }
    if (!found) return std::nullopt;
    if (sample->n_P.z() < kSteep) {
      const SurfaceEstimate there = followed_.estimate(X_WP_ * sample->p_P);
      if (there.status == SurfaceStatus::ok) sample->steepest = X_WP_.R.col(2).dot(there.n_W);
    }
    return sample;
  }

  // True if the line through (x, y) stays outside of the surface at each of the heights above
  // `over`: its points, which noise spreads, say less well where a sheet ends.
  bool passes_beside(double x, double y, double over, const Columns::Heights& heights) const {
    bool beside = false;
    for (const double z : heights) {
      if (z < over) break;
      const SurfaceEstimate at = surface_->estimate(X_WP_ * Eigen::Vector3d(x, y, z));
      if (at.status != SurfaceStatus::ok) continue;
      if (at.distance <= 0.0) return false;
      beside = true;
    }
    return beside;
  }

  std::shared_ptr<const Surface> surface_;
  const SurfaceEstimator& followed_;
  Pose X_WP_;
  Columns columns_;
  TopSheet tops_;
  Answers answers_;
};

template <class Surface>
SurfaceHeight height_of_cloud(std::shared_ptr<const Surface> surface,
                              const SurfaceEstimator& followed, const Pose& X_WP) {
  const auto height = std::make_shared<CloudHeight<Surface>>(std::move(surface), followed, X_WP);
  return
      [height](double x, double y, SurfaceHeight::Sample& last) { return (*height)(x, y, last); };
}

}  // namespace

SurfaceHeight canvas_height(std::shared_ptr<const Canvas> canvas, const Pose& X_WP) {
  // From farther out than any of the canvas, wherever the frame's origin is.
  const double out = (canvas->bounds().center() - X_WP.p).dot(X_WP.R.col(2)) +
                     canvas->bounds().diagonal().norm() + 1.0;
  return [canvas = std::move(canvas), X_WP, X_PW = X_WP.inverse(), out](
             double x, double y) -> std::optional<SurfaceSample> {
    const auto hit = canvas->ray(X_WP * Eigen::Vector3d(x, y, out), -X_WP.R.col(2));
    if (!hit) return std::nullopt;
    return SurfaceSample{X_PW * hit->p_W, X_PW.R * hit->n_W};
  };
}

namespace {

// Between most points of a cloud and their nearest neighbours [m].
double spacing_of(const std::vector<Eigen::Vector3d>& points, const NeighbourTree& tree) {
  std::vector<double> gaps;
  for (std::size_t i = 0; i < points.size(); i += points.size() / 500 + 1) {
    int index[2];
    double squared[2];
    if (tree.nearest(points[i], 2, 1.0, index, squared) == 2) gaps.push_back(std::sqrt(squared[1]));
  }
  if (gaps.empty()) return 0.0;
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  return *middle;
}

}  // namespace

TriangleMesh surface_grid(const SurfaceHeight& surface, const PointCloud& cloud, const Pose& X_PW) {
  constexpr double kCell = 4e-3, kSteepest = 4.0;  // [m]; rise of a cell over its side
  constexpr int kMostCells = 500;
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p_W : cloud.points) box.extend(X_PW * p_W);
  TriangleMesh mesh;
  if (box.isEmpty()) return mesh;
  const double cell = std::max(kCell, box.sizes().head<2>().maxCoeff() / kMostCells);
  const int nx = static_cast<int>(box.sizes().x() / cell) + 1,
            ny = static_cast<int>(box.sizes().y() / cell) + 1;
  // A fitted surface goes on across a hole; the cloud does not.
  const NeighbourTree tree(cloud.points);
  const double near = std::max(1.5 * cell, 2.5 * spacing_of(cloud.points, tree));
  const Pose X_WP = X_PW.inverse();
  std::vector<int> vertex;  // of each node; −1: no surface there
  SurfaceHeight::Sample last;
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      auto sample = surface(box.min().x() + i * cell, box.min().y() + j * cell, last);
      int nearest = 0;
      double squared = 0.0;
      if (sample && tree.nearest(X_WP * sample->p_P, 1, near, &nearest, &squared) == 0)
        sample.reset();
      vertex.push_back(sample ? static_cast<int>(mesh.vertices.size()) : -1);
      if (sample) mesh.vertices.push_back(sample->p_P);
    }
  for (int j = 0; j + 1 < ny; ++j)
    for (int i = 0; i + 1 < nx; ++i) {
      const int* low = &vertex[static_cast<std::size_t>(j) * nx + i];
      const int a = low[0], b = low[1], c = low[nx], d = low[nx + 1];
      if (std::min({a, b, c, d}) < 0) continue;
      const auto [lowest, highest] = std::minmax({a, b, c, d}, [&](int k, int l) {
        return mesh.vertices[static_cast<std::size_t>(k)].z() <
               mesh.vertices[static_cast<std::size_t>(l)].z();
      });
      if (mesh.vertices[static_cast<std::size_t>(highest)].z() -
              mesh.vertices[static_cast<std::size_t>(lowest)].z() >
          kSteepest * cell)
        continue;
      mesh.triangles.insert(mesh.triangles.end(), {{a, b, d}, {a, d, c}});
    }
  return mesh;
}

SurfaceHeight level_surface(double z) {
  return [z](double x, double y) { return SurfaceSample{{x, y, z}, Eigen::Vector3d::UnitZ()}; };
}

SurfaceHeight perceived_height(std::shared_ptr<const PlanSurface> surface, const Pose& X_WP) {
  const SurfaceEstimator& followed = surface->seen();
  return height_of_cloud(std::move(surface), followed, X_WP);
}

SurfaceHeight perceived_height(std::shared_ptr<const SurfaceEstimator> surface, const Pose& X_WP) {
  const SurfaceEstimator& followed = *surface;
  return height_of_cloud(std::move(surface), followed, X_WP);
}

SurfaceHeight counted(SurfaceHeight surface, double expected,
                      std::function<void(double share)> tell) {
  return [surface = std::move(surface), expected, tell = std::move(tell),
          looks = std::make_shared<std::atomic<long>>(0),
          teller = std::this_thread::get_id()](double x, double y, SurfaceHeight::Sample& last) {
    const long n = ++*looks;
    if (n % 128 == 0 && std::this_thread::get_id() == teller)
      tell(std::min(1.0, static_cast<double>(n) / expected));
    return surface(x, y, last);
  };
}

SurfaceHeight nearest_sheet(std::shared_ptr<const Canvas> canvas, const Pose& X_WP,
                            SurfaceHeight planned) {
  // The true sheet that shows its front nearest to p.
  const auto sheet_within = [canvas, X_WP, X_PW = X_WP.inverse()](
                                const Eigen::Vector3d& p, double least) -> SurfaceHeight::Sample {
    SurfaceHeight::Sample nearest;
    constexpr int kMostSheets = 16;
    const double lowest = p.z() - least;
    double z = p.z() + least;
    for (int i = 0; i < kMostSheets; ++i) {
      const auto hit = canvas->ray(X_WP * Eigen::Vector3d(p.x(), p.y(), z), -X_WP.R.col(2));
      if (!hit) break;
      const SurfaceSample sheet{X_PW * hit->p_W, X_PW.R * hit->n_W};
      const double off = std::abs(sheet.p_P.z() - p.z());
      if (sheet.n_P.z() > 0.0 && off <= least) least = off, nearest = sheet;
      if (sheet.p_P.z() < lowest) break;
      z = sheet.p_P.z() - 1e-6;
    }
    return nearest;
  };
  const auto sheet_at = [sheet_within](const Eigen::Vector3d& p) {
    const auto sheet = sheet_within(p, kJudged);
    return sheet ? sheet : sheet_within(p, kMisjudged);
  };
  return [sheet_at, planned = std::move(planned), upper = canvas_height(canvas, X_WP)](
             double x, double y, SurfaceHeight::Sample& last) -> SurfaceHeight::Sample {
    // A height that was planned beside it tells its sheet as well [m].
    constexpr double kBeside = 1e-3;
    if (last && std::hypot(last->p_P.x() - x, last->p_P.y() - y) < kBeside)
      if (const auto sheet = sheet_at({x, y, height_beside(*last, x, y)})) return sheet;
    SurfaceHeight::Sample plan = planned(x, y, last);
    if (!plan) {
      // Just beyond what is planned: the artwork before its corners were rounded.
      if (last && is_near(last->p_P, x, y)) plan = last;
      if (!plan) plan = upper(x, y);
      if (!plan) plan = SurfaceSample{{x, y, 0.0}, Eigen::Vector3d::UnitZ()};
      plan->p_P.head<2>() = Eigen::Vector2d(x, y);
    }
    last = plan;
    const auto sheet = sheet_at(plan->p_P);
    return sheet ? sheet : plan;
  };
}

}  // namespace impedraw
