#include "impedraw/log/run_rows.h"

#include "impedraw/log/log_columns.h"
#include "impedraw/log/log_reader.h"

namespace impedraw {

ReplayLog::ReplayLog(const std::filesystem::path& path) : log_(std::make_unique<LogReader>(path)) {}
ReplayLog::~ReplayLog() = default;

std::size_t ReplayLog::rows() const { return log_->rows(); }
int ReplayLog::joints() const { return log_->joints(); }
const std::vector<std::string>& ReplayLog::torque_terms() const {
  return log_->header().torque_terms;
}
bool ReplayLog::canvas_moves() const { return log_->header().moving_canvas; }
bool ReplayLog::cut_short() const { return log_->cut_short(); }

bool ReplayLog::read(std::size_t begin, std::size_t n, ReplayRows* rows) const {
  RowBlock block(*log_, begin, n);
  block.read("/time", &rows->time);
  block.read("/joint/position", &rows->joint_position);
  block.read("/joint/velocity", &rows->joint_velocity);
  block.read("/joint/torque", &rows->joint_torque);
  rows->torque_terms.resize(torque_terms().size());
  for (std::size_t k = 0; k < torque_terms().size(); ++k)
    block.read("/torque/" + torque_terms()[k], &rows->torque_terms[k]);
  block.read("/tip/position", &rows->tip_position);
  block.read("/tip/orientation", &rows->tip_orientation);
  block.read("/contact/force", &rows->contact_force);
  block.read("/surface/normal", &rows->surface_normal);
  if (canvas_moves()) {
    block.read(kCanvasPoseColumn, &rows->canvas_pose);
    block.read(kEstimatedCanvasPoseColumn, &rows->estimated_canvas_pose);
  }
  block.read("/surface/distance", &rows->surface_distance);
  block.read("/mode", &rows->mode);
  block.read("/stroke", &rows->stroke);
  return block.whole();
}

bool read_rows(const LogReader& log, std::size_t begin, std::size_t n, Columns columns,
               RunRows* rows) {
  RowBlock block(log, begin, n);
  block.read("/time", &rows->time);
  block.read("/joint/position", &rows->joint_position);
  block.read("/joint/velocity", &rows->joint_velocity);
  block.read("/joint/torque", &rows->joint_torque);
  rows->torque_before_limits.resize(0, log.joints());
  RunRows::Joints term;
  for (const std::string& name : log.header().torque_terms) {
    block.read("/torque/" + name, &term);
    if (rows->torque_before_limits.rows() == 0) {
      rows->torque_before_limits = term;
    } else {
      rows->torque_before_limits += term;
    }
  }
  std::vector<Eigen::Vector4d> wxyz;
  block.read("/tip/orientation", &wxyz);
  rows->tip_orientation.clear();
  for (const Eigen::Vector4d& q : wxyz) rows->tip_orientation.emplace_back(q[0], q[1], q[2], q[3]);
  block.read("/contact/force", &rows->contact_force);
  block.read("/contact/point", &rows->contact_point);
  block.read("/contact/normal", &rows->contact_normal);
  if (log.has(kCanvasPoseColumn)) {
    std::vector<Eigen::Matrix<double, 7, 1>> pose;
    block.read(kCanvasPoseColumn, &pose);
    for (std::size_t i = 0; i < n; ++i)
      rows->contact_normal[i] =
          Eigen::Quaterniond(pose[i][3], pose[i][4], pose[i][5], pose[i][6]).toRotationMatrix() *
          rows->contact_normal[i];
  }
  block.read("/surface/normal", &rows->surface_normal);
  block.read("/surface/distance", &rows->surface_distance);
  block.read("/push", &rows->push);
  block.read("/mode", &rows->mode);
  block.read("/stroke", &rows->stroke);
  block.read("/controller/step_time", &rows->step_time);
  if (log.has("/time_scale")) {
    block.read("/time_scale", &rows->time_scale);
  } else {
    rows->time_scale.assign(n, 1.0);
  }
  block.read("/tip/position", &rows->tip_position);
  block.read("/desired/position", &rows->desired_position);
  if (log.has("/stroke_along")) {
    block.read("/stroke_along", &rows->stroke_along);
  } else {
    rows->stroke_along.assign(n, LogRow::kNone);
  }
  if (columns == Columns::of_results) return block.whole();

  block.read("/disturbance/force", &rows->disturbance_force);
  return block.whole();
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
    take(i, "/mode", 1, true, &row.mode);
    if (log.has("/stroke_along")) take(i, "/stroke_along", 1, false, &row.stroke_along);
    take(i, measured, joints, false, row.measured_position.data());
    take(i, "/tip/position", 3, false, row.tip_position.data());
    take(i, "/tip/orientation", 4, false, wxyz);
    row.tip_orientation = Eigen::Quaterniond(wxyz[0], wxyz[1], wxyz[2], wxyz[3]);
    take(i, "/contact/force", 3, false, row.contact_force.data());
    take(i, "/contact/point", 3, false, row.contact_point.data());
    take(i, "/contact/normal", 3, false, row.contact_normal.data());
    take(i, "/wrench/measured", 6, false, row.wrench_measured.data());
    take(i, "/surface/normal", 3, false, row.surface_normal.data());
    take(i, "/push", 1, false, &row.push);
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
