#include "impedraw/log/resume_log.h"

#include <algorithm>

#include "impedraw/log/log_file.h"
#include "impedraw/log/log_reader.h"

namespace impedraw {

ResumeLog read_resume_log(const std::filesystem::path& path) {
  const LogReader log(path);
  ResumeLog drawn;
  drawn.rows.reserve(log.rows());
  std::vector<double> time, along;
  std::vector<int> stroke, mode;
  std::vector<Eigen::Matrix<double, 6, 1>> wrench;
  std::vector<Eigen::Vector3d> normal;
  Eigen::MatrixXd position;  // a column a row
  for (std::size_t begin = 0; begin < log.rows(); begin += LogFile::kChunkRows) {
    const std::size_t n = std::min(LogFile::kChunkRows, log.rows() - begin);
    const auto read = [&](const char* name, int width, bool integer, void* out) {
      if (!log.read(name, width, integer, begin, n, out))
        log.fail(std::string("dataset ") + name + " is broken before its last rows");
    };
    read("/time", 1, false, (time.resize(n), time.data()));
    read("/stroke", 1, true, (stroke.resize(n), stroke.data()));
    read("/stroke_along", 1, false, (along.resize(n), along.data()));
    read("/mode", 1, true, (mode.resize(n), mode.data()));
    read("/wrench/measured", 6, false, (wrench.resize(n), wrench.data()));
    read("/surface/normal", 3, false, (normal.resize(n), normal.data()));
    for (std::size_t i = 0; i < n; ++i)
      drawn.rows.push_back(
          {time[i], along[i], wrench[i].head<3>().dot(normal[i]), stroke[i], mode[i]});
    if (begin + n < log.rows()) continue;
    read("/joint/position", log.joints(), false,
         (position.resize(log.joints(), static_cast<Eigen::Index>(n)), position.data()));
    drawn.joint_position = position.rightCols<1>();
  }
  return drawn;
}

}  // namespace impedraw
