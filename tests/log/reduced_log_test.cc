// A reduced log: five times smaller, with the numbers of a full one.
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <thread>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>
#include <nlohmann/json.hpp>

#include "impedraw/log/resume_log.h"
#include "impedraw/log/run_data.h"
#include "impedraw/metrics/metrics.h"
#include "log/run_columns.h"
#include "made_up_run.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;
using testing::MadeUpSine;

class ReducedLog : public ::testing::Test {
 protected:
  ReducedLog() {
    char name[] = "/tmp/impedraw_reduced_XXXXXX";
    folder_ = mkdtemp(name);
  }
  ~ReducedLog() override { fs::remove_all(folder_); }

  fs::path path(const char* name) const { return folder_ / name; }

  static RunLogHeader header(LogRate rate, const MadeUpSine& settings = {}) {
    RunLogHeader h = testing::sine_header(settings);
    h.rate = rate;
    return h;
  }
  // Those of a sine; a joint is clipped and near its limit now and then.
  static const std::vector<LogRow>& sine() {
    static const std::vector<LogRow> rows = [] {
      std::vector<LogRow> all;
      sine_rows(MadeUpSine{.repeat = 2}, [&](const LogRow& row) {
        all.push_back(row);
        LogRow& last = all.back();
        for (int j = 0; j < 7; ++j) {
          last.joint_position[j] += 1e-3 * j * std::sin(7.0 * row.time + j);
          last.joint_velocity[j] += 1e-2 * std::cos(11.0 * row.time + j);
        }
        if (all.size() % 500 == 0) last.joint_torque[3] *= 0.5;
      });
      return all;
    }();
    return rows;
  }
  fs::path write(const char* name, LogRate rate) const {
    RunLog log(path(name), header(rate, {.repeat = 2}));
    for (const LogRow& row : sine()) log.append(row);
    EXPECT_EQ(log.steps(), static_cast<long>(sine().size()));
    log.close({1.0, 2.0, 0.0});
    return path(name);
  }
  bool python(const std::string& script, const fs::path& file) const {
    std::ofstream(path("script.py")) << "import h5py, sys, numpy as np\n"
                                     << "f = h5py.File(sys.argv[1])\n"
                                     << script;
    return std::system((std::string(IMPEDRAW_PYTHON) + " " + path("script.py").string() + " " +
                        file.string())
                           .c_str()) == 0;
  }
  fs::path folder_;
};

// NaN is as good as NaN.
template <typename T>
void expect_same(const std::vector<T>& a, const std::vector<T>& b, const char* what) {
  ASSERT_EQ(a.size(), b.size()) << what;
  EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(T)), 0) << what;
}

void expect_same_steps(const RunData& a, const RunData& b) {
  expect_same(a.time, b.time, "time");
  expect_same(a.f, b.f, "f");
  expect_same(a.contact_point, b.contact_point, "contact_point");
  expect_same(a.tilt, b.tilt, "tilt");
  expect_same(a.normal_error, b.normal_error, "normal_error");
  expect_same(a.tracking_error, b.tracking_error, "tracking_error");
  expect_same(a.push, b.push, "push");
  expect_same(a.torque_share, b.torque_share, "torque_share");
  expect_same(a.time_scale, b.time_scale, "time_scale");
  expect_same(a.stroke, b.stroke, "stroke");
  expect_same(a.mode, b.mode, "mode");
  EXPECT_EQ(a.clipped, b.clipped);
  EXPECT_EQ(a.joint_margin, b.joint_margin);
  EXPECT_EQ(a.joint_speed_share, b.joint_speed_share);
  for (std::size_t i = 0; i < a.step_time.size(); i += 7)
    ASSERT_FLOAT_EQ(a.step_time[i], b.step_time[i]);
}

TEST_F(ReducedLog, HasTheMetricsOfTheFullOne) {
  const RunData full = read_run(write("full.h5", LogRate::full)),
                reduced = read_run(write("reduced.h5", LogRate::reduced));
  ASSERT_EQ(reduced.rows(), sine().size());
  ASSERT_GT(*full.clipped, 10u);
  expect_same_steps(full, reduced);
  auto a = metrics_json(compute_metrics(full)), b = metrics_json(compute_metrics(reduced));
  EXPECT_GT(a.at("force_peak").get<double>(), 5.0);
  for (const char* wall :
       {"step_time_p50", "step_time_p99", "step_time_p999", "real_time_factor", "wall_seconds"})
    a.erase(wall), b.erase(wall);
  EXPECT_EQ(a.dump(), b.dump());
}

// Of what grows with the run.
TEST_F(ReducedLog, IsFiveTimesSmaller) {
  const fs::path full = write("full.h5", LogRate::full);
  EXPECT_TRUE(python("full = h5py.File('" + full.string() + "')" + R"(
def stored(f):
    sizes = []
    def look(name, o):
        if isinstance(o, h5py.Dataset) and name.split('/')[0] not in ('canvas', 'cloud', 'target'):
            sizes.append(o.id.get_storage_size())
    f.visititems(look)
    return sum(sizes) / full['time'][-1]
print('bytes per simulated second:', stored(full), stored(f), 'ratio', stored(full) / stored(f))
assert stored(full) >= 5 * stored(f)
)",
                     write("reduced.h5", LogRate::reduced)));
}

TEST_F(ReducedLog, RowsAreRegularAndHoldTheExtremesOfTheForce) {
  const RunRows rows = read_rows(write("run.h5", LogRate::reduced));
  const auto force = [](const auto& f, const auto& n) {
    return std::isfinite(f.dot(n)) ? f.dot(n) : 0.0;
  };
  const std::vector<LogRow>& all = sine();
  ASSERT_LT(rows.rows(), all.size() / 8);
  EXPECT_EQ(rows.time.front(), all.front().time);
  EXPECT_EQ(rows.time.back(), all.back().time);
  std::size_t k = 0;
  for (std::size_t begin = 0; begin < all.size(); begin += 128) {
    const std::size_t end = std::min(begin + 128, all.size());
    double least = 1e9, largest = -1e9, least_kept = 1e9, largest_kept = -1e9;
    for (std::size_t i = begin; i < end; ++i) {
      const double f = force(all[i].contact_force, all[i].contact_normal);
      least = std::min(least, f), largest = std::max(largest, f);
      if (k == rows.rows() || rows.time[k] != all[i].time) {
        // Left out: no regular row, and nothing changes here.
        ASSERT_NE(i % 16, 0u) << i;
        ASSERT_EQ(all[i].stroke, all[i - 1].stroke) << i;
        ASSERT_EQ(all[i].mode, all[i - 1].mode) << i;
        continue;
      }
      EXPECT_EQ(rows.joint_position.row(static_cast<Eigen::Index>(k)).transpose(),
                all[i].joint_position);
      EXPECT_EQ(rows.stroke[k], all[i].stroke);
      const double kept = force(rows.contact_force[k], rows.contact_normal[k]);
      EXPECT_EQ(kept, f);
      least_kept = std::min(least_kept, kept), largest_kept = std::max(largest_kept, kept);
      ++k;
    }
    EXPECT_EQ(least_kept, least);
    EXPECT_EQ(largest_kept, largest);
  }
  EXPECT_EQ(k, rows.rows());
}

TEST_F(ReducedLog, H5pyReadsPlainDatasets) {
  EXPECT_TRUE(python(R"(
assert f.attrs['rate_hz'] == 62.5
n, m = len(f['time']), len(f['every_step/time'])
assert 8 * n < m, (n, m)
named = []
def look(name, o):
    if not isinstance(o, h5py.Dataset): return
    for a in ('unit', 'frame', 'description'): assert o.attrs[a], (name, a)
    if name.split('/')[0] not in ('canvas', 'cloud', 'target'):
        named.append(name)
        assert len(o) == (m if name.startswith('every_step/') else n), (name, o.shape)
        o[()]
f.visititems(look)
assert len(named) == 16 + 21 + 9, len(named)
assert np.all(np.diff(f['time'][:]) > 0) and np.allclose(np.diff(f['every_step/time'][:]), 1e-3)
assert f['joint/position'].shape == (n, 7) and f['tip/orientation'].shape == (n, 4)
force = np.nansum(f['contact/force'][:] * f['contact/normal'][:], axis=1)
every = f['every_step/normal_force'][:]
assert force.max() == every.max() and force.min() == every.min()
)",
                     write("run.h5", LogRate::reduced)));
}

TEST_F(ReducedLog, AfterAKillGoesOnAsOneRun) {
  const RunData whole = read_run(write("whole.h5", LogRate::reduced));
  const int n = static_cast<int>(sine().size());
  for (const int rows : {50, 4096, 9001}) {
    SCOPED_TRACE(rows);
    const pid_t child = fork();
    if (child == 0) {
      RunLog log(path("run.h5"), header(LogRate::reduced, {.repeat = 2}));
      for (int i = 0; i < rows; ++i) log.append(sine()[static_cast<std::size_t>(i)]);
      std::this_thread::sleep_for(std::chrono::milliseconds(1000));  // flushed
      kill(getpid(), SIGKILL);
    }
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFSIGNALED(status));

    recover_log(path("run.h5"));
    const RunRows left = read_rows(path("run.h5"));
    const int kept = static_cast<int>(read_run(path("run.h5")).rows());
    EXPECT_GT(kept, rows - 128) << "steps whose row is not settled yet are lost";
    EXPECT_LE(kept, rows);
    const ResumeLog before = read_resume_log(path("run.h5"));
    ASSERT_EQ(static_cast<int>(before.rows.size()), kept);
    if (kept > 0) {
      EXPECT_EQ(before.rows.back().time, left.time.back()) << "rows and steps end together";
      EXPECT_EQ(before.joint_position, sine()[static_cast<std::size_t>(kept - 1)].joint_position);
    }
    for (int i = 0; i < kept; i += 11) {
      const LogRow& row = sine()[static_cast<std::size_t>(i)];
      const ResumeRow& r = before.rows[static_cast<std::size_t>(i)];
      EXPECT_EQ(r.time, row.time);
      EXPECT_EQ(r.stroke, row.stroke);
      EXPECT_EQ(r.mode, row.mode);
      if (row.stroke >= 0) {
        EXPECT_EQ(r.stroke_along, row.stroke_along);
      }
      EXPECT_FLOAT_EQ(r.f, row.wrench_measured.head<3>().dot(row.surface_normal));
    }
    // Whatever rate is asked for now, the log keeps its own.
    RunLog log = RunLog::append_to(path("run.h5"), header(LogRate::full, {.repeat = 2}));
    ASSERT_EQ(log.steps(), kept);
    for (int i = kept; i < n; ++i) log.append(sine()[static_cast<std::size_t>(i)]);
    log.close();
    expect_same_steps(whole, read_run(path("run.h5")));
    const RunRows all = read_rows(path("run.h5"));
    for (std::size_t i = 1; i < all.rows(); ++i) ASSERT_LT(all.time[i - 1], all.time[i]);
    EXPECT_EQ(all.time.back(), sine().back().time);
  }
}

TEST_F(ReducedLog, AFullLogStaysFull) {
  {
    RunLog log(path("run.h5"), header(LogRate::full, {.repeat = 2}));
    for (int i = 0; i < 5000; ++i) log.append(sine()[static_cast<std::size_t>(i)]);
  }
  {
    RunLog log = RunLog::append_to(path("run.h5"), header(LogRate::reduced, {.repeat = 2}));
    for (int i = 5000; i < 9000; ++i) log.append(sine()[static_cast<std::size_t>(i)]);
  }
  EXPECT_EQ(read_rows(path("run.h5")).rows(), 9000u);
  EXPECT_TRUE(python("assert 'every_step' not in f and 'rate_hz' not in f.attrs", path("run.h5")));
}

}  // namespace
}  // namespace impedraw
