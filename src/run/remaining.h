// The parts of a drawing that remain, and paths for them.
#pragma once

#include <optional>
#include <vector>

#include "impedraw/experiment/experiment.h"
#include "impedraw/run/blocked_places.h"
#include "impedraw/run/ink_watch.h"

namespace impedraw {

inline constexpr double kShortestGap = 1e-3;  // shorter gaps are ignored [m]
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
// the first motion [s]; q: the posture, for a led heading, else that of the start. Throws OffSurface
// where the surface has ended.
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

// A path for what remains, from the posture q with the tip at X_KE. Its ways are others than those
// that were checked before the run: a stroke that they cannot reach is blocked, too. Nothing: no
// part remains.
std::optional<TipPath> path_around(const Experiment& experiment, const JointVector& q,
                                   const Pose& X_KE, const InkWatch& ink, BlockedPlaces* blocked);

}  // namespace impedraw
