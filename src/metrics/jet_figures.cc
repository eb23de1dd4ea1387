#include "impedraw/metrics/jet_figures.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <nlohmann/json.hpp>

#include "impedraw/canvas/canvas.h"

namespace impedraw {

JetFigures::JetFigures(const TriangleMesh& canvas, double stand_off)
    : canvas_(std::make_unique<Canvas>(canvas)), stand_off_(stand_off) {}
JetFigures::~JetFigures() = default;

void JetFigures::add(const LogRow& row) {
  const double dt = row.time - std::exchange(time_, row.time);
  const bool goes_on = row.stroke == std::exchange(stroke_, row.stroke) && dt > 0.0;
  const std::optional<Eigen::Vector3d> before = std::exchange(met_K_, std::nullopt);
  if (row.stroke < 0) return;
  rows_ += 1.0;
  const Pose X_KW = row.canvas_pose.inverse();
  const Eigen::Vector3d z = X_KW.R * (row.tip_orientation * Eigen::Vector3d::UnitZ()),
                        nozzle = X_KW * row.tip_position - stand_off_ * z;
  const auto hit = canvas_->ray(nozzle, z);
  if (!hit) return;
  hits_ += 1.0;
  const double error = hit->t - stand_off_;
  square_ += error * error;
  most_ = std::max(most_, std::abs(error));
  met_K_ = nozzle + hit->t * z;
  if (!before || !goes_on) return;
  const double moved = (*met_K_ - *before).norm();
  open_ += dt;
  way_ += moved;
  square_speed_ += moved * moved / dt;
}

nlohmann::ordered_json JetFigures::metrics() const {
  nlohmann::ordered_json out;
  for (const char* name : {"stand_off_error_rms", "stand_off_error_max", "jet_speed_mean",
                           "jet_speed_sd", "jet_missed_share"})
    out[name] = nullptr;
  if (rows_ > 0.0) out["jet_missed_share"] = 1.0 - hits_ / rows_;
  if (hits_ > 0.0) {
    out["stand_off_error_rms"] = 1e3 * std::sqrt(square_ / hits_);
    out["stand_off_error_max"] = 1e3 * most_;
  }
  if (open_ > 0.0) {
    const double mean = way_ / open_;
    out["jet_speed_mean"] = 1e3 * mean;
    out["jet_speed_sd"] = 1e3 * std::sqrt(std::max(0.0, square_speed_ / open_ - mean * mean));
  }
  return out;
}

}  // namespace impedraw
