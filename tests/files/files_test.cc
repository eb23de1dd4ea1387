// Files that are whole or absent, and children that leave nothing behind.
#include <algorithm>
#include <csignal>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>

#include "impedraw/files/child_process.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/files/sha256.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;

class Files : public ScratchFolder {
 protected:
  static std::string read(const fs::path& file) {
    std::ifstream in(file, std::ios::binary);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
  }
  std::vector<std::string> names() const {
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder_))
      found.push_back(entry.path().filename());
    std::sort(found.begin(), found.end());
    return found;
  }
};

TEST_F(Files, AFileIsReplacedWhole) {
  write_whole(folder_ / "a", "one");
  write_whole(folder_ / "a", "the second");
  EXPECT_EQ(read(folder_ / "a"), "the second");
  EXPECT_THAT(names(), ElementsAre("a"));
}

TEST_F(Files, ALinkIsReplacedAndItsTargetStays) {
  write("elsewhere/target", "mine");
  fs::create_directories(folder_ / "run");
  fs::create_symlink(folder_ / "elsewhere/target", folder_ / "run/report.html");
  write_whole(folder_ / "run/report.html", "ours");
  EXPECT_EQ(read(folder_ / "elsewhere/target"), "mine");
  EXPECT_FALSE(fs::is_symlink(folder_ / "run/report.html"));
  EXPECT_EQ(read(folder_ / "run/report.html"), "ours");
}

TEST_F(Files, WhatCannotBeWrittenStaysAsItWas) {
  write("a/file", "mine");
  EXPECT_THROW(write_whole(folder_ / "a", "a folder is there"), std::runtime_error);
  EXPECT_THROW(write_whole(folder_ / "none/such", ""), std::runtime_error);
  EXPECT_THAT(names(), ElementsAre("a"));
}

TEST_F(Files, OnlyWhatEndedProcessesLeftIsRemoved) {
  const pid_t ended = fork();
  if (ended == 0) _exit(0);
  waitpid(ended, nullptr, 0);
  write(".impedraw-part-" + std::to_string(ended) + "-run.h5", "");
  write(".impedraw-part-" + std::to_string(getppid()) + "-run.h5", "");
  write("mine", "");
  remove_unfinished(folder_);
  EXPECT_THAT(names(),
              ElementsAre(".impedraw-part-" + std::to_string(getppid()) + "-run.h5", "mine"));
}

// By sha256sum.
TEST_F(Files, Sha256) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256(std::string(1000000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
  for (const std::size_t n : {55, 56, 63, 64, 65, 119, 120}) {
    const fs::path file = write("data", std::string(n, 'x'));
    const MemoryFile out;
    ASSERT_EQ(run_child({"sha256sum", file.string()}, {{&out, 1}}), 0);
    EXPECT_EQ(out.content().substr(0, 64), sha256(std::string(n, 'x'))) << n;
  }
}

TEST_F(Files, AChildReadsAndWritesInMemory) {
  const MemoryFile in("to be copied"), out;
  EXPECT_EQ(
      run_child({"/bin/sh", "-c", "cat /dev/fd/3 > /dev/fd/4; exit 3"}, {{&in, 3}, {&out, 4}}), 3);
  EXPECT_EQ(out.content(), "to be copied");
  EXPECT_EQ(run_child({"/no/such/program"}, {}), -1);
  EXPECT_EQ(run_child({"/bin/sh", "-c", "kill -9 $$"}, {}), 137);
}

TEST_F(Files, AChildEndsWithItsCheck) {
  const MemoryFile out;
  int calls = 0;
  EXPECT_THROW(run_child({"/bin/sh", "-c", "echo $$ >&3; sleep 1000"}, {{&out, 3}},
                         [&] {
                           if (++calls > 3 && !out.content().empty()) throw std::runtime_error("");
                         }),
               std::runtime_error);
  EXPECT_NE(kill(std::stoi(out.content()), 0), 0) << "it still runs";
}

}  // namespace
}  // namespace impedraw
