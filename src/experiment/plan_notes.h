// What a plan says of doubtful places: where the wrap is not certain, where the force cannot follow
// the widths, and why the planner's surface ends.
#pragma once

#include <string>
#include <vector>

#include "impedraw/experiment/plan.h"

namespace impedraw {

// By how much the drawing would lie elsewhere on the surface, RMS, if the same cells were laid flat
// with the heights as the finest patches see them [m]. 0 where these add nothing; infinite where
// the cells cannot be laid flat with them. The plan must have a wrap.
double wrap_doubt(const Plan& plan, const Belief& belief);
void note_wrap(double doubt, std::vector<std::string>* notes);

// Notes where widths change faster than the force may.
void note_spread_forces(const PathSettings& path, Plan* plan);

// Names what ends the surface at the finding: it ends at creases, and at steps that the cameras do
// not resolve (normals.h).
void name_step(const Belief& belief, double roughest, Finding* finding);

}  // namespace impedraw
