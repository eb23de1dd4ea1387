#include "impedraw/log/run_data.h"

#include <algorithm>
#include <cmath>

#include "impedraw/ink/ink_lines.h"
#include "impedraw/log/log_file.h"
#include "impedraw/log/log_reader.h"

namespace impedraw {
namespace {

RunConstants constants(const LogReader& log) {
  RunConstants c;
  const RunLogHeader& header = log.header();
  c.joint_names = header.joint_names;
  c.mode_names = header.mode_names;
  c.joint_lower = header.joint_lower;
  c.joint_upper = header.joint_upper;
  c.torque_limit = header.torque_limit;
  c.canvas_vertices = log.points("/canvas/vertices");
  c.canvas_triangles = log.triples("/canvas/triangles");
  c.cloud_points = log.points("/cloud/points");
  c.target_points = log.points("/target/points");
  c.target_stroke = log.integers("/target/stroke");
  if (c.target_stroke.size() != c.target_points.size())
    log.fail("/target/points and /target/stroke differ in length");
  c.wall = log.wall();
  c.attributes = header.attributes;
  return c;
}

void reserve(RunData* run, std::size_t n) {
  for (auto* column :
       {&run->time, &run->f, &run->tilt, &run->normal_error, &run->push, &run->step_time})
    column->reserve(n);
  run->contact_point.reserve(n);
  run->torque_share.reserve(n);
  run->stroke.reserve(n);
  run->mode.reserve(n);
}

}  // namespace

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

void add_rows(const RunRows& rows, RunData* run) {
  const std::size_t n = rows.rows();
  if (n == 0) return;
  const auto append = [](const auto& from, auto& to) {
    to.insert(to.end(), from.begin(), from.end());
  };
  append(rows.time, run->time);
  append(rows.contact_point, run->contact_point);
  append(rows.push, run->push);
  append(rows.step_time, run->step_time);
  append(rows.stroke, run->stroke);
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3d& normal = rows.contact_normal[i];
    const double f = rows.contact_force[i].dot(normal);
    run->f.push_back(std::isfinite(f) ? f : 0.0);
    const bool pen_down_ink = rows.stroke[i] >= 0 && is_ink(run->f.back());
    const bool estimate =
        std::isfinite(rows.surface_distance[i]) && rows.surface_normal[i].allFinite();
    run->tilt.push_back(
        pen_down_ink ? angle_between(-(rows.tip_orientation[i] * Eigen::Vector3d::UnitZ()), normal)
                     : LogRow::kNone);
    run->normal_error.push_back(
        pen_down_ink && estimate ? angle_between(rows.surface_normal[i], normal) : LogRow::kNone);
    run->mode.push_back(static_cast<std::int8_t>(rows.mode[i]));
    const auto torque = rows.joint_torque.row(static_cast<Eigen::Index>(i)).transpose().array();
    run->torque_share.push_back(
        static_cast<float>((torque.abs() / run->torque_limit.array()).maxCoeff()));
  }
  const Eigen::RowVectorXd lower = run->joint_lower.transpose(),
                           upper = run->joint_upper.transpose();
  const double above = (rows.joint_position.rowwise() - lower).minCoeff(),
               below = (-(rows.joint_position.rowwise() - upper)).minCoeff();
  run->joint_margin = std::min({run->joint_margin, above, below});
  if (rows.torque_before_limits.rows() != static_cast<Eigen::Index>(n)) return;
  const auto desired = rows.torque_before_limits.array();
  const auto clipped =
      ((desired - rows.joint_torque.array()).abs() > 1e-9 * desired.abs().max(1.0)).rowwise().any();
  run->clipped = run->clipped.value_or(0) + static_cast<std::size_t>(clipped.count());
}

RunData read_run(const std::filesystem::path& path) {
  const LogReader log(path);
  try {
    RunData run;
    static_cast<RunConstants&>(run) = constants(log);
    reserve(&run, log.rows());
    RunRows chunk;
    for (std::size_t begin = 0; begin < log.rows(); begin += LogFile::kChunkRows) {
      const std::size_t n = std::min(LogFile::kChunkRows, log.rows() - begin);
      if (!read_rows(log, begin, n, Columns::of_results, &chunk)) break;  // broken from here on
      add_rows(chunk, &run);
    }
    return run;
  } catch (const h5::Error& e) {
    log.fail(e.what());
  }
}

}  // namespace impedraw
