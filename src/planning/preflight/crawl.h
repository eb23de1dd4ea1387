// Stretches of a timed path along which the pen would crawl.
//
// Speed is judged over windows of kCrawlWindow along a stroke, on the surface, so that a corner
// with its full stop counts for little. A window crawls if it is slower than `least_speed` and
// takes more than `slowed` times as long as on the `unhindered` path: what a line's own corners
// take is not held against it. Windows that touch are one stretch; its ends are trimmed to where
// the pen is slower than `least_speed` over kCrawlStep. A stretch is as long as that, or its whole
// window, also where the pen all but stands: a stroke without it is shorter.
#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

#include "impedraw/planning/path/tip_path.h"

namespace impedraw {

inline constexpr double kCrawlWindow = 10e-3, kCrawlStep = 5e-3;  // [m]
inline constexpr double kSlowed = 2.0;

struct CrawlingStretch {
  std::size_t stroke = 0;        // in the order of the path
  double from = 0, to = 0;       // as in StrokePart, of the path's stroke [m]
  double speed = 0;              // mean over the stretch [m/s]
  double slowest = 0;            // place of least speed, between from and to [m]
  Eigen::Vector3d p_W{0, 0, 0};  // there [m]
};

// Strokes of the path with a window slower than `least_speed`, in order: no other crawls.
std::vector<std::size_t> slow_strokes(const TipPath& path, double least_speed);

// The stretches of these `strokes` of the path on which the pen crawls, ordered by stroke, then
// along it. `unhindered`: a path of these strokes alone, in the same order, without the limits
// that count.
std::vector<CrawlingStretch> crawling_stretches(const TipPath& path, const TipPath& unhindered,
                                                const std::vector<std::size_t>& strokes,
                                                double least_speed, double slowed = kSlowed);

}  // namespace impedraw
