// The parts of a drawing that remain, and paths for them.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include "impedraw/experiment/experiment.h"
#include "impedraw/planning/stroke_part.h"

namespace impedraw {

// Tracks which parts of the strokes have ink, from contact state and measured force. Uses no
// simulator truth. A hand that lifts the pen with the force of the push reads like the surface and
// counts as ink until the contact state changes.
class InkWatch {
 public:
  // A pen writes if it is in contact and the force, if measured, is at least this [N].
  static double least_force(double push) { return std::max(0.3, 0.1 * push); }

  // Adds samples in drawing order. `stroke` < 0: the plan is between strokes.
  void add(int stroke, double along, bool writes) {
    if (stroke < 0 || !writes) {
      open_ = false;
    } else if (open_ && parts_.back().stroke == stroke) {
      parts_.back().from = std::min(parts_.back().from, along);
      parts_.back().to = std::max(parts_.back().to, along);
    } else {
      parts_.push_back({stroke, along, along});
      open_ = true;
    }
  }

  // The parts that have ink.
  const std::vector<StrokePart>& parts() const { return parts_; }

 private:
  std::vector<StrokePart> parts_;
  bool open_ = false;
};

// Places of strokes that the pen keeps off, because something barred its way there.
//
// A path that goes on beyond a blocked place begins kBeyond after it. If the pen is blocked within
// kSame of there again, the distance doubles, time after time, until the obstacle is passed.
class BlockedPlaces {
 public:
  static constexpr double kBefore = 1e-3;     // distance kept before a blocked place [m]
  static constexpr double kBeyond = 2e-3;     // first distance kept behind it [m]
  static constexpr double kSame = 1e-2;       // blocked places as near as this are one place [m]
  static constexpr double kUnreached = 5e-3;  // kept around what the arm cannot follow [m]
  static constexpr std::size_t kMost = 200;   // after so many, a drawing gives up

  // The pen was blocked at this place.
  void add(const StrokePart& at) {
    const bool again = !parts_.empty() && parts_.back().stroke == at.stroke &&
                       at.to > parts_.back().from - kSame && at.to < parts_.back().to + kSame;
    beyond_ = again ? 2.0 * beyond_ : kBeyond;
    parts_.push_back({at.stroke, at.from - kBefore, at.to + beyond_});
  }
  // No way leads to this stroke.
  void add_stroke(const StrokePart& stroke) { parts_.push_back(stroke); }
  // The arm cannot follow this part.
  void add_unreached(const StrokePart& part) {
    parts_.push_back({part.stroke, part.from - kUnreached, part.to + kUnreached});
  }

  const std::vector<StrokePart>& parts() const { return parts_; }
  bool full() const { return parts_.size() >= kMost; }

 private:
  std::vector<StrokePart> parts_;  // in the order in which they were found
  double beyond_ = kBeyond;        // the last distance kept [m]
};

inline constexpr double kShortestGap = 1e-3;  // shorter gaps are ignored [m]
// A pad's face has treated what its centre passes by, and gaps of its centre's way, up to this [m];
// 0: another tool.
double face_reach(const Experiment& experiment);
// Overlap of a redrawn part with the ink at each end [m].
inline constexpr double kRedrawOverlap = 1e-3;

// True if the part shares a piece of its stroke with any of the others.
bool overlaps(const StrokePart& part, const std::vector<StrokePart>& others);

// The parts, overlapping what they adjoin at both ends; a whole stroke as it is.
std::vector<PlacedStroke> strokes_of(const Experiment& experiment,
                                     const std::vector<StrokePart>& parts);

// The parts of the planned strokes that have no ink, except those given up.
std::vector<StrokePart> remaining(const Experiment& experiment, const InkWatch& ink,
                                  const std::vector<StrokePart>& given_up = {});

// A path for the parts, from the tip's pose in K: at p_KE, with the normal n_K. `hold`: time before
// the first motion [s]; q: the posture, for a led heading, else that of the start. Its ways are as
// high as those of the whole plan. Throws OffSurface where the surface has ended.
TipPath path_for(const Experiment& experiment, const std::vector<StrokePart>& parts,
                 const Eigen::Vector3d& p_KE, const Eigen::Vector3d& n_K, double hold,
                 const JointVector* q = nullptr);

// Takes the place that was off the surface out of the parts. Called while `off` is handled; throws
// it again if nothing is taken out.
void take_out(const Experiment& experiment, const OffSurface& off, std::vector<StrokePart>* parts);

// plan(parts). From another start the surface may end a little earlier, at its edges: what is
// missed there is taken out of the parts.
template <class PlanParts>
auto without_misses(const Experiment& e, std::vector<StrokePart>* parts, PlanParts&& plan) {
  while (true) {
    try {
      return plan(*parts);
    } catch (const OffSurface& off) {
      take_out(e, off, parts);
    }
  }
}

// path_for() without what it would miss. Empty if nothing is left.
TipPath path_without_misses(const Experiment& experiment, std::vector<StrokePart>* parts,
                            const Eigen::Vector3d& p_KE, const Eigen::Vector3d& n_K, double hold,
                            const JointVector* q = nullptr);

// path_without_misses(), of which the arm reaches every way: they are others than those that were
// checked before the run. What they cannot reach is taken out of the parts, and blocked.
TipPath checked_path(const Experiment& experiment, std::vector<StrokePart>* parts,
                     const Eigen::Vector3d& p_KE, const Eigen::Vector3d& n_K, double hold,
                     const JointVector& q, BlockedPlaces* blocked);

}  // namespace impedraw
