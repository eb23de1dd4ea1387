#include "impedraw/log/run_rows.h"

#include <algorithm>

#include "impedraw/log/log_checks.h"
#include "impedraw/log/log_columns.h"
#include "impedraw/log/log_file.h"
#include "impedraw/log/log_reader.h"

namespace impedraw {

ReplayLog::ReplayLog(const std::filesystem::path& path) : log_(std::make_unique<LogReader>(path)) {}
ReplayLog::~ReplayLog() = default;

std::size_t ReplayLog::rows() const { return log_->rows(); }
int ReplayLog::joints() const { return log_->joints(); }
const std::vector<std::string>& ReplayLog::torque_terms() const {
  return log_->header().torque_terms;
}
bool ReplayLog::canvas_moves() const { return log_->header().moving_canvas; }
bool ReplayLog::cut_short() const { return log_->cut_short(); }

namespace {

// Hands over the rows of a table one after the other, in one row that is filled anew. A dataset
// that an older log lacks leaves what is there. `visit`: visit_row() or visit_step(). Returns false
// if rows exist but cannot be read.
bool read_table(const LogReader& log, const std::vector<LogColumn>& columns, std::size_t rows,
                auto row, const auto& visit, const auto& done) {
  std::vector<std::vector<std::byte>> values(columns.size());
  for (std::size_t begin = 0; begin < rows; begin += LogFile::kChunkRows) {
    const std::size_t n = std::min(LogFile::kChunkRows, rows - begin);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      if (!log.has(columns[c].name)) continue;
      values[c].resize(n * columns[c].row_bytes());
      if (!log.read(columns[c], begin, n, values[c].data())) return false;
    }
    for (std::size_t i = 0; i < n; ++i) {
      std::size_t c = 0;
      visit(row, [&](const char*, auto& value, const auto&...) {
        if (!values[c].empty()) take_value(value, &values[c][i * columns[c].row_bytes()]);
        ++c;
      });
      done(row);
    }
  }
  return true;
}

bool visit_table(const LogReader& log, const std::function<void(LogRow&)>& visit) {
  return read_table(
      log, log_columns(log.header()), log.rows(), LogRow(log.joints()),
      [&](LogRow& row, const auto& column) { visit_row(row, log.header(), column); }, visit);
}

}  // namespace

bool ReplayLog::visit(const std::function<void(const LogRow&)>& visit) const {
  return visit_table(*log_, visit);
}

bool visit_steps(const LogReader& log, const std::function<void(const LogStep&)>& visit) {
  StepChecks checks(log);
  const auto checked = [&](const LogStep& step) {
    checks.next(step);
    visit(step);
  };
  if (log.rate() == LogRate::full) {
    LogSteps measured(log.header());
    return visit_table(log, [&](LogRow& row) {
      LogStep step = measured.measure(row);
      step.step_time = row.step_time;
      step.felt_force = row.wrench_measured.head<3>().dot(row.surface_normal);
      checked(step);
    });
  }
  return read_table(
      log, step_columns(), log.steps(), LogStep{},
      [](LogStep& step, const auto& column) { visit_step(step, "", column); }, checked);
}

void visit_rows(const std::filesystem::path& path,
                const std::function<void(const LogRow&)>& visit) {
  const LogReader log(path);
  const bool whole = visit_table(log, [&](LogRow& row) {
    if (!log.header().joint_sensor) row.measured_position = row.joint_position;
    visit(row);
  });
  if (!whole) log.fail("cannot be read: broken before its last rows");
}

}  // namespace impedraw
