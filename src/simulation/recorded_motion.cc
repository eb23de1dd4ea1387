#include "impedraw/simulation/recorded_motion.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <Eigen/Geometry>

#include "impedraw/common/errors.h"
#include "impedraw/common/input_file.h"
#include "impedraw/common/text_fields.h"

namespace impedraw {

namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr std::size_t kMostBytes = 200'000'000;

// The axis that a column's name ends in, as in qw, p_x or "y [m]"; blank where it is another word.
char axis_of(std::string_view name) {
  name = trimmed(name.substr(0, name.find_first_of("[(")));
  const char last = name.empty() ? ' ' : static_cast<char>(std::tolower(name.back()));
  return last >= 'w' && last <= 'z' ? last : ' ';
}

// A header that names the axes of all columns in another order: such rows would be taken for other
// turns, as those of t, x, y, z, qx, qy, qz, qw.
bool in_other_order(const std::vector<std::string_view>& fields) {
  std::string axes;
  for (std::size_t i = 1; i < fields.size(); ++i) axes += axis_of(fields[i]);
  return fields.size() == 8 && axes.find(' ') == std::string::npos && axes != "xyzwxyz";
}

template <typename Row>
Quaterniond turn_of(const Row& row) {
  return {row[3], row[4], row[5], row[6]};
}

}  // namespace

RecordedMotion::RecordedMotion(std::string_view text, const std::string& name) {
  int line_number = 0;
  const auto fail = [&](const std::string& what) -> void {
    throw InputError(fmt::format("{}: line {}: {}", name, line_number, what));
  };
  double first = 0.0;
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::string_view line = trimmed(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++line_number;
    if (line.empty() || line.starts_with('#')) continue;
    const std::vector<std::string_view> fields = fields_of(line);
    if (times_.empty() && !number_in(fields[0])) {  // header
      if (in_other_order(fields))
        fail(fmt::format("names the columns {}; valid are t, x, y, z, qw, qx, qy, qz in this order",
                         fmt::join(fields, ", ")));
      continue;
    }
    std::array<double, 8> values;
    if (fields.size() != values.size())
      fail(fmt::format("has {} fields; valid are 8: t, x, y, z, qw, qx, qy, qz", fields.size()));
    for (std::size_t i = 0; i < values.size(); ++i) {
      const auto value = number_in(fields[i]);
      if (!value || !std::isfinite(*value)) fail(fmt::format("'{}' is no number", fields[i]));
      values[i] = *value;
    }
    if (times_.empty()) first = values[0];
    const double t = values[0] - first;
    Row row = Eigen::Map<const Row>(values.data() + 1);
    const double norm = row.tail<4>().norm();
    if (std::abs(norm - 1.0) > 0.01)
      fail(fmt::format("the quaternion's norm is {:.4g}; valid is 1", norm));
    row.tail<4>() /= norm;
    if (!times_.empty()) {
      const Row& before = rows_.back();
      if (row.tail<4>().dot(before.tail<4>()) < 0.0) row.tail<4>() *= -1.0;
      const double step = t - times_.back();
      if (!(step > 0.0))
        fail(fmt::format("t = {} s does not follow {} s; times must increase", values[0],
                         first + times_.back()));
      if (step > kLongestGap)
        fail(fmt::format("a gap of {:.3g} s before t = {} s; valid are at most {} s", step,
                         values[0], kLongestGap));
      const double speed = (row.head<3>() - before.head<3>()).norm() / step;
      const double turn = turn_of(row).angularDistance(turn_of(before)) / step;
      if (speed > kMostSpeed)
        fail(fmt::format("jumps at {:.3g} m/s; valid are at most {} m/s", speed, kMostSpeed));
      if (turn > kMostTurn)
        fail(fmt::format("turns at {:.3g} rad/s; valid are at most {} rad/s", turn, kMostTurn));
    }
    times_.push_back(t);
    rows_.push_back(row);
  }
  if (times_.size() < 2) throw InputError(name + ": has fewer than two rows");

  // Curvatures of the natural spline: a tridiagonal system, solved downwards and back.
  const std::size_t n = times_.size();
  curvatures_.assign(n, Row::Zero());
  std::vector<double> share(n, 0.0);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double h = times_[i] - times_[i - 1], k = times_[i + 1] - times_[i];
    const Row bend = 6.0 * ((rows_[i + 1] - rows_[i]) / k - (rows_[i] - rows_[i - 1]) / h);
    const double pivot = 2.0 * (h + k) - h * share[i - 1];
    share[i] = k / pivot;
    curvatures_[i] = (bend - h * curvatures_[i - 1]) / pivot;
  }
  for (std::size_t i = n - 1; i-- > 1;) curvatures_[i] -= share[i] * curvatures_[i + 1];
}

RecordedMotion::State RecordedMotion::at(double t) const noexcept {
  t = std::clamp(t, 0.0, duration());
  const auto after = std::upper_bound(times_.begin() + 1, times_.end() - 1, t);
  const auto i = static_cast<std::size_t>(after - times_.begin());
  const double h = times_[i] - times_[i - 1], a = (times_[i] - t) / h, b = 1.0 - a;
  const Row &y0 = rows_[i - 1], &y1 = rows_[i], &c0 = curvatures_[i - 1], &c1 = curvatures_[i];
  const Row y = a * y0 + b * y1 + h * h / 6.0 * (a * (a * a - 1.0) * c0 + b * (b * b - 1.0) * c1);
  const Row rate = (y1 - y0) / h + h / 6.0 * ((3.0 * b * b - 1.0) * c1 - (3.0 * a * a - 1.0) * c0);

  // The quaternion q of the spline is not a unit: ω = 2 vec(q̇ q⁻¹).
  const Quaterniond q = turn_of(y);
  State state;
  state.w = 2.0 * (turn_of(rate) * q.inverse()).vec();
  state.v = rate.head<3>();
  state.p = y.head<3>();
  state.X.R =
      q.normalized().toRotationMatrix() * turn_of(rows_.front()).toRotationMatrix().transpose();
  state.X.p = state.p - state.X.R * rows_.front().head<3>();
  return state;
}

RecordedMotion read_recorded_motion(const std::filesystem::path& file) {
  const InputFile input(file);
  if (input.size() > kMostBytes)
    throw InputError(fmt::format("{}: has {} bytes; valid are at most {}", file.string(),
                                 input.size(), kMostBytes));
  return {input.read(kMostBytes), file.string()};
}

}  // namespace impedraw
