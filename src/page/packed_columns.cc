#include "impedraw/page/packed_columns.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include <nlohmann/json.hpp>

namespace impedraw {

namespace {

std::vector<std::int64_t> differences(const std::vector<std::int64_t>& k, int order) {
  std::vector<std::int64_t> d = k;
  for (int pass = 0; pass < order; ++pass)
    for (std::size_t i = d.size(); i-- > 1;) d[i] -= d[i - 1];
  return d;
}

std::uint64_t zigzag(std::int64_t d) {
  return d < 0 ? 2 * static_cast<std::uint64_t>(-(d + 1)) + 1 : 2 * static_cast<std::uint64_t>(d);
}

double bits(const std::vector<std::int64_t>& d) {
  double sum = 0.0;
  for (const std::int64_t x : d) sum += static_cast<double>(std::bit_width(zigzag(x)));
  return sum;
}

void put_uint32(std::string& bytes, std::uint32_t x) {
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>((x >> shift) & 0xff);
}

}  // namespace

nlohmann::json PackedColumns::add(std::size_t n, const std::function<double(std::size_t)>& value,
                                  double quantum) {
  constexpr double kMost = 1e8;  // second differences then fit into 32 bits
  std::vector<std::int64_t> k(n);
  std::vector<std::uint32_t> runs;
  bool in_values = true;
  std::uint32_t run = 0;
  std::int64_t last = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double v = value(i);
    const bool is_value = std::isfinite(v);
    if (is_value != in_values) runs.push_back(run), run = 0, in_values = is_value;
    ++run;
    if (is_value) last = std::llround(std::clamp(v / quantum, -kMost, kMost));
    k[i] = last;
  }
  runs.push_back(run);

  std::array<std::vector<std::int64_t>, 3> coded;
  int order = 0;
  for (int candidate = 0; candidate < 3; ++candidate) {
    coded[candidate] = differences(k, candidate);
    if (bits(coded[candidate]) < bits(coded[order])) order = candidate;
  }
  std::uint64_t most = 0;
  for (const std::int64_t d : coded[order]) most = std::max(most, zigzag(d));
  const int planes = std::max(1, (static_cast<int>(std::bit_width(most)) + 7) / 8);

  nlohmann::json how = {
      {"n", n}, {"quantum", quantum}, {"order", order}, {"planes", planes}, {"at", bytes_.size()}};
  for (int plane = 0; plane < planes; ++plane)
    for (const std::int64_t d : coded[order])
      bytes_ += static_cast<char>((zigzag(d) >> (8 * plane)) & 0xff);
  if (runs.size() > 1) {
    how["runs"] = runs.size();
    how["runs_at"] = bytes_.size();
    for (const std::uint32_t length : runs) put_uint32(bytes_, length);
  }
  return how;
}

nlohmann::json PackedColumns::add(std::span<const double> values, double quantum) {
  return add(
      values.size(), [values](std::size_t i) { return values[i]; }, quantum);
}

nlohmann::json PackedColumns::add_bytes(const std::string& bytes) {
  nlohmann::json how = {{"at", bytes_.size()}, {"bytes", bytes.size()}};
  bytes_ += bytes;
  return how;
}

}  // namespace impedraw
