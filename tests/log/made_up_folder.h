// A folder of its own for each test, and made-up runs in it.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include "impedraw/log/run_data.h"
#include "made_up_run.h"

namespace impedraw::testing {

inline std::string text_of(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

class MadeUpFolder : public ::testing::Test {
 protected:
  MadeUpFolder() {
    char name[] = "/tmp/impedraw_test_XXXXXX";
    folder_ = mkdtemp(name);
  }
  ~MadeUpFolder() override { std::filesystem::remove_all(folder_); }

  RunData made_up(const MadeUpSine& settings, const std::filesystem::path& folder) {
    std::filesystem::create_directories(folder);
    RunLog log(folder / "run.h5", sine_header(settings));
    sine_rows(settings, [&](const LogRow& row) { log.append(row); });
    log.close({1.0, 0.3, 0.0});
    return read_run(folder / "run.h5");
  }

  std::filesystem::path folder_;
};

}  // namespace impedraw::testing
