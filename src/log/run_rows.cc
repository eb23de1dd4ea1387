#include "impedraw/log/run_rows.h"

#include "impedraw/log/log_columns.h"
#include "impedraw/log/log_reader.h"

namespace impedraw {

bool read_rows(const LogReader& log, std::size_t begin, std::size_t n, Columns columns,
               RunRows* rows) {
  bool whole = true;
  const auto take = [&](const std::string& name, int width, bool integer, void* out) {
    whole = whole && log.read(name, width, integer, begin, n, out);
  };
  const auto numbers = [&](const char* name, std::vector<double>& out) {
    take(name, 1, false, (out.resize(n), out.data()));
  };
  const auto integers = [&](const char* name, std::vector<int>& out) {
    take(name, 1, true, (out.resize(n), out.data()));
  };
  const auto points = [&](const char* name, RunRows::Points& out) {
    take(name, 3, false, (out.resize(n), out.data()));
  };
  const int j = log.joints();
  const auto joints = [&](const std::string& name, RunRows::Joints& out) {
    take(name, j, false, (out.resize(static_cast<Eigen::Index>(n), j), out.data()));
  };

  numbers("/time", rows->time);
  joints("/joint/position", rows->joint_position);
  joints("/joint/velocity", rows->joint_velocity);
  joints("/joint/torque", rows->joint_torque);
  rows->torque_before_limits.resize(0, j);
  RunRows::Joints term;
  for (const std::string& name : log.header().torque_terms) {
    joints("/torque/" + name, term);
    if (rows->torque_before_limits.rows() == 0) {
      rows->torque_before_limits = term;
    } else {
      rows->torque_before_limits += term;
    }
  }
  std::vector<Eigen::Vector4d> wxyz(n);
  take("/tip/orientation", 4, false, wxyz.data());
  rows->tip_orientation.clear();
  for (const Eigen::Vector4d& q : wxyz) rows->tip_orientation.emplace_back(q[0], q[1], q[2], q[3]);
  points("/contact/force", rows->contact_force);
  points("/contact/point", rows->contact_point);
  points("/contact/normal", rows->contact_normal);
  if (log.has(kCanvasPoseColumn)) {
    std::vector<Eigen::Matrix<double, 7, 1>> pose(n);
    take(kCanvasPoseColumn, 7, false, pose.data());
    for (std::size_t i = 0; i < n; ++i)
      rows->contact_normal[i] =
          Eigen::Quaterniond(pose[i][3], pose[i][4], pose[i][5], pose[i][6]).toRotationMatrix() *
          rows->contact_normal[i];
  }
  points("/surface/normal", rows->surface_normal);
  numbers("/surface/distance", rows->surface_distance);
  numbers("/push", rows->push);
  integers("/mode", rows->mode);
  integers("/stroke", rows->stroke);
  numbers("/controller/step_time", rows->step_time);
  if (log.has("/time_scale")) {
    numbers("/time_scale", rows->time_scale);
  } else {
    rows->time_scale.assign(n, 1.0);
  }
  points("/tip/position", rows->tip_position);
  points("/desired/position", rows->desired_position);
  if (log.has("/stroke_along")) {
    numbers("/stroke_along", rows->stroke_along);
  } else {
    rows->stroke_along.assign(n, LogRow::kNone);
  }
  if (columns == Columns::of_results) return whole;

  points("/disturbance/force", rows->disturbance_force);
  return whole;
}

RunRows read_rows(const std::filesystem::path& path) {
  const LogReader log(path);
  RunRows rows;
  if (!read_rows(log, 0, log.rows(), Columns::all, &rows))
    log.fail("cannot be read: broken before its last rows");
  return rows;
}

void visit_rows(const std::filesystem::path& path,
                const std::function<void(const LogRow&)>& visit) {
  const LogReader log(path);
  const int joints = log.joints();
  LogRow row(joints);
  const auto take = [&](std::size_t i, const std::string& name, int width, bool integer,
                        void* out) {
    if (!log.read(name, width, integer, i, 1, out)) log.fail(name + ": rows cannot be read");
  };
  const char* const measured =
      log.header().joint_sensor ? "/joint/measured_position" : "/joint/position";
  for (std::size_t i = 0; i < log.rows(); ++i) {
    double wxyz[4], pose[7];
    take(i, "/time", 1, false, &row.time);
    take(i, "/stroke", 1, true, &row.stroke);
    take(i, measured, joints, false, row.measured_position.data());
    take(i, "/tip/position", 3, false, row.tip_position.data());
    take(i, "/tip/orientation", 4, false, wxyz);
    row.tip_orientation = Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    take(i, "/contact/force", 3, false, row.contact_force.data());
    take(i, "/contact/normal", 3, false, row.contact_normal.data());
    take(i, "/wrench/measured", 6, false, row.wrench_measured.data());
    take(i, "/surface/normal", 3, false, row.surface_normal.data());
    for (const auto& [name, X] :
         {std::pair(kCanvasPoseColumn, &row.canvas_pose),
          std::pair(kEstimatedCanvasPoseColumn, &row.estimated_canvas_pose)}) {
      if (!log.has(name)) continue;
      take(i, name, 7, false, pose);
      *X = {{pose[0], pose[1], pose[2]},
            Eigen::Quaterniond(pose[3], pose[4], pose[5], pose[6]).toRotationMatrix()};
    }
    visit(row);
  }
}

}  // namespace impedraw
