// Writes and checks logs for power_cut_test.py.
//
//   made_up_log write FOLDER          three runs into FOLDER/run.h5: one, its continuation, another
//   made_up_log check FOLDER…         after a power cut: recovers, checks, prints "RUN STEPS" and
//                                     goes on in each
#include <dlfcn.h>

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>

#include "impedraw/log/log.h"
#include "impedraw/log/run_data.h"
#include "log/made_up_run.h"

namespace {

namespace fs = std::filesystem;
using impedraw::LogRate;
using impedraw::RunLog;

// Run 1 and its continuation, run 2, are full logs; run 3 is reduced.
constexpr int kSteps = 12000;
constexpr int kMore = 7000;

impedraw::RunLogHeader header(int run) {
  impedraw::RunLogHeader h = impedraw::testing::small_header();
  h.attributes["run"] = std::to_string(run);
  h.rate = run == 3 ? LogRate::reduced : LogRate::full;
  return h;
}

using Mark = void (*)(std::uint64_t, std::uint64_t);

void append(RunLog& log, int from, int to, std::uint64_t run, Mark mark) {
  for (int i = from; i < to; ++i) {
    log.append(impedraw::testing::numbered_row(i));
    if (i % 100 == 99) mark(run, static_cast<std::uint64_t>(i) + 1);
  }
}

int write(const fs::path& folder) {
  const auto mark = reinterpret_cast<Mark>(dlsym(RTLD_DEFAULT, "record_io_mark"));
  if (mark == nullptr) return std::fputs("record_io is not preloaded\n", stderr), 2;
  const fs::path file = folder / "run.h5";
  {
    RunLog log(file, header(1));
    append(log, 0, kSteps, 1, mark);
    log.close({1.0, 1.0, 0.0});
  }
  mark(1, kSteps);
  {
    RunLog log = RunLog::append_to(file, header(1));
    append(log, kSteps, kSteps + kMore, 2, mark);
    log.close({1.0, 1.0, 0.0});
  }
  mark(2, kSteps + kMore);
  {
    RunLog log(file, header(3));
    append(log, 0, kSteps, 3, mark);
    log.close({1.0, 1.0, 0.0});
  }
  mark(3, kSteps);
  return 0;
}

void require(bool holds, const char* what) {
  if (!holds) throw std::runtime_error(what);
}

void check(const fs::path& folder) {
  const fs::path file = folder / "run.h5";
  if (!fs::exists(file)) {  // no run yet
    std::printf("0 0\n");
    return;
  }
  impedraw::recover_log(file);
  const impedraw::RunData run = impedraw::read_run(file);
  const int which = std::stoi(run.attributes.at("run")), steps = static_cast<int>(run.rows());
  for (int i = 0; i < steps; ++i) {
    const impedraw::LogRow row = impedraw::testing::numbered_row(i);
    const auto k = static_cast<std::size_t>(i);
    require(run.time[k] == row.time && run.stroke[k] == row.stroke && run.mode[k] == row.mode &&
                std::memcmp(&run.contact_point[k], &row.contact_point, sizeof(double[3])) == 0,
            "a row is not the one that was written");
  }
  {
    RunLog log = RunLog::append_to(file, header(which));
    for (int i = steps; i < steps + 300; ++i) log.append(impedraw::testing::numbered_row(i));
    log.close({1.0, 1.0, 0.0});
  }
  require(static_cast<int>(impedraw::read_run(file).rows()) == steps + 300, "does not go on");
  for (const auto& entry : fs::directory_iterator(folder))
    require(entry.path().filename() == "run.h5" ||
                entry.path().filename().string().starts_with(".impedraw-part-"),
            "a file is left");
  std::printf("%d %d\n", which, steps);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc == 3 && std::strcmp(argv[1], "write") == 0) return write(argv[2]);
  for (int i = 2; i < argc; ++i) {
    try {
      check(argv[i]);
    } catch (const std::exception& error) {
      std::printf("%s: %s\n", argv[i], error.what());
    }
  }
  return 0;
}
