// Bounds how long a library may work that cannot be interrupted.
#pragma once

#include <functional>

namespace impedraw {

// Runs `work` in a thread of its own, and rethrows what it throws. False: it has used up `seconds`
// of CPU time (a busy machine makes no drawing a bad one) and is abandoned. It then goes on by
// itself, so that it must own all that it uses.
bool done_within(double seconds, std::function<void()> work);

}  // namespace impedraw
