#include "impedraw/planning/preflight/place_search.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace impedraw {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kBadCell = 10.0, kUnreachable = 5.0, kTurned = 0.1;
constexpr double kDegree = std::numbers::pi / 180.0;          // [rad]
constexpr double kSteepPlace = 60.0 * kDegree, kBent = 40.0;  // [rad], [1/m]
constexpr double kMostCells = 4e4;
constexpr double kGridStep = 8e-3;                // [m]
constexpr double kStepTurn = 15.0, kSame = 20.0;  // [deg]
constexpr double kBroken = 2e-3;                  // height of a step between cells [m]

// Between two samples, as far as their slopes do not explain it [m].
double step_between(const SurfaceSample& a, const SurfaceSample& b) {
  const Vector3d way = b.p_P - a.p_P;
  const double first = -way.head<2>().dot(a.n_P.head<2>()) / a.n_P.z(),
               second = -way.head<2>().dot(b.n_P.head<2>()) / b.n_P.z();
  return std::abs(way.z() - (first + second) / 2) - std::abs(first - second) / 2;
}

}  // namespace

PlaceSearch::PlaceSearch(const SurfaceHeight& surface, const PlaceSearchSettings& settings)
    : settings_(settings) {
  double& cell = settings_.cell;
  const Vector2d sides = settings_.box.sizes();
  cell = std::max(cell, std::sqrt(sides.x() * sides.y() / kMostCells));
  nx_ = static_cast<int>(sides.x() / cell) + 1;
  ny_ = static_cast<int>(sides.y() / cell) + 1;
  cells_.resize(static_cast<std::size_t>(nx_) * ny_);
  heights_.assign(cells_.size(), std::numeric_limits<float>::quiet_NaN());
  SurfaceHeight::Sample last;
  for (int j = 0; j < ny_; ++j)
    for (int i = 0; i < nx_; ++i) {
      const Vector2d p = settings_.box.min() + cell * Vector2d(i + 0.5, j + 0.5);
      seen_.push_back(surface(p.x(), p.y(), last));
    }
  const auto index = [&](int i, int j) { return static_cast<std::size_t>(j) * nx_ + i; };
  const double steepest = settings_.max_slope_deg * std::numbers::pi / 180.0;
  for (int j = 0; j < ny_; ++j) {
    for (int i = 0; i < nx_; ++i) {
      const auto& here = seen_[index(i, j)];
      if (!here) continue;
      const double slope =
          std::acos(std::clamp(std::min(here->n_P.z(), here->steepest), -1.0, 1.0));
      CellTrouble trouble = slope > steepest ? CellTrouble::steep : CellTrouble::none;
      heights_[index(i, j)] = static_cast<float>(here->p_P.z());
      double bend = 0.0;
      for (const auto& [x, y] : {std::pair{i - 1, j}, {i + 1, j}, {i, j - 1}, {i, j + 1}}) {
        if (x < 0 || y < 0 || x >= nx_ || y >= ny_ || !seen_[index(x, y)]) continue;
        const SurfaceSample& there = *seen_[index(x, y)];
        if (step_between(*here, there) > kBroken) trouble = CellTrouble::edge;
        bend = std::max(bend, (there.n_P - here->n_P).norm() / (there.p_P - here->p_P).norm());
      }
      const auto square = [](double x) { return std::min(4.0, x * x); };
      Cell& c = cells_[index(i, j)];
      c.trouble = trouble;
      c.cost = settings_.calm * (square(slope / kSteepPlace) + square(bend / kBent));
      if (settings_.rough) c.cost += settings_.calm * square(settings_.rough(here->p_P));
      if (settings_.near) c.cost += settings_.near(here->p_P);
    }
  }
  add_edges();
  if (settings_.unreachable) add_effort(settings_.unreachable);
}

void PlaceSearch::add_effort(const std::function<double(const SurfaceSample&)>& unreachable) {
  const int stride = std::max(1, static_cast<int>(settings_.reach_step / settings_.cell));
  for (int j = 0; j < ny_; j += stride) {
    for (int i = 0; i < nx_; i += stride) {
      std::vector<std::size_t> block;
      for (int y = j; y < std::min(ny_, j + stride); ++y)
        for (int x = i; x < std::min(nx_, i + stride); ++x)
          if (const auto k = static_cast<std::size_t>(y) * nx_ + x; !cells_[k].bad())
            block.push_back(k);
      if (block.empty()) continue;
      const double effort = unreachable(*seen_[block[block.size() / 2]]);
      for (const std::size_t k : block) {
        cells_[k].cost += kUnreachable * effort;
        if (effort >= 1.0) cells_[k].trouble = CellTrouble::unreachable;
      }
    }
  }
}

// Beside what is bad, and what nothing is known of.
void PlaceSearch::add_edges() {
  constexpr int kBeside = 2;
  for (int j = 0; j < ny_; ++j) {
    for (int i = 0; i < nx_; ++i) {
      double edge = 0.0;
      for (int y = j - kBeside; y <= j + kBeside; ++y)
        for (int x = i - kBeside; x <= i + kBeside; ++x)
          if (x < 0 || y < 0 || x >= nx_ || y >= ny_ ||
              cells_[static_cast<std::size_t>(y) * nx_ + x].bad())
            edge = std::max(edge, std::max(std::abs(x - i), std::abs(y - j)) < kBeside ? 1.0 : 0.5);
      cells_[static_cast<std::size_t>(j) * nx_ + i].cost += settings_.calm * edge;
    }
  }
}

std::size_t PlaceSearch::at(const Vector2d& p) const {
  const Vector2d q = (p - settings_.box.min()) / settings_.cell;
  if (!(q.x() >= 0 && q.y() >= 0 && q.x() < nx_ && q.y() < ny_)) return cells_.size();
  return static_cast<std::size_t>(q.y()) * nx_ + static_cast<std::size_t>(q.x());
}

void PlaceSearch::avoid(const std::vector<Vector2d>& points) {
  for (const Vector2d& p : points)
    if (const std::size_t k = at(p); k < cells_.size()) cells_[k].trouble = CellTrouble::avoided;
}

CellTrouble PlaceSearch::trouble(const Vector2d& p) const {
  const std::size_t k = at(p);
  return k < cells_.size() ? cells_[k].trouble : CellTrouble::missing;
}

double PlaceSearch::share(const std::vector<Vector2d>& drawing, const PlaceFound& place) const {
  const auto bad =
      std::ranges::count_if(drawing, [&](const Vector2d& p) { return is_bad(at(place(p))); });
  return 1.0 - static_cast<double>(bad) / static_cast<double>(drawing.size());
}

PlaceFound PlaceSearch::best(const std::vector<Vector2d>& drawing, double size,
                             const std::vector<PlaceFound>& tried) const {
  const auto is_tried = [&](const PlaceFound& p) {
    return std::any_of(tried.begin(), tried.end(), [&](const PlaceFound& t) {
      return t.size == p.size && (t.middle - p.middle).norm() < kGridStep &&
             std::abs(std::remainder(t.turn_deg - p.turn_deg, 360.0)) < kSame;
    });
  };
  PlaceFound best;
  const double count = static_cast<double>(drawing.size());
  std::vector<Vector2d> placed;  // about the middle
  const auto turn_to = [&](const PlaceFound& place) {
    placed.clear();
    for (const Vector2d& p : drawing)
      placed.push_back(place.size * (Eigen::Rotation2Dd(place.turn_deg * kDegree) * p));
  };
  const auto consider = [&](PlaceFound place) {
    const double turned = kTurned * std::abs(place.turn_deg) / 180.0;
    const double most = (best.cost - turned) * count;
    double cost = 0.0;
    int bad = 0;
    for (const Vector2d& p : placed) {
      const std::size_t k = at(place.middle + p);
      const bool out = is_bad(k);
      cost += out ? kBadCell + settings_.calm : 0.0;
      if (k < cells_.size()) cost += cells_[k].cost;
      bad += out;
      if (cost >= most) break;
    }
    if (cost >= most || is_tried(place)) return;
    place.cost = cost / count + turned;
    place.share = 1.0 - bad / count;
    best = place;
  };
  PlaceFound place;
  place.size = size;
  for (place.turn_deg = -180.0 + kStepTurn; place.turn_deg <= 180.0; place.turn_deg += kStepTurn) {
    turn_to(place);
    const auto &low = settings_.box.min(), &high = settings_.box.max();
    for (double x = low.x(); x <= high.x(); x += kGridStep)
      for (double y = low.y(); y <= high.y(); y += kGridStep) {
        place.middle = {x, y};
        consider(place);
      }
  }
  if (!std::isfinite(best.cost)) return best;
  for (const double finer : {0.5, 0.25}) {
    const PlaceFound about = best;
    for (int turn = -1; turn <= 1; ++turn) {
      place = about;
      place.turn_deg += turn * finer * kStepTurn;
      turn_to(place);
      for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y) {
          place.middle = about.middle + finer * kGridStep * Vector2d(x, y);
          consider(place);
        }
    }
  }
  return best;
}

}  // namespace impedraw
