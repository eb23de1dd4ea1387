#include "impedraw/log/replay_rows.h"

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
bool ReplayLog::reduced() const { return log_->rate() == LogRate::reduced; }

bool ReplayLog::read(std::size_t begin, std::size_t n, ReplayRows* rows) const {
  const int j = joints();
  bool whole = true;
  const auto take = [&](const std::string& name, int width, bool integer, void* out) {
    whole = whole && log_->read(name, width, integer, begin, n, out);
  };
  const auto column = [&](const std::string& name, int width, bool integer, auto& out) {
    out.resize(n);
    take(name, width, integer, out.data());
  };
  const auto joint_column = [&](const std::string& name, ReplayRows::Joints& out) {
    out.resize(static_cast<Eigen::Index>(n), j);
    take(name, j, false, out.data());
  };
  column("/time", 1, false, rows->time);
  joint_column("/joint/position", rows->joint_position);
  joint_column("/joint/velocity", rows->joint_velocity);
  joint_column("/joint/torque", rows->joint_torque);
  rows->torque_terms.resize(torque_terms().size());
  for (std::size_t k = 0; k < torque_terms().size(); ++k)
    joint_column("/torque/" + torque_terms()[k], rows->torque_terms[k]);
  column("/tip/position", 3, false, rows->tip_position);
  column("/tip/orientation", 4, false, rows->tip_orientation);
  column("/contact/force", 3, false, rows->contact_force);
  column("/surface/normal", 3, false, rows->surface_normal);
  if (canvas_moves()) {
    column(kCanvasPoseColumn, 7, false, rows->canvas_pose);
    column(kEstimatedCanvasPoseColumn, 7, false, rows->estimated_canvas_pose);
  }
  column("/surface/distance", 1, false, rows->surface_distance);
  column("/mode", 1, true, rows->mode);
  column("/stroke", 1, true, rows->stroke);
  return whole;
}

}  // namespace impedraw
