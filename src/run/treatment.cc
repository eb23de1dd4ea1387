#include "impedraw/run/treatment.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace impedraw {

TreatmentMap::TreatmentMap(SurfaceGrid grid, const PadSettings& pad, double force, double speed,
                           double doubt)
    : grid_(std::move(grid)),
      pad_(pad),
      band_(kBand - doubt),
      asked_(force / pad.area()),
      speed_(speed),
      crossing_(2.0 * pad.radius / speed),
      dose_(grid_.size(), 0.0),
      good_(grid_.size(), 0.0),
      last_(grid_.size(), -1e9),
      visits_(grid_.size(), 0) {}

void TreatmentMap::press(const Pose& X_PE, double force, const Eigen::Vector3d& v_P, double time,
                         double dt, bool on_line) {
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
  const bool good = std::abs(mean_ / asked_ - 1.0) <= band_;
  under_.clear();
  double area = 0.0, moment = 0.0;
  const Pose X_EP = X_PE.inverse();
  around(grid_, X_PE.p, pad_.radius + pad_.thickness, [&](std::size_t v) {
    const Eigen::Vector3d q = X_EP * grid_.point(v);
    if (q.head<2>().norm() > pad_.radius) return;
    under_.emplace_back(v, q.z());
    area += grid_.area[v];
    moment += grid_.area[v] * q.z();
  });
  // Places that do not touch drop out until all that are left do.
  double depth = 0.0;
  for (std::size_t before = 0; before != under_.size() && !under_.empty();) {
    before = under_.size();
    depth = (force / pad_.stiffness + moment) / area;
    std::erase_if(under_, [&](const auto& place) {
      if (place.second < depth) return false;
      area -= grid_.area[place.first];
      moment -= grid_.area[place.first] * place.second;
      return true;
    });
  }
  for (const auto& [v, z] : under_) {
    dose_[v] += pad_.stiffness * (depth - z) * speed * dt;
    if (good) good_[v] += dt;
    if (time - last_[v] > kApart) ++visits_[v];
    last_[v] = time;
  }
}

double TreatmentMap::pressure_mean() const { return slid_ > 0.0 ? sum_ / slid_ : 0.0; }

double TreatmentMap::pressure_sd() const {
  if (!(slid_ > 0.0)) return 0.0;
  const double mean = sum_ / slid_;
  return std::sqrt(std::max(0.0, sum2_ / slid_ - mean * mean));
}

TreatmentShares shares_of(const TreatmentMap& map, const std::vector<char>& places) {
  TreatmentShares s;
  double sum2 = 0.0;
  for (std::size_t v = 0; v < places.size(); ++v) {
    if (!places[v]) continue;
    const double area = map.area(v);
    s.area += area;
    if (map.treated(v)) s.treated += area;
    if (map.visits(v) > 1) s.twice += area;
    s.dose_mean += area * map.dose(v);
    sum2 += area * map.dose(v) * map.dose(v);
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
