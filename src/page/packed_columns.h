// Columns of numbers for a page, small after deflate: quantised, coded as differences, and laid out
// byte plane by byte plane. web/src/columns.ts reads them.
//
// Quantised    k_i = round(v_i / quantum); NaN and inf become gaps
// Differences  of order 0, 1 or 2 of k, whichever is smallest; within a gap k repeats
// Planes       zigzag(d) = 2d (d ≥ 0) or −2d − 1, as 1 to 4 bytes; all first bytes, then all second
// Gaps         lengths of alternating runs, first one of values: uint32, little endian
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace impedraw {

class PackedColumns {
 public:
  // Appends n values. Returns how to read them: {n, quantum, order, planes, at} and, with gaps,
  // {runs, runs_at}. Errors are at most quantum/2; values beyond ±1e8 quanta are clamped.
  nlohmann::json add(std::size_t n, const std::function<double(std::size_t)>& value,
                     double quantum);
  nlohmann::json add(std::span<const double> values, double quantum);

  // Appends bytes as they are. Returns {at, bytes}.
  nlohmann::json add_bytes(const std::string& bytes);

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

}  // namespace impedraw
