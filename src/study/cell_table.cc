#include "impedraw/study/cell_table.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <regex>
#include <thread>

#include <fmt/format.h>
#include <unistd.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/exit_code.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/files/run_python.h"
#include "impedraw/run/run_folder.h"
#include "impedraw/terminal/clock.h"
#include "impedraw/terminal/interrupt.h"
#include "impedraw/terminal/progress.h"
#include "impedraw/terminal/say.h"

namespace impedraw {

namespace {

namespace fs = std::filesystem;

// "robustness  37/211 cells, 2 failed, 3:12 left": redrawn on a terminal, else a line every ten
//              seconds.
class CellsLine {
 public:
  CellsLine(const std::string& name, std::size_t cells) : name_(name), cells_(cells) {}
  ~CellsLine() {
    if (terminal_) std::fputs("\r\x1b[K", stderr);
  }
  void count(bool failed) { ++done_, failed_ += failed; }
  void draw() {
    const auto now = Clock::now();
    if (now < next_) return;
    next_ = now + (terminal_ ? std::chrono::milliseconds(200) : std::chrono::seconds(10));
    const double wall = std::chrono::duration<double>(now - start_).count();
    const double left = wall * static_cast<double>(cells_ - done_) /
                        static_cast<double>(std::max<std::size_t>(done_, 1));
    const std::string line = fmt::format("{}  {}/{} cells, {} failed, {} left", name_, done_,
                                         cells_, failed_, done_ == 0 ? "-:--" : clock_text(left));
    std::fputs((terminal_ ? "\r" + line + "\x1b[K" : line + "\n").c_str(), stderr);
    std::fflush(stderr);
  }

 private:
  const std::string name_;
  const std::size_t cells_;
  const bool terminal_ = isatty(STDERR_FILENO) == 1;
  std::size_t done_ = 0, failed_ = 0;
  const Clock::time_point start_ = Clock::now();
  Clock::time_point next_ = start_;
};

// The records of an earlier run whose cells are unchanged.
Records kept_records(const CellTable& table, const fs::path& csv, const std::vector<Cell>& all) {
  std::map<std::string, const Cell*> cells;
  for (const Cell& cell : all) cells[cell.name] = &cell;
  Records kept;
  for (const Record& record : read_csv(csv)) {
    const auto cell = cells.find(field(record, "cell"));
    if (cell != cells.end() && table.same(record, *cell->second)) kept[cell->first] = record;
  }
  return kept;
}

// In the order of `all`.
void write_csv(const CellTable& table, const fs::path& csv, const std::vector<Cell>& all,
               const Records& records) {
  std::string text = csv_line(table.columns);
  for (const Cell& cell : all)
    if (const auto it = records.find(cell.name); it != records.end())
      text += csv_line(table.columns, it->second);
  write_whole(csv, text);
}

void plot(const std::string& name, const fs::path& csv, const fs::path& png) {
  const std::string script = std::string(IMPEDRAW_STUDY_SCRIPTS) + "/" + name + ".py",
                    from = fs::absolute(csv).string(), to = fs::absolute(png).string();
  const int code = run_python({.python = IMPEDRAW_PYTHON,
                               .arguments = {script, from, to},
                               .matplotlib_folder = IMPEDRAW_MATPLOTLIB_FOLDER});
  if (code < 0)
    throw std::runtime_error(
        fmt::format("cannot write {}: {} does not start", to, IMPEDRAW_PYTHON));
  if (code != 0)
    throw std::runtime_error(
        fmt::format("cannot write {}: {} failed (its message is above)", to, script));
}

}  // namespace

fs::path table_folder(const std::string& name, const CellTableOptions& options) {
  return options.out.empty() ? fs::path("runs") / name : options.out;
}

std::vector<Cell> matching(const std::vector<Cell>& cells, const std::string& pattern) {
  std::regex expression;
  try {
    expression = std::regex(pattern);
  } catch (const std::regex_error&) {
    throw InputError(fmt::format("--only {}: not a valid regular expression", pattern));
  }
  std::vector<Cell> found;
  std::copy_if(cells.begin(), cells.end(), std::back_inserter(found),
               [&](const Cell& c) { return std::regex_search(c.name, expression); });
  if (found.empty())
    throw InputError(
        fmt::format("--only {}: no cell's name matches; --list shows the names", pattern));
  return found;
}

void print_cells(const std::vector<Cell>& cells) {
  for (const Cell& cell : cells) say(stdout, "{}\n    {}\n", cell.name, cell_command(cell));
}

int run_table(const CellTable& table, const std::vector<Cell>& all,
              const std::vector<Cell>& desired, const CellTableOptions& options) {
  const fs::path folder = table_folder(table.name, options);
  const fs::path csv = folder / (table.name + ".csv");
  require_table_folder(folder, csv.filename().string());
  Records records;
  if (!options.again && fs::exists(csv)) records = kept_records(table, csv, all);
  std::vector<Cell> left;
  std::copy_if(desired.begin(), desired.end(), std::back_inserter(left),
               [&](const Cell& c) { return !records.contains(c.name); });
  if (left.size() < desired.size())
    say(stdout, "{} of {} cells are kept from an earlier run; --again runs them again\n",
        desired.size() - left.size(), desired.size());
  make_folder(folder);
  write_csv(table, csv, all, records);

  Interrupt interrupt;
  bool whole;
  {
    std::ofstream out(csv, std::ios::binary | std::ios::app);
    CellsLine line(table.name, left.size());
    ProcessHooks hooks;
    hooks.waiting = [&] { line.draw(); };
    hooks.interrupted = [&] { return interrupt.requested(); };
    hooks.finished = [&](std::size_t i, const ProcessEnd& end) {
      Record& record = records[left[i].name] = table.record(left[i], end);
      out << csv_line(table.columns, record) << std::flush;
      if (!out) throw std::runtime_error(fmt::format("cannot write {}", csv.string()));
      line.count(field(record, "failed") == "1");
    };
    const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
    const auto work = [&](std::size_t i, const fs::path& log) {
      return table.measure(left[i], log);
    };
    whole =
        run_processes(left.size(), work,
                      {options.jobs > 0 ? options.jobs : cores, table.time_limit, folder}, hooks);
  }
  if (!whole) {
    say(stderr,
        "impedraw: interrupted; finished cells are kept in {}; the same command continues\n",
        csv.string());
    return interrupt.exit_code();
  }
  write_csv(table, csv, all, records);
  write_whole(folder / (table.name + ".md"), table.page(records));
  std::vector<std::string> extensions = {".csv", ".md"};
  if (table.picture) {
    plot(table.name, csv, folder / (table.name + ".png"));
    extensions.emplace_back(".png");
  }
  std::size_t failed = 0;
  for (const Cell& cell : desired) failed += field(records.at(cell.name), "failed") == "1";
  say(stdout, "{} cells, {} failed\n", desired.size(), failed);
  for (const std::string& extension : extensions)
    say(stdout, "  {}\n",
        fs::absolute(folder / (table.name + extension)).lexically_normal().string());
  return kFinished;
}

}  // namespace impedraw
