// run.h5: what goes in comes out, whatever becomes of the process that wrote it.
#include "impedraw/log/log.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "impedraw/common/errors.h"
#include "impedraw/log/resume_log.h"
#include "impedraw/log/run_data.h"
#include "log/run_columns.h"
#include "made_up_run.h"

namespace impedraw {
namespace {

using ::testing::HasSubstr;
using testing::numbered_row;
using testing::small_header;
using Clock = std::chrono::steady_clock;

class RunLogTest : public ::testing::Test {
 protected:
  RunLogTest() {
    char name[] = "/tmp/impedraw_log_XXXXXX";
    folder_ = mkdtemp(name);
  }
  ~RunLogTest() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
  std::filesystem::path path() const { return folder_ / "run.h5"; }

  // What reading says of a log of so many rows after a change by h5py; empty if it is read.
  std::string message_after(const std::string& change, const RunLogHeader& header, int rows) const {
    std::filesystem::remove(path());
    RunLog log(path(), header);
    LogRow row(2);
    for (int i = 0; i < rows; ++i, row.time += 0.001) log.append(row);
    log.close();
    const std::string command = std::string(IMPEDRAW_PYTHON) +
                                " -c \"import h5py; f = h5py.File('" + path().string() +
                                "', 'a'); " + change + "\"";
    EXPECT_EQ(std::system(command.c_str()), 0);
    try {
      read_run(path());
    } catch (const InputError& e) {
      EXPECT_EQ(std::string(e.what()).find('\n'), std::string::npos);
      return e.what();
    }
    return "";
  }
};

void expect_row(const RunRows& run, std::size_t i) {
  const LogRow row = numbered_row(static_cast<int>(i));
  const auto k = static_cast<Eigen::Index>(i);
  ASSERT_EQ(run.time[i], row.time) << "row " << i;
  EXPECT_EQ(run.joint_position.row(k).transpose(), row.joint_position);
  EXPECT_EQ(run.joint_velocity.row(k).transpose(), row.joint_velocity);
  EXPECT_EQ(run.joint_torque.row(k).transpose(), row.joint_torque);
  EXPECT_EQ(run.torque_before_limits.row(k).transpose(), row.torque_terms[0] + row.torque_terms[1]);
  EXPECT_EQ(run.tip_position[i], row.tip_position);
  EXPECT_EQ(run.tip_orientation[i].coeffs(), row.tip_orientation.coeffs());
  EXPECT_EQ(run.desired_position[i], row.desired_position);
  EXPECT_EQ(run.contact_force[i], row.contact_force);
  EXPECT_EQ(run.contact_point[i], row.contact_point);
  EXPECT_EQ(run.contact_normal[i], row.contact_normal);
  EXPECT_EQ(run.disturbance_force[i], row.disturbance_force);
  EXPECT_EQ(run.surface_normal[i], row.surface_normal);
  EXPECT_EQ(run.surface_distance[i], row.surface_distance);
  EXPECT_EQ(run.push[i], row.push);
  EXPECT_EQ(run.mode[i], row.mode);
  EXPECT_EQ(run.stroke[i], row.stroke);
  EXPECT_EQ(run.stroke_along[i], row.stroke_along);
  EXPECT_EQ(run.time_scale[i], row.time_scale);
  EXPECT_EQ(run.step_time[i], row.step_time);
}

TEST_F(RunLogTest, EveryRowComesBack) {
  // About a chunk's and the ring's end, and far beyond: back-pressure included.
  for (const int n : {0, 1, 4095, 4096, 4097, 16384, 50000}) {
    SCOPED_TRACE(n);
    RunLog log(path(), small_header());
    for (int i = 0; i < n; ++i) log.append(numbered_row(i));
    EXPECT_EQ(log.steps(), n);
    const WallTimes wall = log.close({.start_up = 1.5, .loop = 2.5});
    const RunRows rows = read_rows(path());
    ASSERT_EQ(rows.rows(), n);
    for (int i = 0; i < n; i += (i % 4096 < 4094 ? 61 : 1)) expect_row(rows, i);
    if (n > 0) expect_row(rows, n - 1);
    const RunData run = read_run(path());
    ASSERT_EQ(run.rows(), n);
    EXPECT_EQ(run.wall.start_up, 1.5);
    EXPECT_EQ(run.wall.loop, 2.5);
    EXPECT_EQ(run.wall.writing, wall.writing);
    EXPECT_EQ(run.attributes.at("seed"), "7");
    EXPECT_EQ(run.joint_lower, Eigen::Vector2d(-1.0, -2.0));
    EXPECT_EQ(run.joint_upper, Eigen::Vector2d(1.5, 2.5));
    EXPECT_EQ(run.torque_limit, Eigen::Vector2d(10.0, 20.0));
    EXPECT_EQ(run.mode_names, (std::vector<std::string>{"free", "contact"}));
  }
}

TEST_F(RunLogTest, MeasuredJointsAreInTheLogWhereASensorIsSimulated) {
  RunLogHeader header = small_header();
  header.joint_sensor = true;
  header.joint_speed_limit = Eigen::Vector2d(2.0, std::numeric_limits<double>::infinity());
  {
    RunLog log(path(), header);
    for (int i = 0; i < 100; ++i) {
      LogRow row = numbered_row(i);
      row.measured_position = Eigen::Vector2d(i, -i);
      row.measured_velocity = Eigen::Vector2d(0.5 * i, 3.0);
      log.append(row);
    }
    log.close();
  }
  const std::string script = R"(
import h5py, sys
f = h5py.File(sys.argv[1])
assert list(f['joint/position'].attrs['speed_limit']) == [2.0, float('inf')]
assert list(f['joint/measured_position'][70]) == [70, -70]
assert list(f['joint/measured_velocity'][70]) == [35, 3]
for name in ('position', 'velocity'):
    assert all(f['joint/measured_' + name].attrs[a] for a in ('unit', 'frame', 'description'))
)";
  std::ofstream(folder_ / "script.py") << script;
  EXPECT_EQ(std::system((std::string(IMPEDRAW_PYTHON) + " " + (folder_ / "script.py").string() +
                         " " + path().string())
                            .c_str()),
            0);
  expect_row(read_rows(path()), 70);  // nothing else has moved
  // A run without a sensor cannot go on in it.
  EXPECT_THROW(RunLog::append_to(path(), small_header()), InputError);
}

TEST_F(RunLogTest, StaticDataComesBack) {
  const RunLogHeader header = testing::sine_header({});
  RunLog(path(), header).close();
  const RunData run = read_run(path());
  EXPECT_EQ(run.canvas_vertices, header.canvas_vertices);
  EXPECT_EQ(run.canvas_triangles, header.canvas_triangles);
  EXPECT_EQ(run.cloud_points, header.cloud_points);
  EXPECT_EQ(run.target_points, header.target_points);
  EXPECT_EQ(run.target_stroke, header.target_stroke);
}

TEST_F(RunLogTest, TheSameRunGivesTheSameFile) {
  const auto write = [&](const char* name, int pause_at) {
    RunLog log(folder_ / name, small_header());
    for (int i = 0; i < 10000; ++i) {
      if (i == pause_at)
        std::this_thread::sleep_for(std::chrono::milliseconds(600));  // the flushes fall elsewhere
      log.append(numbered_row(i));
    }
    log.close({1.0, 1.0, 0.0});
    return read_rows(folder_ / name);
  };
  const RunRows a = write("a.h5", -1), b = write("b.h5", 3000);
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.joint_position, b.joint_position);
  EXPECT_EQ(a.contact_force, b.contact_force);
  EXPECT_EQ(a.stroke, b.stroke);
}

// Other programs must be able to read it: h5py with an HDF5 of its own.
TEST_F(RunLogTest, H5pyFindsEveryDatasetDescribed) {
  {
    RunLog log(path(), testing::sine_header({}));
    for (int i = 0; i < 5000; ++i) log.append(LogRow(7));
    log.close({1.0, 2.0, 0.0});
  }
  const std::string script = R"(
import h5py, sys
f = h5py.File(sys.argv[1])
names = []
f.visititems(lambda name, o: names.append(name) if isinstance(o, h5py.Dataset) else None)
for name in names:
    for a in ('unit', 'frame', 'description'):
        assert f[name].attrs[a], (name, a)
desired = '''time joint/position joint/velocity joint/torque tip/position tip/orientation
tip/velocity desired/position desired/orientation contact/force contact/point
contact/normal wrench/measured disturbance/force surface/normal surface/distance
push mode stroke stroke_along time_scale controller/step_time canvas/vertices canvas/triangles
cloud/points cloud/normals cloud/camera target/points target/stroke torque/gravity
torque/impedance torque/push torque/null_space torque/coriolis torque/feedback
torque/friction'''.split()
assert sorted(desired) == sorted(names), set(desired) ^ set(names)
width = {'joint/position': 7, 'torque/push': 7, 'tip/orientation': 4,
         'tip/velocity': 6, 'contact/force': 3, 'wrench/measured': 6}
for name, w in width.items():
    assert f[name].shape == (5000, w) and f[name].dtype == 'f8', name
assert f['stroke'].shape == (5000,) and f['stroke'].dtype.kind == 'i'
assert f['target/stroke'].dtype.kind == 'i' and f['target/points'].shape[1] == 3
assert list(f['mode'].attrs['names']) == ['free', 'approach', 'contact', 'lift']
assert all(len(f['joint/position'].attrs[a]) == 7 for a in ('lower', 'upper', 'torque_limit'))
assert f.attrs['wall_start_up'] == 1.0 and f.attrs['wall_loop'] == 2.0
assert f.attrs['wall_writing'] >= 0
assert f['time'].chunks and f['time'].compression == 'gzip' and f['time'].shuffle
)";
  const std::filesystem::path file = folder_ / "look.py";
  std::ofstream(file) << script;
  const std::string command =
      std::string(IMPEDRAW_PYTHON) + " " + file.string() + " " + path().string();
  EXPECT_EQ(std::system(command.c_str()), 0);
}

// As logs were before the plan's clock could yield.
TEST_F(RunLogTest, ALogWithoutTimeScaleRanAsPlanned) {
  {
    RunLog log(path(), small_header());
    for (int i = 0; i < 100; ++i) log.append(numbered_row(i));
    log.close();
  }
  const std::string command = std::string(IMPEDRAW_PYTHON) + " -c \"import h5py; f = h5py.File('" +
                              path().string() + "', 'a'); del f['time_scale']\"";
  ASSERT_EQ(std::system(command.c_str()), 0);
  const RunRows rows = read_rows(path());
  ASSERT_EQ(rows.rows(), 100u);
  EXPECT_EQ(rows.time_scale, std::vector<double>(100, 1.0));
  EXPECT_THROW(RunLog::append_to(path(), small_header()), InputError);
}

// A child writes at its own pace and is killed at some instant; all but its last second must be
// there, and right.
TEST_F(RunLogTest, KillLosesLessThanTheLastSecond) {
  for (const auto& [milliseconds, rows_per_ms] : {std::pair{1300, 40}, std::pair{1630, 1}}) {
    SCOPED_TRACE(::testing::Message() << milliseconds << " ms at " << rows_per_ms << " rows a ms");
    int progress[2];
    ASSERT_EQ(pipe(progress), 0);
    const pid_t child = fork();
    if (child == 0) {
      RunLog log(path(), small_header());
      const Clock::time_point start = Clock::now();
      for (int i = 0;;) {
        const auto due =
            std::chrono::duration_cast<std::chrono::milliseconds>(Clock::now() - start).count() *
            rows_per_ms;
        for (; i < due; ++i) log.append(numbered_row(i));
        if (write(progress[1], &i, sizeof i) < 0) _exit(1);
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
      }
    }
    close(progress[1]);
    // Rows appended against the time at which the parent heard of it.
    std::vector<std::pair<Clock::time_point, int>> heard;
    // Not before a row is old enough to be owed: a busy machine may start the child late.
    Clock::time_point kill_at = Clock::now() + std::chrono::milliseconds(milliseconds);
    for (int i; Clock::now() < kill_at && read(progress[0], &i, sizeof i) == sizeof i;) {
      const bool is_first = i > 0 && (heard.empty() || heard.back().second == 0);
      heard.emplace_back(Clock::now(), i);
      if (is_first) kill_at = std::max(kill_at, Clock::now() + std::chrono::milliseconds(1200));
    }
    const Clock::time_point killed = Clock::now();
    kill(child, SIGKILL);
    waitpid(child, nullptr, 0);
    close(progress[0]);
    int owed = 0;
    for (const auto& [when, rows] : heard) {
      if (killed - when >= std::chrono::seconds(1)) owed = rows;
    }
    EXPECT_TRUE(recover_log(path()));
    const RunRows run = read_rows(path());
    EXPECT_GE(static_cast<int>(run.rows()), owed);
    EXPECT_GT(owed, 0) << "the child was too slow to show anything";
    for (std::size_t i = 0; i < run.rows(); i += 37) expect_row(run, i);
    EXPECT_TRUE(std::isnan(read_run(path()).wall.loop));
    const std::string look =
        std::string(IMPEDRAW_PYTHON) + " -c \"import h5py; f = h5py.File('" + path().string() +
        "'); f.visititems(lambda n, o: o[()].shape if isinstance(o, h5py.Dataset) else None)\"";
    EXPECT_EQ(std::system(look.c_str()), 0);
  }
}

TEST_F(RunLogTest, AFullDiskIsReportedAndKeepsWhatWasThere) {
  const pid_t child = fork();
  if (child == 0) {
    // As a full disk, but for one process: no file may grow beyond 2 MB.
    const rlimit limit{2 << 20, 2 << 20};
    setrlimit(RLIMIT_FSIZE, &limit);
    std::signal(SIGXFSZ, SIG_IGN);
    try {
      RunLog log(path(), small_header());
      for (int i = 0; i < 1000000; ++i) log.append(numbered_row(i));
      log.close();
    } catch (const LogError& e) {
      const std::string message = e.what();
      _exit(message.find("run.h5") != std::string::npos &&
                    message.find("File too large") != std::string::npos
                ? 0
                : 2);
    }
    _exit(1);
  }
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0) << "1: nothing reported; 2: the message lacks file or cause";
  EXPECT_EQ(read_run(path()).rows(), 0u) << "the log is as the run began";
  EXPECT_TRUE(recover_log(path()));
  const RunRows rows = read_rows(path());
  EXPECT_GT(rows.rows(), 1000u);
  for (std::size_t i = 0; i < rows.rows(); i += 37) expect_row(rows, i);
  std::vector<std::string> left;
  for (const auto& entry : std::filesystem::directory_iterator(folder_))
    left.push_back(entry.path().filename());
  EXPECT_THAT(left, ::testing::ElementsAre("run.h5"));
}

TEST_F(RunLogTest, BadUseIsRefused) {
  EXPECT_THROW(RunLog(folder_ / "no" / "such" / "run.h5", small_header()), LogError);
  RunLogHeader header = small_header();
  header.torque_limit.resize(1);
  EXPECT_THROW(RunLog(path(), header), std::invalid_argument);
  RunLog log(path(), small_header());
  EXPECT_THROW(log.append(LogRow(3)), std::invalid_argument);
}

TEST_F(RunLogTest, BadFilesAreNamed) {
  const auto message = [](const std::filesystem::path& file) -> std::string {
    try {
      read_run(file);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_THAT(message(folder_ / "none.h5"), HasSubstr("no such file"));
  std::ofstream(folder_ / "text.h5") << "not a log";
  EXPECT_THAT(message(folder_ / "text.h5"), HasSubstr("not an HDF5 file"));
  const std::string other = (folder_ / "other.h5").string();
  const std::string command =
      std::string(IMPEDRAW_PYTHON) + " -c \"import h5py; h5py.File('" + other + "', 'w')\"";
  ASSERT_EQ(std::system(command.c_str()), 0);
  EXPECT_THAT(message(folder_ / "other.h5"), HasSubstr("/joint/position is missing"));
}

// A copy that broke off, a disk that was full.
TEST_F(RunLogTest, AFileThatLostItsEndIsReadUpToThere) {
  constexpr std::size_t kRows = 40000;
  {
    RunLog log(path(), small_header());
    for (std::size_t i = 0; i < kRows; ++i) log.append(numbered_row(static_cast<int>(i)));
    log.close(WallTimes{1.0, 2.0, 3.0});
  }
  const RunData whole = read_run(path());
  ASSERT_EQ(whole.rows(), kRows);
  EXPECT_FALSE(whole.cut_short);
  const auto size = std::filesystem::file_size(path());
  std::size_t before = kRows;
  for (const double share : {0.999, 0.9, 0.7, 0.5, 0.3}) {
    std::filesystem::resize_file(path(), static_cast<std::uintmax_t>(share * size));
    const RunRows rows = read_rows(path());
    EXPECT_LE(rows.rows(), before) << share;
    // Chunks of all datasets follow each other: of each share, as much is left.
    EXPECT_GE(rows.rows() + 2 * 4096, share * kRows) << share;
    for (std::size_t i = 0; i < rows.rows(); i += 997) expect_row(rows, i);
    if (rows.rows() > 0) expect_row(rows, rows.rows() - 1);
    before = rows.rows();
    const RunData run = read_run(path());
    EXPECT_EQ(run.rows(), rows.rows());
    EXPECT_TRUE(run.cut_short);
    EXPECT_EQ(run.f, std::vector<double>(whole.f.begin(), whole.f.begin() + run.rows()));
  }
  EXPECT_LT(before, kRows / 2);
  EXPECT_GT(before, 0u);
  const auto refuses = [&](const auto& doing) {
    try {
      doing();
      return std::string();
    } catch (const InputError& e) {
      return std::string(e.what());
    }
  };
  EXPECT_THAT(refuses([&] { read_resume_log(path()); }), HasSubstr("is cut short"));
  EXPECT_THAT(refuses([&] { RunLog::append_to(path(), small_header()); }),
              HasSubstr("bytes too few"));
  EXPECT_EQ(std::filesystem::file_size(path()), static_cast<std::uintmax_t>(0.3 * size));
  std::filesystem::resize_file(path(), 1000);  // its superblock, and little else
  EXPECT_THAT(refuses([&] { read_run(path()); }), HasSubstr(path().string()));
}

TEST_F(RunLogTest, ForgedFilesAreRefused) {
  const auto message = [&](const std::string& change) {
    return message_after(change, small_header(), 1);
  };
  EXPECT_EQ(message("f.attrs['x'] = 1"), "");
  EXPECT_THAT(
      message("del f['/canvas/vertices']; "
              "f.create_dataset('/canvas/vertices', (2**40, 3))"),
      HasSubstr("dataset /canvas/vertices has 1099511627776 rows, at most 100000000 are read"));
  EXPECT_THAT(message("f['/joint/position'].attrs.create('lower', [], dtype='f8')"),
              HasSubstr("attribute lower of /joint/position is empty"));
  EXPECT_THAT(message("f['/joint/position'].attrs.create('lower', [1.0] * 20, dtype='f8')"),
              HasSubstr("attribute lower of /joint/position has 20 numbers, at most 12"));
  EXPECT_THAT(message("f['/joint/position'].attrs.create('lower', [1.0] * 2000, dtype='f8')"),
              HasSubstr("attribute lower has more than 1024 values"));
  EXPECT_THAT(message("f['/time'].resize((2**45, 1) if f['/time'].ndim == 2 else (2**45,))"),
              HasSubstr("dataset /time has 35184372088832 rows, at most 100000000"));
  EXPECT_THAT(message("del f['/target/points']"), HasSubstr("dataset /target/points is missing"));
  EXPECT_THAT(message("del f['/target/points']; f['/target/points'] = ['a', 'b']"),
              HasSubstr("dataset /target/points holds no numbers"));
}

// Values that later stages would index with, take the square of, or step along.
TEST_F(RunLogTest, ForgedValuesAreRefusedWithTheirPlace) {
  RunLogHeader header = small_header();
  header.canvas_vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  header.canvas_triangles = {{0, 1, 2}};
  header.cloud_points = header.cloud_normals = {{0, 0, 1}};
  header.cloud_camera = {0};
  header.target_points = {{0, 0, 0}, {0.1, 0, 0}};
  header.target_stroke = {0, 0};
  const auto message = [&](const std::string& change) { return message_after(change, header, 3); };
  EXPECT_EQ(message("pass"), "");
  EXPECT_THAT(message("f['/canvas/triangles'][0, 2] = 3"),
              HasSubstr("dataset /canvas/triangles: row 0 names vertex 3, must be 0 to 2"));
  EXPECT_THAT(message("f['/canvas/triangles'][0, 1] = -1"),
              HasSubstr("dataset /canvas/triangles: row 0 names vertex -1"));
  EXPECT_THAT(message("f['/canvas/vertices'][1, 0] = 1e300"),
              HasSubstr("dataset /canvas/vertices: row 1 is (1e+300, 0, 0), must be finite"));
  EXPECT_THAT(message("f['/cloud/points'][0, 2] = float('nan')"),
              HasSubstr("dataset /cloud/points: row 0 is (0, 0, nan)"));
  EXPECT_THAT(message("f['/target/points'][1, 0] = 1e12"),
              HasSubstr("dataset /target/points: row 1 is (1e+12, 0, 0)"));
  EXPECT_THAT(message("f['/target/points'][1, 0] = 50"),
              HasSubstr("dataset /target/points: row 1 is 50 m from the point before it"));
  EXPECT_THAT(message("f['/target/stroke'][1] = -2"),
              HasSubstr("dataset /target/stroke: row 1 is -2, must be 0 to"));
  EXPECT_THAT(message("f['/time'][1] = 5"),
              HasSubstr("dataset /time: row 2 is 0.002, must be more than 5 s"));
  EXPECT_THAT(message("f['/mode'][1] = 99"), HasSubstr("dataset /mode: row 1 is 99, must be 0 to"));
  EXPECT_THAT(message("f['/stroke'][1] = -7"), HasSubstr("dataset /stroke: row 1 is -7"));
  EXPECT_THAT(message("f['/contact/point'][1] = [0, 0, 1e12]"),
              HasSubstr("dataset /contact/point: row 1 is (0, 0, 1e+12)"));
}

// A log that names other files: they might be anything, and never end.
TEST_F(RunLogTest, LinksOutOfTheFileAreRefused) {
  const auto message = [&](const std::string& change) {
    return message_after(change, small_header(), 1);
  };
  EXPECT_THAT(message("del f['/time']; f['/time'] = h5py.ExternalLink('/dev/zero', '/time')"),
              HasSubstr("/time is a link to another place"));
  EXPECT_THAT(message("del f['/tip']; f['/tip'] = h5py.SoftLink('/joint')"),
              HasSubstr("/tip is a link to another place"));
  EXPECT_THAT(message("del f['/target/stroke']; f.create_dataset('/target/stroke', (9,), 'i4', "
                      "external=[('/dev/zero', 0, 36)])"),
              HasSubstr("dataset /target/stroke is stored in another file"));
}

TEST_F(RunLogTest, PipesAreNotOpened) {
  ASSERT_EQ(mkfifo(path().c_str(), 0600), 0);
  try {
    read_run(path());
    ADD_FAILURE() << "accepted";
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), HasSubstr("is a pipe, must be a regular file"));
  }
}

}  // namespace
}  // namespace impedraw
