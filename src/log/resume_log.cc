#include "impedraw/log/resume_log.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "impedraw/log/log_checks.h"
#include "impedraw/log/log_columns.h"
#include "impedraw/log/log_file.h"
#include "impedraw/log/log_reader.h"

namespace impedraw {

constexpr double kMostTurned = 1e3;  // of a joint [rad]

ResumeLog read_resume_log(const std::filesystem::path& path) {
  const LogReader log(path);
  if (log.cut_short()) log.fail("is cut short, so that the run cannot be continued");
  const bool reduced = log.rate() == LogRate::reduced;
  const std::string steps = reduced ? "/every_step" : "";
  ResumeLog drawn;
  drawn.rows.reserve(log.steps());
  std::vector<double> time, along, felt, push;
  std::vector<int> stroke, mode;
  std::vector<Eigen::Matrix<double, 6, 1>> wrench;
  std::vector<Eigen::Vector3d> normal;
  const auto read = [&](const std::string& name, int width, bool integer, std::size_t begin,
                        std::size_t n, void* out) {
    if (!log.read(name, width, integer, begin, n, out))
      log.fail("dataset " + name + " is broken before its last rows");
  };
  StepChecks checks(log);
  for (std::size_t begin = 0; begin < log.steps(); begin += LogFile::kChunkRows) {
    const std::size_t n = std::min(LogFile::kChunkRows, log.steps() - begin);
    const auto take = [&](const std::string& name, int width, bool integer, void* out) {
      read(name, width, integer, begin, n, out);
    };
    take(steps + "/time", 1, false, (time.resize(n), time.data()));
    take(steps + "/stroke", 1, true, (stroke.resize(n), stroke.data()));
    take(steps + "/stroke_along", 1, false, (along.resize(n), along.data()));
    take(steps + "/push", 1, false, (push.resize(n), push.data()));
    take(steps + "/mode", 1, true, (mode.resize(n), mode.data()));
    felt.resize(n);
    if (reduced) {
      take(steps + "/felt_force", 1, false, felt.data());
    } else {
      take("/wrench/measured", 6, false, (wrench.resize(n), wrench.data()));
      take("/surface/normal", 3, false, (normal.resize(n), normal.data()));
      for (std::size_t i = 0; i < n; ++i) felt[i] = wrench[i].head<3>().dot(normal[i]);
    }
    checks.times(time);
    checks.strokes(stroke);
    checks.modes(mode);
    checks.alongs(along, stroke);
    checks.next(n);
    for (std::size_t i = 0; i < n; ++i)
      drawn.rows.push_back({time[i], along[i], felt[i], push[i], stroke[i], mode[i]});
  }
  if (log.rows() > 0) {
    drawn.joint_position.resize(log.joints());
    read("/joint/position", log.joints(), false, log.rows() - 1, 1, drawn.joint_position.data());
    if (!(drawn.joint_position.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= kMostTurned))
      log.fail(fmt::format("dataset /joint/position: row {} is not finite or beyond ± {:g} rad",
                           log.rows() - 1, kMostTurned));
    if (log.header().moving_canvas) {
      Eigen::Matrix<double, 7, 1> x;  // position, quaternion w x y z
      read(kEstimatedCanvasPoseColumn, 7, false, log.rows() - 1, 1, x.data());
      const Eigen::Quaterniond R(x[3], x[4], x[5], x[6]);
      if (!(x.allFinite() && std::abs(R.norm() - 1.0) < 1e-3))
        log.fail(fmt::format("dataset {}: row {} is no pose", kEstimatedCanvasPoseColumn,
                             log.rows() - 1));
      drawn.canvas_pose = {x.head<3>(), R.normalized().toRotationMatrix()};
    }
  }
  return drawn;
}

}  // namespace impedraw
