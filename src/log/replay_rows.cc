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

}  // namespace impedraw
