#include "impedraw/run/treatment.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Cholesky>

#include "impedraw/planning/cover/cover_lines.h"

namespace impedraw {

TreatmentMap::TreatmentMap(SurfaceGrid grid, const PadSettings& pad, double force, double speed,
                           double doubt)
    : grid_(std::move(grid)),
      pad_(pad),
      doubt_(doubt),
      asked_(force / pad.area()),
      speed_(speed),
      crossing_(2.0 * pad.radius / speed),
      dose_(grid_.size(), 0.0),
      good_(grid_.size(), 0.0),
      last_(grid_.size(), -1e9),
      visits_(grid_.size(), 0) {}

void TreatmentMap::press(const Pose& X_PE, double force, const Eigen::Vector3d& v_P, double time,
                         double dt, bool on_line, double share) {
  const double speed = v_P.cross(X_PE.R.col(2)).norm();
  const double pressure = force / pad_.area();
  if (time - last_time_ > kApart) mean_ = pressure;
  mean_ += std::min(1.0, dt / kMean) * (pressure - mean_);
  last_time_ = time;
  if (on_line && speed > 0.1 * speed_) {
    slid_ += dt;
    sum_ += dt * pressure;
    sum2_ += dt * pressure * pressure;
  }
  const bool good = std::abs(mean_ / asked_ - share) <= kBand - doubt_;
  under_.clear();
  const Pose X_EP = X_PE.inverse();
  const Eigen::Vector3d up = -X_PE.R.col(2);
  around(grid_, X_PE.p, pad_.radius + pad_.thickness, [&](std::size_t v) {
    const Eigen::Vector3d q = X_EP * grid_.point(v);
    if (q.head<2>().norm() > pad_.radius) return;
    const double facing = up.z() - up.head<2>().dot(grid_.slope(v));
    under_.push_back({v, q, grid_.step * grid_.step * std::max(0.0, facing)});
  });
  const Eigen::Vector3d along =
      speed > 0.0 ? Eigen::Vector3d(X_EP.R * v_P / speed) : Eigen::Vector3d::Zero();
  // Places that do not touch drop out until all that are left do.
  Eigen::Vector3d lies = Eigen::Vector3d::Zero();
  const auto depth = [&lies](const Eigen::Vector3d& q) {
    return lies[0] + lies[1] * q.x() + lies[2] * q.y() - q.z();
  };
  for (std::size_t before = 0; before != under_.size() && !under_.empty();) {
    before = under_.size();
    lies = lying(force, along);
    std::erase_if(under_, [&](const Place& place) { return !(depth(place.q) > 0.0); });
  }
  for (const auto& [v, q, area] : under_) {
    dose_[v] += pad_.stiffness * depth(q) * speed * dt;
    if (good && (doubt_ == 0.0 || wherever_it_lies(grid_, v, [&](const Eigen::Vector3d& p) {
                   const Eigen::Vector3d at = X_EP * p;
                   return at.head<2>().norm() <= pad_.radius && depth(at) > 0.0;
                 })))
      good_[v] += dt;
    if (time - last_[v] > kApart) ++visits_[v];
    last_[v] = time;
  }
}

Eigen::Vector3d TreatmentMap::lying(double force, const Eigen::Vector3d& along) const {
  Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const auto& [v, q, area] : under_) {
    const Eigen::Vector3d row(1.0, q.x(), q.y());
    A += area * row * row.transpose();
    b += area * q.z() * row;
  }
  const double lever = pad_.friction * pad_.lever();
  b += force / pad_.stiffness * Eigen::Vector3d(1.0, lever * along.x(), lever * along.y());
  Eigen::Vector3d lies(b[0] / A(0, 0), 0.0, 0.0);
  if (pad_.joints == 1) {  // about x: it tilts along y
    const Eigen::Vector2d d_t = (Eigen::Matrix2d() << A(0, 0), A(0, 2), A(0, 2), A(2, 2))
                                    .finished()
                                    .ldlt()
                                    .solve(Eigen::Vector2d(b[0], b[2]));
    lies << d_t[0], 0.0, d_t[1];
  } else if (pad_.joints == 2) {
    lies = A.ldlt().solve(b);
  }
  return lies;
}

double TreatmentMap::pressure_mean() const { return slid_ > 0.0 ? sum_ / slid_ : 0.0; }

double TreatmentMap::pressure_sd() const {
  if (!(slid_ > 0.0)) return 0.0;
  const double mean = sum_ / slid_;
  return std::sqrt(std::max(0.0, sum2_ / slid_ - mean * mean));
}

TreatmentShares shares_of(const TreatmentMap& map, const std::vector<char>& places,
                          const std::vector<double>& share) {
  TreatmentShares s;
  double sum2 = 0.0;
  for (std::size_t v = 0; v < places.size(); ++v) {
    if (!places[v]) continue;
    const double area = map.area(v);
    s.area += area;
    if (map.treated(v)) s.treated += area;
    if (map.visits(v) > 1) s.twice += area;
    const double dose = map.dose(v) / (share.empty() ? 1.0 : share[v]);
    s.dose_mean += area * dose;
    sum2 += area * dose * dose;
  }
  if (!(s.area > 0.0)) return s;
  s.dose_mean /= s.area;
  if (s.dose_mean > 0.0)
    s.dose_cv = std::sqrt(std::max(0.0, sum2 / s.area - s.dose_mean * s.dose_mean)) / s.dose_mean;
  return s;
}

std::vector<MissedPatch> missed(const TreatmentMap& map, const std::vector<char>& places) {
  const SurfaceGrid& g = map.grid();
  std::vector<char> open(places.size());
  for (std::size_t v = 0; v < places.size(); ++v) open[v] = places[v] && !map.treated(v);
  std::vector<MissedPatch> patches;
  std::vector<std::size_t> stack;
  for (std::size_t seed = 0; seed < open.size(); ++seed) {
    if (!open[seed]) continue;
    MissedPatch patch{Eigen::Vector3d::Zero(), 0.0};
    stack = {seed};
    open[seed] = 0;
    while (!stack.empty()) {
      const std::size_t v = stack.back();
      stack.pop_back();
      patch.area += map.area(v);
      patch.middle_P += map.area(v) * g.point(v);
      for (int dj = -1; dj <= 1; ++dj)
        for (int di = -1; di <= 1; ++di) {
          const int i = g.i_of(v) + di, j = g.j_of(v) + dj;
          if (i < 0 || i >= g.nx || j < 0 || j >= g.ny || !open[g.index(i, j)]) continue;
          open[g.index(i, j)] = 0;
          stack.push_back(g.index(i, j));
        }
    }
    patch.middle_P /= patch.area;
    patches.push_back(patch);
  }
  return patches;
}

}  // namespace impedraw
