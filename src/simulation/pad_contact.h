// Contact of a face with the canvas: a rigid disc that carries a layer of foam, or a line, which is
// the edge of a blade (blade_law.h) or the roller's line of contact. What gives way is a bed of
// independent springs (Winkler), and each of its cells slides by Coulomb's law.
//
//   δ_i  = ray from the disc at cell i along z_E, which meets the canvas within the foam [m]
//   p_i  = max(0, k δ_i − b n_i·v_i)                             pressure [Pa], along n_i; of a
//          disc also where the canvas stands up to a foam's thickness behind it: more foam than
//          there is gives way, and nothing falls through
//   s_i ← s_i + (1 − n_i n_iᵀ) v_i dt,  |k_s s_i| ≤ μ p_i         shear, k_s = k/2
//   of a line: |k_s s_i·a| ≤ μ p_i,  |k_s s_i·b| ≤ μ_across p_i;  a: x_E along the surface,
//   b = n × a; k_s = 20 k: what is cut gives way by a tenth of the depth
//   F    = Σ A_i (p_i n_i − k_s s_i)                              and its moment about E
//
// v_i: velocity of the foam's face at the cell relative to the canvas. The free face lies `rest`
// before E, so that E lies on a flat canvas that the pad presses with k π r² `rest`.
//
// Passive joints turn the disc about their centre, `pivot` behind it, by the moment M about that:
//
//   θ̇ ← (M + b I θ̇)/(c + b I + k I dt),  |θ_i| ≤ kJointEnd,  I = π r⁴/4
//   c θ̇ = M, implicit in the foam's stiffness and damping
//
// They pass on c θ̇ about their axes, and M at their ends. The disc has no weight, and keeps θ in
// the air. Sliding tilts it by μ F L/(k π r⁴/4), L: from the centre to the surface.
//
// On a plane, pressed by d and tilted by θ: F = k π r² d, M = k π r⁴/4 θ; sliding |F_t| = μ F;
// turning on the spot M = 2/3 μ F r; a line, on the spot about its middle, M = μ_across F r/2.
#pragma once

#include <array>

#include <Eigen/Core>

#include "impedraw/canvas/canvas.h"
#include "impedraw/common/pose.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

struct PadLoad {
  bool touching = false;
  Eigen::Vector3d f = Eigen::Vector3d::Zero();   // of the canvas on the pad [N]
  Eigen::Vector3d m = Eigen::Vector3d::Zero();   // its moment about E [Nm]
  Eigen::Vector3d n = Eigen::Vector3d::UnitZ();  // of the cells, weighted by their pressure; unit
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // of pressure [m]
};

class PadContact {
 public:
  static constexpr double kLineShear = 20.0;
  static constexpr double kJointDamping = 1e-3, kJointEnd = 0.35;           // c [Nm s/rad], [rad]
  static constexpr int kRings = 3, kCells = 1 + 3 * kRings * (kRings + 1);  // of equal area

  explicit PadContact(const PadSettings& settings);

  void reset() noexcept;
  // X_KE, V_KE: of E in the canvas's frame and relative to it, V_KE = [v; ω]. The result is in K.
  // Advances the shear by dt. Allocates nothing.
  const PadLoad& press(const Canvas& canvas, const Pose& X_KE, const Vector6& V_KE,
                       double dt) noexcept;

  const PadSettings& settings() const { return settings_; }
  const Eigen::Vector2d& tilt() const { return tilt_; }  // θ of the joints, about x_E and y_E [rad]
  const std::array<Eigen::Vector2d, kCells>& cells() const { return cells_; }  // in E [m]
  const std::array<double, kCells>& pressures() const { return pressure_; }    // [Pa]

 private:
  // As press(), for the frame of the disc, whatever turns it.
  void press_face(const Canvas& canvas, const Pose& X_KD, const Vector6& V_KD, double dt) noexcept;

  PadSettings settings_;
  std::array<Eigen::Vector2d, kCells> cells_;
  std::array<double, kCells> pressure_;
  std::array<Eigen::Vector3d, kCells> shear_;  // in K [m]
  Eigen::Vector2d tilt_ = Eigen::Vector2d::Zero(), rate_ = Eigen::Vector2d::Zero();
  PadLoad load_;
};

}  // namespace impedraw
