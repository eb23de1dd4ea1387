// Reads run.h5 in blocks of rows, so that a long log need not fit into memory. Private to src/log.
//
// In the log of a killed run, some datasets may lack rows or may be extended but not written.
// rows() counts the rows that are complete in every dataset; later ones are ignored. The rows and
// steps of a reduced log end at the same time. So it is with a file that lost its end, in a copy
// for instance, as long as what does not grow is there.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "impedraw/log/h5.h"
#include "impedraw/log/log.h"
#include "impedraw/log/log_columns.h"

namespace impedraw {

class LogReader {
 public:
  // Throws InputError naming the file, and the dataset if one that grows with the run is missing or
  // has the wrong shape. (Logs of older versions may lack /stroke_along
  // and /every_step/joint_speed_share.)
  explicit LogReader(const std::filesystem::path& path);

  [[noreturn]] void fail(const std::string& what) const;  // InputError "<path>: <what>"

  // Joint and mode names, limits, torque terms (in alphabetical order) and text attributes. Canvas,
  // cloud and target are empty.
  const RunLogHeader& header() const { return header_; }
  int joints() const { return static_cast<int>(header_.joint_lower.size()); }
  LogRate rate() const { return header_.rate; }
  std::size_t rows() const { return rows_; }
  std::size_t steps() const { return rate() == LogRate::full ? rows_ : steps_; }
  double joint_margin() const;       // reduced log: smallest over all steps; inf without steps
  double joint_speed_share() const;  // the same: largest; NaN without steps or limits
  WallTimes wall() const;
  double log_id() const;  // changes whenever the log is written; 0 in logs of older versions

  // The file is shorter than it says it is; what is missing counts as rows that cannot be read.
  bool cut_short() const { return missing_ > 0; }

  // Throws InputError naming what differs between `header` and this log, or that it is cut short.
  void require(const RunLogHeader& header) const;

  bool has(const std::string& name) const {
    return H5Lexists(file_, name.c_str(), H5P_DEFAULT) > 0;
  }

  // Reads rows [begin, begin + n) into `out`, n×width. Also works for datasets that do not grow.
  // Returns false if the rows exist but cannot be read. Throws InputError if the dataset is missing
  // or has another width.
  bool read(const std::string& name, int width, bool integer, std::size_t begin, std::size_t n,
            void* out) const;
  bool read(const LogColumn& column, std::size_t begin, std::size_t n, void* out) const {
    return read(column.name, column.width, column.integer, begin, n, out);
  }

  // Read a whole dataset that does not grow with the run.
  std::vector<Eigen::Vector3d> points(const std::string& name) const;
  std::vector<Eigen::Vector3i> triples(const std::string& name) const;
  std::vector<int> integers(const std::string& name) const;

 private:
  struct Dataset {
    h5::Id id;
    std::size_t rows = 0;
    int width = 1;
  };
  void require_own(const std::string& name) const;
  hsize_t require_plain(const h5::Id& dataset, const std::string& name) const;
  const Dataset& open(const std::string& name) const;
  const Dataset& open(const std::string& name, int width) const;
  std::size_t written_rows(const Dataset& dataset, std::size_t chunk, std::size_t rows) const;
  std::size_t count_rows(const std::vector<LogColumn>& columns, std::size_t chunk) const;
  std::size_t rows_until(const std::string& name, std::size_t rows, double time) const;
  double number_at(const std::string& name, std::size_t row) const;
  template <typename T>
  std::vector<T> whole(const std::string& name, int width, bool integer) const;

  std::filesystem::path path_;
  std::size_t missing_ = 0;  // [bytes]
  h5::Id file_;
  mutable std::map<std::string, Dataset> datasets_;  // already opened
  RunLogHeader header_;
  std::size_t rows_ = 0, steps_ = 0;
};

// Hands over the steps of a log, one after the other, and checks them (StepChecks): those of a
// reduced log as it has them, else as LogSteps measures the rows, with the step's time and the felt
// force to full precision. Returns false if they exist but cannot be read.
bool visit_steps(const LogReader& log, const std::function<void(const LogStep&)>& visit);

}  // namespace impedraw
