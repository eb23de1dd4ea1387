// One run of a case of the force benchmark: a controller, an arm, a workpiece.
//
// The simulated arm gets the case's workpiece and starts anew for each run. An arm that is not
// simulated here keeps its session and its workpiece, which must be the standard bowl, and the pen
// goes from run to run. The force is the simulator's contact force along the true normal or, from
// another arm, the measured wrench along the believed one, or the readings of a sensor in a file.
//
// Differences between runs: noise and bias of the sensors, and where the controllers believe the
// workpiece to be, off by 0.5 mm along z and 0.5° about x and y (standard deviations). All
// controllers get the same ones.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "impedraw/control/arm_terms.h"
#include "impedraw/control/damping.h"
#include "impedraw/control/operational_space.h"
#include "impedraw/control/tip_reference.h"
#include "impedraw/experiment/prepare.h"
#include "impedraw/judge/force_case.h"
#include "impedraw/judge/force_metrics.h"
#include "impedraw/run/draw_into.h"
#include "impedraw/run/driver.h"
#include "impedraw/run/held_arm.h"

namespace impedraw {

// CRISP's Cartesian impedance law, written here from its paper and documentation: a peer that the
// force benchmark compares with. It is not CRISP's code.
//
// Law       τ = Jᵀ ( K e − D J v ) + N ( K_n (q_0 − q) − D_n v ) + C v + g + Jᵀ W
//           e    position and rotation vector to the target pose, each axis clipped
//           N    I − J⁺ J, J⁺ the pseudo-inverse
//           W    target wrench: −F_n n, while the pen should press
//           |Δτ| ≤ max_delta_tau a step, on the whole torque
// Gains     those of default_cartesian_impedance.yaml of crisp_py: 600 N/m, 30 Nm/rad, 60 N s/m,
//           10 Nm s/rad, 5 Nm/rad, D_n = 2 √K_n. Equal along all axes, so that it does not matter
//           that CRISP takes them in the tool's axes.
// Left out  friction feed-forward (its parameters are an FR3's), filters (off), joint-limit torque
// Source    D. San José Pro, O. Hausdörfer, R. Römer, M. Dösch, M. Schuck, A. P. Schoellig,
//           "CRISP – Compliant ROS2 Controllers for Learning-Based Manipulation Policies and
//           Teleoperation", arXiv 2509.06819, 2025.
struct CrispGains {
  double stiffness = 600.0, rotational_stiffness = 30.0;  // K [N/m], [Nm/rad]
  double damping = 60.0, rotational_damping = 10.0;       // D [N s/m], [Nm s/rad]
  double null_stiffness = 5.0;                            // K_n [Nm/rad]
  double clip = 0.1, rotational_clip = 0.5;               // of e [m], [rad]
  double max_delta_tau = 0.5;                             // a step [Nm]
};

class CrispLaw {
 public:
  explicit CrispLaw(const JointVector& q_0, const CrispGains& gains = {});

  // One step. `press`: F_n now [N]. The target's turn about the pen is that of the first step.
  const JointVector& step(const ArmTerms& arm, const TipReference& reference,
                          double press) noexcept;

 private:
  CrispGains gains_;
  JointVector q_0_, tau_;
  Eigen::Matrix3d R_WD_ = Eigen::Matrix3d::Identity();
  bool begun_ = false;
};

// A plain impedance law with feed-forward force, written here: a peer that the force benchmark
// compares with.
//
// Law       F = Λ (V̇_d − J̇v) + J̄ᵀ C v + B (V_d − V) + K e − F_n n
//           τ = Jᵀ F + (I − Jᵀ J̄ᵀ) τ_null + g
// Loop      Λ (V̇ − V̇_d) = B (V_d − V) + K e − F_n n + F_ext: the arm keeps its inertia
// Gains     2000 N/m, 200 Nm/rad, equal along all axes, as an LBR iiwa's own impedance mode
//           proposes; B by double diagonalisation, ζ = 0.7 (damping.h); null space 10 Nm/rad
// Source    N. Hogan, "Impedance control: an approach to manipulation", ASME JDSMC 107(1), 1985;
//           A. Albu-Schäffer, C. Ott, U. Frese, G. Hirzinger, "Cartesian impedance control of
//           redundant robots: recent results with the DLR light-weight-arms", ICRA 2003.

struct FeedforwardGains {
  double stiffness = 2000.0, rotational_stiffness = 200.0;  // K [N/m], [Nm/rad]
  double damping_ratio = 0.7;                               // ζ
  double null_stiffness = 10.0;                             // [Nm/rad]
};

class FeedforwardLaw {
 public:
  explicit FeedforwardLaw(const JointVector& q_0, const FeedforwardGains& gains = {});

  // One step. `press`: F_n now [N]. The turn about the pen is free, but damped.
  const JointVector& step(const ArmTerms& arm, const TipReference& reference,
                          double press) noexcept;

 private:
  FeedforwardGains gains_;
  JointVector q_0_, tau_;
  OperationalSpace space_;
  ModalDamping damping_;
};

enum class ForceController {
  ours,       // this program's (control/impedance.h)
  crisp,      // force_trial.h
  impedance,  // force_trial.h
};
inline constexpr std::string_view kForceControllerNames[] = {"ours", "crisp", "impedance"};
// As the page calls them.
inline constexpr std::string_view kForceControllerTitles[] = {
    "impedraw", "CRISP's law (written here)", "impedance with feed-forward (written here)"};

struct ForceRun {
  std::string ended;                 // why it ended early; empty: it did not
  double begin = 0.0;                // by the driver's clock [s]
  int order = 0;                     // its number for a rig; 0: there is none
  std::vector<JudgedSample> record;  // the whole of it; a force that nothing measures is NaN
  ForceQuestion question;            // for judge_force()
  std::optional<ForceProgramme> programme;

  // Finds the touch in the record, and with it the question.
  void ask();
};

// Readings of a sensor under the workpiece that is not the arm's own: a CSV file with the columns
// time, by the arm's clock since its session began [s], and force along the normal [N]; or, where a
// rig knows the runs, with run, time since its first torque, and force.
class SensorFile {
 public:
  // Waits for the file for `patience` [s]. Throws InputError that names the line at fault.
  SensorFile(const std::filesystem::path& file, double patience);
  void fill(ForceRun* run) const;  // the record's forces, between readings evenly

 private:
  struct Reading {
    int run = 0;  // 0: the file has no runs
    double time = 0.0, force = 0.0;

    bool before(const Reading& other) const {
      return run != other.run ? run < other.run : time < other.time;
    }
  };
  std::vector<Reading> readings_;
};

class ForceBench {
 public:
  // experiment: with an arm and its control set-up; its canvas is replaced. make_driver: as
  // draw_into()'s. has_sensor: the force is in a file (SensorFile). rig: file that each run's order
  // is written to as a whole before its first torque (force_rig.h). Throws InputError where nothing
  // measures the force, and what starting throws.
  ForceBench(Prepared& experiment, const DriverMaker& make_driver, bool has_sensor,
             std::filesystem::path rig = {});
  ~ForceBench();

  // seed: 1 for the first run. `go_on` is asked each cycle; false: the pen goes up, and the run
  // has ended early.
  ForceRun run(const ForceCase& c, ForceController controller, int seed,
               const std::function<bool()>& go_on);
  // The reason why a driven arm can no longer be used; empty while it can.
  std::string fault() const;

 private:
  struct Law;
  void set_shape(Workpiece::Shape shape);
  void hold();
  // The driven arm, for the next run: damps a motion that ended early, and recovers from a reflex.
  void make_ready(const ForceRun& run, Law* law, const ArmState* state);

  Prepared& e_;
  Workpiece piece_;
  Scenario as_given_;
  std::unique_ptr<Driver> driver_;         // null: a simulated arm for each run
  const ArmState* state_ = nullptr;        // of the driven arm, not yet answered
  std::optional<HeldArm> held_;            // between two runs, on a wall clock
  std::optional<Workpiece::Shape> shape_;  // of the simulated workpiece
  std::filesystem::path rig_;              // file of its orders; empty: none
  int orders_ = 0;                         // given to it
};

}  // namespace impedraw
