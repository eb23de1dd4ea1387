// Pre-flight findings as text. Strokes have the artwork's numbers.
#pragma once

#include <string>

#include "impedraw/planning/preflight/preflight.h"

namespace impedraw {

// Names the stroke, the part of it, the problem, its size and its location.
std::string finding_text(const Finding& finding);

// The same, as the error message of a refused drawing. `seen`: the surface was seen by cameras.
std::string refusal_text(const Finding& finding, bool seen);

}  // namespace impedraw
