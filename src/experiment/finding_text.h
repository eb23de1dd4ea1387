// What the pre-flight found, as a line for a reader. Strokes have the artwork's numbers.
#pragma once

#include <string>

#include "impedraw/planning/preflight/preflight.h"

namespace impedraw {

// Which stroke of the artwork, which part of it, what, how much, where.
std::string finding_text(const Finding& finding);

// The same for somebody whose drawing is refused because of it. `seen`: by cameras.
std::string refusal_text(const Finding& finding, bool seen);

}  // namespace impedraw
