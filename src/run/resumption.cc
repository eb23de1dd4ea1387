// The place where an earlier run into the same log left off (run.h).
#include <cmath>
#include <limits>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/log/resume_log.h"
#include "impedraw/run/run.h"

namespace impedraw {

std::optional<Resumption> read_resumption(const Experiment& e,
                                          const std::filesystem::path& log_file) {
  const ResumeLog before = read_resume_log(log_file);
  if (before.rows.empty()) return std::nullopt;
  if (before.joint_position.size() != e.belief.arm.joints())
    throw InputError(fmt::format("{}: is of an arm with {} joints, this one has {}",
                                 log_file.string(), before.joint_position.size(),
                                 e.belief.arm.joints()));
  Resumption resumption;
  for (const ResumeRow& row : before.rows) {
    if (row.stroke >= static_cast<int>(e.plan.strokes.size()))
      throw InputError(fmt::format("{}: has a stroke {}, the drawing only {}", log_file.string(),
                                   row.stroke, e.plan.strokes.size()));
    // Blind, the log has no normal to project the force on. Assume that the pen wrote.
    const double force = !e.belief.estimates_surface() && std::isnan(row.f)
                             ? std::numeric_limits<double>::infinity()
                             : row.f;
    resumption.ink.add(row.stroke, row.stroke_along,
                       writes(e, static_cast<ContactMode>(row.mode), force, row.push));
  }
  resumption.q = before.joint_position;
  resumption.X_WK = before.canvas_pose;
  resumption.time = before.rows.back().time + e.control.impedance.timing.dt;
  return resumption;
}

}  // namespace impedraw
