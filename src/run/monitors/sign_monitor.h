// A check that the arm moves as torques and the measured wrench push it, and not the other way.
//
//   r     of each joint, M v̇ + C v + g − τ − Jᵀ F_ext: torque that nothing explains
//         (momentum_observer.h)
//   x→y   of each joint: τ − g → r.  Of each axis of the pen: J M⁻¹ Jᵀ F_ext → J M⁻¹ r.
//   z     of each axis of the pen: J M⁻¹ (τ − g + Jᵀ F_ext), the tip's acceleration by all that is
//         known
//
// A sign that is wrong makes y = −2 x; a wrench that is made up makes y = −x. Of changes, with ⟨⟩
// their mean over some 20 ms, of an x that grows and ⟨x y⟩² > 0.94 ⟨x²⟩⟨y²⟩:
//
//   joint     −2.5 < ⟨x y⟩/⟨x²⟩ < −1.5 between 13 and 30 Hz, with √⟨x²⟩ above 2 Nm and 1 % of the
//             joint's limit. What pushes on the arm unseen changes y at once, and x, the law's
//             answer, later: slower changes would take a shove on the elbow for a wrong sign.
//   wrench    the same between 2 and 30 Hz, with √⟨x²⟩ above 0.8 of the push and 4 N. Dry
//             friction of 3 Nm that begins to hold the arm as the pen lands looks alike, but
//             smaller. Across the pen's axis only above what contact at the tip explains: the
//             forces of a cut turn with its line, and joints stick.
//   made up   the same below −0.8, with 9 N
//   pull      as `wrench`, where the force has pulled at the pen along its axis by 2.5 N for 5 ms:
//             no surface pulls, and the law already drives the pen into it
//
// A law that makes the tip light answers a push with several times its force: z is 1/c of x. Masses
// that are wrong by a tenth then make y a tenth of z, in step with x, and dry friction adds to it.
// √⟨x²⟩ less a tenth of √⟨z²⟩ is what counts as made up.
//
// An arm that shakes, for springs in its joints that nobody told, moves against torques and forces
// all the time: ⟨y²⟩ counts above 9 times its mean over the last 10 s alone.
#pragma once

#include <array>

#include <fmt/format.h>

#include "impedraw/control/impedance_settings.h"
#include "impedraw/control/momentum_observer.h"
#include "impedraw/run/cycle.h"
#include "impedraw/run/monitors/verdict.h"

namespace impedraw {

class SignMonitor {
 public:
  // torque_limit: rated, of each joint [Nm].
  SignMonitor(const ImpedanceSettings& settings, const JointVector& torque_limit);

  // A cycle's state, the law's factors for it (null: none), its measured wrench and the torque that
  // it commanded [Nm]. Does not throw, and allocates for the text alone. Damps an arm whose wrench
  // is contradicted. A joint whose torque is ends the run at once: damping would drive it on.
  Verdict update(const ArmTerms& arm, const OperationalSpace* space, const Vector6& F_ext,
                 const JointVector& tau) noexcept;

  // The same, after a cycle.
  Verdict judge(const Cycle& cycle) {
    Verdict found = update(cycle.arm, cycle.space, cycle.F_ext, cycle.out.tau);
    if (found) found.cause += fmt::format(" at t = {:.3f} s", cycle.next_run_time());
    return found;
  }

  // Force along the pen's −z that r tells; 0 without a measured wrench [N].
  double held() const noexcept { return held_; }

 private:
  // Joints, then the pen's axes.
  using Channels = Eigen::Array<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxJoints + 3, 1>;
  static constexpr std::size_t kHistory = 32;  // steps

  bool felt_;
  double dt_, quick_share_, mean_share_;  // of a step that the low-passes follow
  double habit_share_;                    // the same of habit_
  std::size_t late_, step_ = 0;
  MomentumObserver observer_;
  std::array<JointVector, kHistory> weightless_;  // τ − g of past steps [Nm]
  JointVector v_;
  double held_ = 0.0;
  int lasts_ = 0;   // cycles
  Channels least_;  // √⟨x²⟩ of what is judged [Nm], [N]
  Channels slow_;   // the share of a step that the slow means follow
  Channels quick_, x_slow_, y_slow_;
  Channels size_quick_, size_slow_;             // of τ − g and F_ext
  Eigen::Array3d all_quick_, all_slow_, alls_;  // of z, and ⟨z²⟩
  Channels xx_, xy_, yy_, sizes_;               // ⟨⟩ of squares
  Channels habit_;                              // of ⟨y²⟩
};

}  // namespace impedraw
