// Picture of an area that was covered, seen along the drawing axis: up is +x, right is −y of the
// drawing frame. Left: what was treated, how often, and what was missed. Right: the dose of each
// place, pressure times way, over the mean. What is outside is cut off.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace impedraw {

enum class Treated { outside, not_promised, once, twice, missed };

struct CoverPicture {
  std::string title, subtitle;
  int nx = 0, ny = 0;            // places; the first index, along x, is the fastest
  double step = 0.0;             // [m]
  std::vector<Treated> treated;  // outside: no surface that a perfect planner would reach
  std::vector<double> dose;      // over its mean; NaN where there is none
  std::string dose_is = "pressure × way";
};

// Writes `stem`.svg and `stem`.png. Throws std::runtime_error naming the file if it cannot be
// written.
void write_cover(const CoverPicture& picture, const std::filesystem::path& stem);

}  // namespace impedraw
