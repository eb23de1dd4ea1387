#include "impedraw/log/resume_log.h"

#include <cmath>

#include <fmt/format.h>

#include "impedraw/log/log_checks.h"
#include "impedraw/log/log_columns.h"
#include "impedraw/log/log_reader.h"

namespace impedraw {

constexpr double kMostTurned = 1e3;  // of a joint [rad]

ResumeLog read_resume_log(const std::filesystem::path& path) {
  const LogReader log(path);
  if (log.cut_short()) log.fail("is cut short, so that the run cannot be continued");
  ResumeLog drawn;
  drawn.rows.reserve(log.steps());
  const bool whole = visit_steps(log, [&](const LogStep& step) {
    require_along(log, step, drawn.rows.size());
    drawn.rows.push_back(
        {step.time, step.stroke_along, step.felt_force, step.push, step.stroke, step.mode});
  });
  if (!whole) log.fail("is broken before its last rows");
  const auto read_last = [&log](const std::string& name, auto& out) {
    if (!log.read(name, static_cast<int>(out.size()), false, log.rows() - 1, 1, out.data()))
      log.fail("dataset " + name + " is broken before its last rows");
  };
  if (log.rows() > 0) {
    drawn.joint_position.resize(log.joints());
    read_last("/joint/position", drawn.joint_position);
    if (!(drawn.joint_position.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= kMostTurned))
      log.fail(fmt::format("dataset /joint/position: row {} is not finite or beyond ± {:g} rad",
                           log.rows() - 1, kMostTurned));
    if (log.header().moving_canvas) {
      Eigen::Matrix<double, 7, 1> x;  // position, quaternion w x y z
      read_last(kEstimatedCanvasPoseColumn, x);
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
