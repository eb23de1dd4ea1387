#include "app/robustness.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <regex>
#include <thread>

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/commands.h"
#include "app/interrupt.h"
#include "app/progress.h"
#include "app/results.h"
#include "app/robustness_run.h"
#include "app/robustness_table.h"
#include "app/wall_time.h"
#include "common/errors.h"

extern char** environ;

namespace impedraw {

namespace {

namespace fs = std::filesystem;

std::vector<Cell> matching(const std::vector<Cell>& cells, const std::string& pattern) {
  std::regex expression;
  try {
    expression = std::regex(pattern);
  } catch (const std::regex_error&) {
    throw InputError(fmt::format("--only {}: is no regular expression", pattern));
  }
  std::vector<Cell> found;
  std::copy_if(cells.begin(), cells.end(), std::back_inserter(found), [&](const Cell& c) { return std::regex_search(c.name, expression); });
  if (found.empty()) throw InputError(fmt::format("--only {}: no cell has that in its name; --list shows the names", pattern));
  return found;
}

// "robustness  37/211 cells, 2 failed, 3:12 left": redrawn on a terminal, else a line every ten seconds.
class CellsLine {
 public:
  explicit CellsLine(std::size_t cells) : cells_(cells) {}
  ~CellsLine() {
    if (terminal_) std::fputs("\r\x1b[K", stderr);
  }
  void count(bool failed) { ++done_, failed_ += failed; }
  void draw() {
    const auto now = Clock::now();
    if (now < next_) return;
    next_ = now + (terminal_ ? std::chrono::milliseconds(200) : std::chrono::seconds(10));
    const double wall = std::chrono::duration<double>(now - start_).count();
    const double left = wall * static_cast<double>(cells_ - done_) / static_cast<double>(std::max<std::size_t>(done_, 1));
    const std::string line =
        fmt::format("robustness  {}/{} cells, {} failed, {} left", done_, cells_, failed_, done_ == 0 ? "-:--" : clock_text(left));
    std::fputs((terminal_ ? "\r" + line + "\x1b[K" : line + "\n").c_str(), stderr);
    std::fflush(stderr);
  }

 private:
  const std::size_t cells_;
  const bool terminal_ = isatty(STDERR_FILENO) == 1;
  std::size_t done_ = 0, failed_ = 0;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point next_ = start_;
};

// What an earlier run left, of the cells that are still the same.
std::map<std::string, Record> kept_records(const fs::path& csv, const std::vector<Cell>& all, const RecordColumns& columns) {
  std::map<std::string, const Cell*> cells;
  for (const Cell& cell : all) cells[cell.name] = &cell;
  std::map<std::string, Record> kept;
  for (const Record& record : read_csv(csv)) {
    const auto name = record.find("cell");
    const auto cell = name == record.end() ? cells.end() : cells.find(name->second);
    if (cell != cells.end() && columns.same_settings(record, *cell->second)) kept[name->second] = record;
  }
  return kept;
}

// In the order of `all`; whole or not at all.
void write_csv(const fs::path& csv, const std::vector<Cell>& all, const RecordColumns& columns,
               const std::map<std::string, Record>& records) {
  std::string text = csv_line(columns.names());
  for (const Cell& cell : all)
    if (const auto it = records.find(cell.name); it != records.end()) text += columns.line(it->second);
  const fs::path fresh = csv.string() + ".new";
  write_file(fresh, text);
  fs::rename(fresh, csv);
}

void plot(const fs::path& csv, const fs::path& png) {
  const std::string script = std::string(IMPEDRAW_ROOT) + "/src/report/robustness.py", from = csv.string(), to = png.string();
  const char* const arguments[] = {IMPEDRAW_PYTHON, "-I", script.c_str(), from.c_str(), to.c_str(), nullptr};
  pid_t child = 0;
  if (posix_spawnp(&child, IMPEDRAW_PYTHON, nullptr, nullptr, const_cast<char* const*>(arguments), environ) != 0)
    throw std::runtime_error(fmt::format("cannot write {}: {} does not start", to, IMPEDRAW_PYTHON));
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw std::runtime_error(fmt::format("cannot write {}: {} failed (its message is above)", to, script));
}

}  // namespace

int run_matrix(const std::vector<Cell>& all, const std::vector<Cell>& wanted, const RobustnessOptions& options, double time_limit) {
  const fs::path folder = options.out.empty() ? fs::path("runs/robustness") : options.out;
  const fs::path csv = folder / "robustness.csv";
  require_robustness_folder(folder);
  const RecordColumns columns(all);
  std::map<std::string, Record> records;
  if (!options.again && fs::exists(csv)) records = kept_records(csv, all, columns);
  std::vector<Cell> left;
  std::copy_if(wanted.begin(), wanted.end(), std::back_inserter(left), [&](const Cell& c) { return !records.contains(c.name); });
  if (left.size() < wanted.size())
    fmt::print("{} of {} cells are kept from an earlier run; --again runs them anew\n", wanted.size() - left.size(), wanted.size());
  make_folder(folder);
  write_csv(csv, all, columns, records);

  Interrupt interrupt;
  bool whole;
  {
    std::ofstream out(csv, std::ios::binary | std::ios::app);
    CellsLine line(left.size());
    CellRunHooks hooks;
    hooks.waiting = [&] { line.draw(); };
    hooks.interrupted = [&] { return interrupt.requested(); };
    hooks.finished = [&](const Cell& cell, const CellResult& result) {
      records[cell.name] = columns.record(cell, result);
      out << columns.line(records[cell.name]) << std::flush;
      if (!out) throw std::runtime_error(fmt::format("cannot write {}", csv.string()));
      line.count(!result.cause.empty());
    };
    const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    whole = run_cells(left, {options.jobs > 0 ? options.jobs : cores, time_limit, folder}, hooks);
  }
  if (!whole) {
    fmt::print(stderr, "impedraw: interrupted; what was done is kept in {}, and the same command goes on from there\n", csv.string());
    return interrupt.exit_code();
  }
  write_csv(csv, all, columns, records);
  write_file(folder / "robustness.md", robustness_page(all, records));
  plot(csv, folder / "robustness.png");
  std::size_t failed = 0;
  for (const Cell& cell : wanted) failed += records.at(cell.name).at("failed") == "1";
  fmt::print("{} cells, {} failed\n", wanted.size(), failed);
  for (const char* name : {"robustness.csv", "robustness.md", "robustness.png"})
    fmt::print("  {}\n", fs::absolute(folder / name).lexically_normal().string());
  return kFinished;
}

int robustness(const RobustnessOptions& options) {
  const std::vector<Cell> all = robustness_cells();
  const std::vector<Cell> wanted = matching(all, options.only);
  if (options.list) {
    for (const Cell& cell : wanted) fmt::print("{}\n    {}\n", cell.name, cell_command(cell));
    return kFinished;
  }
  return run_matrix(all, wanted, options);
}

}  // namespace impedraw
