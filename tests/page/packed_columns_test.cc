#include "impedraw/page/page_json.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace impedraw {
namespace {

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

// Reads a column by the description in the header.
std::vector<double> unpacked(const PackedColumns& columns, const nlohmann::json& how) {
  const std::size_t n = how["n"], at = how["at"];
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(columns.bytes()[i]); };
  std::vector<long long> k(n);
  for (std::size_t i = 0; i < n; ++i) {
    unsigned long long code = 0;
    for (int plane = how["planes"]; plane-- > 0;) code = code << 8 | byte(at + plane * n + i);
    k[i] = code & 1 ? -static_cast<long long>(code / 2) - 1 : static_cast<long long>(code / 2);
  }
  for (int pass = 0; pass < how["order"]; ++pass)
    for (std::size_t i = 1; i < n; ++i) k[i] += k[i - 1];
  std::vector<double> values(n);
  for (std::size_t i = 0; i < n; ++i)
    values[i] = static_cast<double>(k[i]) * double(how["quantum"]);
  if (how.contains("runs")) {
    std::size_t i = 0, runs_at = how["runs_at"];
    for (std::size_t run = 0; run < how["runs"]; ++run) {
      std::size_t length = 0;
      for (int b = 3; b >= 0; --b) length = length << 8 | byte(runs_at + 4 * run + b);
      if (run % 2) std::fill_n(values.begin() + static_cast<std::ptrdiff_t>(i), length, kNone);
      i += length;
    }
    EXPECT_EQ(i, n);
  }
  return values;
}

TEST(PackedColumns, KeepValuesToHalfAQuantumAndGapsExactly) {
  const unsigned seed = std::random_device()();
  SCOPED_TRACE(seed);
  std::mt19937 random(seed);
  for (int round = 0; round < 50; ++round) {
    const double quantum = std::pow(10.0, -static_cast<int>(random() % 6));
    const double size = std::pow(10.0, random() % 5);
    std::vector<double> values(random() % 300);
    double smooth = 0.0;
    for (double& v : values) {
      const double noise = size * quantum * (static_cast<double>(random() % 2001) / 1000.0 - 1.0);
      smooth += noise;
      v = round % 2 ? smooth : noise;
      if (random() % 8 == 0) v = random() % 2 ? kNone : INFINITY;
    }
    PackedColumns columns;
    columns.add_bytes("something before");
    const std::vector<double> read = unpacked(columns, columns.add(values, quantum));
    ASSERT_EQ(read.size(), values.size());
    for (std::size_t i = 0; i < values.size(); ++i) {
      ASSERT_EQ(std::isfinite(read[i]), std::isfinite(values[i])) << i;
      if (std::isfinite(values[i])) {
        ASSERT_NEAR(read[i], values[i], 0.5001 * quantum) << i;
      }
    }
  }
}

TEST(PackedColumns, ASmoothColumnTakesAByteAValue) {
  std::vector<double> values;
  for (int i = 0; i < 1000; ++i) values.push_back(std::sin(0.01 * i));
  PackedColumns columns;
  const nlohmann::json how = columns.add(values, 1e-5);
  EXPECT_EQ(how["order"], 2);
  EXPECT_LE(columns.bytes().size(), 2000u) << "its first value needs two";
}

TEST(PackedColumns, HugeValuesAreClamped) {
  PackedColumns columns;
  const std::vector<double> values = {1e300, -1e300, 1e300, 0.0};
  const std::vector<double> read = unpacked(columns, columns.add(values, 1.0));
  EXPECT_EQ(read, (std::vector<double>{1e8, -1e8, 1e8, 0.0}));
}

}  // namespace
}  // namespace impedraw
