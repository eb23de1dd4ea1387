// A pad's treatment, place by place, from its poses and forces: the world's for the truth, the
// arm's own for what it knows.
//
//   p_i = k max(0, d + t·(x, y)_i − z_i) within r of the pad's axis                   pressure [Pa]
//   Σ p dA = f,  and of a pad with joints  Σ p (x, y) dA = μ f L v̂                  d [m], t [rad]
//   dose = ∫ p v dt      Preston: what is removed is k times this, k of the material    [Pa m]
//
// (x, y, z)_i: of the place in E; t = 0 about axes without a joint. dA: of the disc, not of the
// surface: a steep wall under the disc has a large area and bears no more for it. L: from the
// joints' centre to the surface: friction makes the disc lean forward. The force tells how deep the
// foam is pressed, and the joints how it lies, wherever the grid believes that the surface lies.
//
// A place is treated once it was pressed for kShare of the time in which a footprint passes over
// it, while the pad's mean pressure, over kMean, was within kBand of the one asked for.
#pragma once

#include <vector>

#include "impedraw/common/pose.h"
#include "impedraw/planning/cover/surface_grid.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

class TreatmentMap {
 public:
  static constexpr double kShare = 0.1, kMean = 0.02, kBand = 0.1;

  // force: asked for [N]; speed: of the passes [m/s]; doubt: in the force, a share of it, by which
  // the band is narrower. With a doubt a place is treated only if it is so wherever it lies
  // (cover_lines.h).
  TreatmentMap(SurfaceGrid grid, const PadSettings& pad, double force, double speed,
               double doubt = 0.0);

  // The pad is at X_PE, presses with this force along its normal and moves with v_P [m/s], for dt.
  // It slides across its axis only: what is set down or lifted removes nothing.
  // `on_line`: counts towards the mean pressure and its SD. `share`: of the force, that is asked
  // for there; the band is of the whole force.
  void press(const Pose& X_PE, double force, const Eigen::Vector3d& v_P, double time, double dt,
             bool on_line = true, double share = 1.0);

  const SurfaceGrid& grid() const { return grid_; }
  double area(std::size_t v) const { return grid_.area[v]; }  // of a place [m²]
  double dose(std::size_t v) const { return dose_[v]; }       // [Pa m]
  bool treated(std::size_t v) const { return good_[v] >= kShare * crossing_; }
  int visits(std::size_t v) const { return visits_[v]; }  // apart by kApart
  // The pad's mean pressure, while it slides at over a tenth of its speed [Pa].
  double pressure_mean() const;
  double pressure_sd() const;

 private:
  static constexpr double kApart = 0.1;  // [s]

  SurfaceGrid grid_;
  PadSettings pad_;
  double doubt_, asked_, speed_, crossing_;  // 1, [Pa], [m/s], [s]
  double mean_ = 0.0;                        // of the pad's pressure over kMean [Pa]
  double last_time_ = -1.0;
  double sum_ = 0.0, sum2_ = 0.0, slid_ = 0.0;
  std::vector<double> dose_, good_, last_;
  std::vector<int> visits_;
  // A vertex under the pad; its place is in E [m], its area that of its part of the disc [m²].
  struct Place {
    std::size_t v;
    Eigen::Vector3d q;
    double area;
  };
  std::vector<Place> under_;
  // (d, t) of those places: `along`: v̂ in E.
  Eigen::Vector3d lying(double force, const Eigen::Vector3d& along) const;
};

// Treated share of the marked places, and the mean and the coefficient of variation of their dose
// over the share that each is to get (empty: the same).
struct TreatmentShares {
  double area = 0.0, treated = 0.0, twice = 0.0;  // [m²]; visited more than once
  double dose_mean = 0.0, dose_cv = 0.0;
};
TreatmentShares shares_of(const TreatmentMap& map, const std::vector<char>& places,
                          const std::vector<double>& share = {});

// Patches of places that are marked and not treated.
struct MissedPatch {
  Eigen::Vector3d middle_P;
  double area;  // [m²]
};
std::vector<MissedPatch> missed(const TreatmentMap& map, const std::vector<char>& places);

}  // namespace impedraw
