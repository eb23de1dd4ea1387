// A run that goes on in the log of an earlier one: the file is that of one run, whatever ended the
// first.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "impedraw/common/errors.h"
#include "impedraw/log/resume_log.h"
#include "impedraw/log/run_data.h"
#include "log/run_columns.h"
#include "made_up_run.h"

namespace impedraw {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using testing::numbered_row;
using testing::small_header;

class AppendTest : public ::testing::Test {
 protected:
  AppendTest() {
    char name[] = "/tmp/impedraw_append_XXXXXX";
    folder_ = mkdtemp(name);
  }
  ~AppendTest() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path path(const char* name = "run.h5") const { return folder_ / name; }

  static void append(RunLog& log, int from, int to) {
    for (int i = from; i < to; ++i) log.append(numbered_row(i));
  }
  void write(const std::filesystem::path& file, int rows,
             const WallTimes& wall = {1.0, 2.0, 0.0}) const {
    RunLog log(file, small_header());
    append(log, 0, rows);
    log.close(wall);
  }
  void go_on(const std::filesystem::path& file, int from, int to,
             const WallTimes& wall = {1.0, 2.0, 0.0}) const {
    RunLog log = RunLog::append_to(file, small_header());
    ASSERT_EQ(log.steps(), from);
    append(log, from, to);
    EXPECT_EQ(log.steps(), to);
    log.close(wall);
  }

  void wait_for_go() const {
    while (!std::filesystem::exists(folder_ / "go"))
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  // Until a copy of the log that a child writes shows `rows` rows: a minute at most, since a busy
  // disk takes its time.
  void wait_until_recoverable(int rows) const {
    const std::filesystem::path copy = folder_ / "copy";
    for (int tries = 0; tries < 300; ++tries) {
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
      std::filesystem::remove_all(copy);
      std::filesystem::create_directory(copy);
      for (const auto& file : std::filesystem::directory_iterator(folder_))
        if (file.path().filename().string().starts_with("run."))
          std::filesystem::copy_file(file.path(), copy / file.path().filename());
      try {
        recover_log(copy / "run.h5");
        if (static_cast<int>(read_rows(copy / "run.h5").rows()) >= rows) return;
      } catch (const InputError&) {  // copied before its header was written
      }
    }
  }

  // By h5py, dataset by dataset and attribute by attribute; of the wall times only that they are
  // there.
  void expect_same(const std::filesystem::path& a, const std::filesystem::path& b) const {
    std::ofstream(folder_ / "same.py") << R"(
import h5py, sys, numpy as np
a, b = (h5py.File(p) for p in sys.argv[1:3])
def names(f):
    found = []
    f.visititems(lambda name, o: found.append(name) if isinstance(o, h5py.Dataset) else None)
    return found
assert names(a) == names(b) and len(names(a)) > 20
for n in names(a):
    x, y = a[n][()], b[n][()]
    same = x.shape == y.shape and x.dtype == y.dtype and x.tobytes() == y.tobytes()
    assert same, (n, x.shape, y.shape)
    assert sorted(a[n].attrs) == sorted(b[n].attrs), n
    for k in a[n].attrs: assert np.all(a[n].attrs[k] == b[n].attrs[k]), (n, k)
assert sorted(a.attrs) == sorted(b.attrs), (list(a.attrs), list(b.attrs))
for k in a.attrs: assert k.startswith('wall_') or k == 'log_id' or a.attrs[k] == b.attrs[k], k
)";
    const std::string command = std::string(IMPEDRAW_PYTHON) + " " + path("same.py").string() +
                                " " + a.string() + " " + b.string();
    EXPECT_EQ(std::system(command.c_str()), 0);
  }

  // A child that runs `work`, which ends by killing itself, without any clearing up. It gets its
  // go once a kill would leave `rows` rows.
  void in_killed_child(const std::function<void()>& work, int rows) const {
    const pid_t child = fork();
    if (child == 0) {
      work();
      _exit(1);
    }
    wait_until_recoverable(rows);
    std::ofstream(folder_ / "go").close();
    int status = 0;
    waitpid(child, &status, 0);
    std::filesystem::remove(folder_ / "go");
    ASSERT_TRUE(WIFSIGNALED(status));
  }

  std::filesystem::path folder_;
};

TEST_F(AppendTest, GivesTheFileOfOneRun) {
  // At, about and far from the ends of chunks (4,096 rows) and of the ring (16,384).
  const std::vector<std::vector<int>> all_ends = {
      {0, 3}, {1, 4095, 4096}, {4096, 4097, 9000}, {5000, 5000, 40000}, {16384, 16390, 20480}};
  for (const std::vector<int>& ends : all_ends) {
    SCOPED_TRACE(::testing::PrintToString(ends));
    write(path("one.h5"), ends.back());
    write(path(), ends.front());
    for (std::size_t k = 1; k < ends.size(); ++k) go_on(path(), ends[k - 1], ends[k]);
    expect_same(path("one.h5"), path());
  }
}

TEST_F(AppendTest, WallTimesAreSummed) {
  write(path(), 100, {1.0, 2.0, 0.0});
  const double written = read_run(path()).wall.writing;
  RunLog log = RunLog::append_to(path(), small_header());
  append(log, 100, 200);
  EXPECT_EQ(read_run(path()).wall.loop, 2.0) << "while it goes on, the log is that of the first";
  EXPECT_EQ(read_run(path()).rows(), 100u);
  const WallTimes second = log.close({0.5, 3.0});
  const WallTimes sum = read_run(path()).wall;
  EXPECT_EQ(sum.start_up, 1.5);
  EXPECT_EQ(sum.loop, 5.0);
  EXPECT_DOUBLE_EQ(sum.writing, written + second.writing);
}

TEST_F(AppendTest, AfterAKillGoesOnBehindTheLastWholeRow) {
  write(path("one.h5"), 30000);
  for (const int rows : {100, 4096, 10000}) {
    SCOPED_TRACE(rows);
    in_killed_child(
        [&] {
          RunLog log(path(), small_header());
          append(log, 0, rows);
          wait_for_go();
          append(log, rows, rows + 20);  // not synced
          kill(getpid(), SIGKILL);
        },
        rows);
    EXPECT_TRUE(recover_log(path()));
    const int kept = static_cast<int>(read_rows(path()).rows());
    EXPECT_GE(kept, rows);
    // Killed again while going on, then to the end.
    in_killed_child(
        [&] {
          RunLog log = RunLog::append_to(path(), small_header());
          append(log, kept, kept + 5000);
          wait_for_go();
          kill(getpid(), SIGKILL);
        },
        kept + 5000);
    go_on(path(), kept + 5000, 30000);
    EXPECT_TRUE(std::isnan(read_run(path()).wall.loop)) << "what a killed part took nobody knows";
    expect_same(path("one.h5"), path());
  }
}

// What a kill within a flush can leave: datasets of unequal length, or extended without data. Made
// here by h5py.
TEST_F(AppendTest, WhatIsNotWholeIsCutBack) {
  write(path("one.h5"), 12000);
  const std::pair<const char*, int> damages[] = {
      {"f['contact/force'].resize(8500, axis=0)", 8500},
      {"f['push'].resize(4096, axis=0)", 4096},
      {"[f[n].resize(14000, axis=0) for n in names]",
       10000},  // time is NaN, and a chunk is missing
      {"[f[n].resize(10200, axis=0) for n in names]; f['time'][10000:] = np.zeros(200)",
       10000},  // as a chunk that was not full
      {"id = f['mode'].id.get_chunk_info(2); b = id.byte_offset, id.size",
       8192}};  // bytes that are not its own
  for (const auto& [damage, whole] : damages) {
    SCOPED_TRACE(damage);
    write(path(), 10000);
    std::ofstream(path("damage.py"))
        << "import h5py, sys, numpy as np\nb = None\nwith h5py.File(sys.argv[1], 'r+') as f:\n"
        << "  names = []\n  f.visititems(lambda n, o: names.append(n) if isinstance(o, "
           "h5py.Dataset) and "
           "len(o) == 10000 else None)\n  "
        << damage << "\n"
        << "if b:\n  with open(sys.argv[1], 'r+b') as f:\n    f.seek(b[0]); f.write(bytes(b[1]))\n";
    const std::string command =
        std::string(IMPEDRAW_PYTHON) + " " + path("damage.py").string() + " " + path().string();
    ASSERT_EQ(std::system(command.c_str()), 0);
    const int kept = static_cast<int>(read_rows(path()).rows());
    EXPECT_EQ(kept, whole);
    go_on(path(), kept, 12000);
    expect_same(path("one.h5"), path());
  }
}

TEST_F(AppendTest, AnotherHeaderIsRefusedAndNamed) {
  write(path(), 100);
  const auto message = [&](const std::function<void(RunLogHeader&)>& change) -> std::string {
    RunLogHeader header = small_header();
    change(header);
    try {
      RunLog::append_to(path(), header);
    } catch (const InputError& e) {
      EXPECT_THAT(e.what(), HasSubstr(path().string()));
      return e.what();
    }
    return "";
  };
  EXPECT_THAT(message([](RunLogHeader& h) {
                h.joint_names = {"one", "drei"};
              }),
              HasSubstr("joints: one, two in the log, one, drei now"));
  EXPECT_THAT(message([](RunLogHeader& h) { h.joint_upper[1] = 2.25; }),
              AllOf(HasSubstr("upper limit of joint 2: 2.5"), HasSubstr("2.25")));
  EXPECT_THAT(message([](RunLogHeader& h) { h.torque_terms = {"push"}; }),
              HasSubstr("torque terms: gravity, push in the log, push now"));
  EXPECT_THAT(message([](RunLogHeader& h) { h.mode_names.pop_back(); }),
              HasSubstr("contact states"));
  EXPECT_THAT(message([](RunLogHeader& h) { h.canvas_vertices.resize(3); }),
              HasSubstr("/canvas/vertices: 0 in the log, 3 now"));
  EXPECT_THAT(message([](RunLogHeader& h) { h.canvas_triangles.resize(1); }),
              HasSubstr("/canvas/triangles"));
  EXPECT_THAT(
      message([](RunLogHeader& h) { h.target_points.resize(2), h.target_stroke.resize(2); }),
      HasSubstr("/target/points"));
  EXPECT_EQ(read_rows(path()).rows(), 100u);
  EXPECT_EQ(read_run(path()).wall.loop, 2.0) << "a refused file must stay as it was";
  EXPECT_EQ(message([](RunLogHeader& h) { std::swap(h.torque_terms[0], h.torque_terms[1]); }), "")
      << "a file's group has no order";
  EXPECT_THROW(RunLog::append_to(path("none.h5"), small_header()), InputError);
  std::ofstream(path("text.h5")) << "no log";
  EXPECT_THROW(RunLog::append_to(path("text.h5"), small_header()), InputError);
}

TEST_F(AppendTest, DrawnBeforeHoldsWhatTheRowsHold) {
  constexpr int kRows = 9000;
  write(path(), kRows);
  const ResumeLog drawn = read_resume_log(path());
  ASSERT_EQ(drawn.rows.size(), static_cast<std::size_t>(kRows));
  for (int i = 0; i < kRows; i += 7) {
    const LogRow row = numbered_row(i);
    const ResumeRow& d = drawn.rows[i];
    EXPECT_EQ(d.time, row.time);
    EXPECT_EQ(d.stroke, row.stroke);
    EXPECT_EQ(d.stroke_along, row.stroke_along);
    EXPECT_EQ(d.mode, row.mode);
    double f = 0.0;
    for (int k = 0; k < 3; ++k) f += row.wrench_measured[k] * row.surface_normal[k];
    EXPECT_DOUBLE_EQ(d.f, f);
  }
  int i = 0;
  visit_rows(path(), [&](const LogRow& d) {
    const LogRow row = numbered_row(i++);
    EXPECT_EQ(d.stroke_along, row.stroke_along);
    EXPECT_EQ(d.mode, row.mode);
    if (row.contact_point.allFinite()) EXPECT_EQ(d.contact_point, row.contact_point);
  });
  EXPECT_EQ(i, kRows);
  EXPECT_EQ(drawn.joint_position, Eigen::VectorXd(numbered_row(kRows - 1).joint_position));
  write(path("empty.h5"), 0);
  EXPECT_TRUE(read_resume_log(path("empty.h5")).rows.empty());
  EXPECT_EQ(read_resume_log(path("empty.h5")).joint_position.size(), 0);
  EXPECT_THROW(read_resume_log(path("none.h5")), InputError);
}

}  // namespace
}  // namespace impedraw
