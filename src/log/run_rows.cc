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

// Reads rows [begin, begin + rows.size()) of a table. A dataset that an older log lacks leaves what
// is there. `visit`: visit_row() or visit_step().
bool read_table(const LogReader& log, const std::vector<LogColumn>& columns, std::size_t begin,
                auto& rows, const auto& visit) {
  std::vector<std::vector<std::byte>> values(columns.size());
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (!log.has(columns[c].name)) continue;
    values[c].resize(rows.size() * columns[c].row_bytes());
    if (!log.read(columns[c], begin, rows.size(), values[c].data())) return false;
  }
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::size_t c = 0;
    visit(rows[i], [&](const char*, auto& value, const auto&...) {
      if (!values[c].empty()) take_value(value, &values[c][i * columns[c].row_bytes()]);
      ++c;
    });
  }
  return true;
}

// Hands over the rows block by block. Returns false if they exist but cannot be read.
bool visit_blocks(const LogReader& log, const std::function<void(LogRow&)>& visit) {
  const std::vector<LogColumn> columns = log_columns(log.header());
  std::vector<LogRow> rows;
  for (std::size_t begin = 0; begin < log.rows(); begin += rows.size()) {
    rows.assign(std::min(LogFile::kChunkRows, log.rows() - begin), LogRow(log.joints()));
    if (!read_table(log, columns, begin, rows,
                    [&](LogRow& row, const auto& column) { visit_row(row, log.header(), column); }))
      return false;
    for (LogRow& row : rows) visit(row);
  }
  return true;
}

}  // namespace

bool ReplayLog::visit(const std::function<void(const LogRow&)>& visit) const {
  return visit_blocks(*log_, visit);
}

bool visit_steps(const LogReader& log, const std::function<void(const LogStep&)>& visit) {
  StepChecks checks(log);
  const auto checked = [&](const LogStep& step) {
    checks.next(step);
    visit(step);
  };
  if (log.rate() == LogRate::full) {
    LogSteps measured(log.header());
    return visit_blocks(log, [&](LogRow& row) {
      LogStep step = measured.measure(row);
      step.step_time = row.step_time;
      step.felt_force = row.wrench_measured.head<3>().dot(row.surface_normal);
      checked(step);
    });
  }
  std::vector<LogStep> steps;
  for (std::size_t begin = 0; begin < log.steps(); begin += steps.size()) {
    steps.assign(std::min(LogFile::kChunkRows, log.steps() - begin), {});
    if (!read_table(log, step_columns(), begin, steps,
                    [](LogStep& step, const auto& column) { visit_step(step, "", column); }))
      return false;
    for (const LogStep& step : steps) checked(step);
  }
  return true;
}

void visit_rows(const std::filesystem::path& path,
                const std::function<void(const LogRow&)>& visit) {
  const LogReader log(path);
  const bool whole = visit_blocks(log, [&](LogRow& row) {
    if (!log.header().joint_sensor) row.measured_position = row.joint_position;
    visit(row);
  });
  if (!whole) log.fail("cannot be read: broken before its last rows");
}

}  // namespace impedraw
