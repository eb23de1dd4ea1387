// How many seeds a test of random inputs runs.
#pragma once

#include <cstdlib>

namespace impedraw {

// `usual`, or `all` where IMPEDRAW_LONG is set, as ./check --all sets it.
inline unsigned seeds(unsigned usual, unsigned all) {
  return std::getenv("IMPEDRAW_LONG") ? all : usual;
}

}  // namespace impedraw
