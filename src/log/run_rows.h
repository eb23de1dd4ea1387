// The rows of run.h5. A reduced log has rows for selected steps only. For whole long runs use
// RunData, which takes a sixth of the memory.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "impedraw/log/log.h"

namespace impedraw {

class LogReader;

// The rows of run.h5 and what a replay asks of them. They are read block by block, so that a long
// log need not fit into memory.
class ReplayLog {
 public:
  // Throws InputError as visit_rows().
  explicit ReplayLog(const std::filesystem::path& path);
  ~ReplayLog();

  std::size_t rows() const;  // that are complete in every dataset
  int joints() const;
  const std::vector<std::string>& torque_terms() const;
  bool canvas_moves() const;
  bool cut_short() const;  // rows() are what is left of a file that lost its end

  // Hands over the rows, one after the other. Returns false if they exist but cannot be read.
  bool visit(const std::function<void(const LogRow&)>& visit) const;

 private:
  std::unique_ptr<LogReader> log_;
};

// Hands over the rows of a log, one after the other; without a sensor of the joints, the measured
// positions are the true ones. Throws InputError naming the file and the dataset if the file is no
// log, lacks a dataset, or has one of the wrong shape, or if rows cannot be read. The log of a
// killed run is read up to the last row that is complete in every dataset.
void visit_rows(const std::filesystem::path& path, const std::function<void(const LogRow&)>& visit);

}  // namespace impedraw
