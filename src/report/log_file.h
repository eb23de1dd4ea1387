// run.h5 on the disk: its datasets, written chunk by chunk so that the file stays readable whatever happens to the process.
// Private to src/report; the thread and the ring of rows are in log.cc.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <vector>

#include "report/h5.h"
#include "report/log.h"
#include "report/log_columns.h"

namespace impedraw {

// Chunks are compressed here (shuffle, deflate 1) and handed to HDF5 ready made. Metadata reaches the disk in flush() alone, raw data at
// once and always into fresh space: a kill between two flushes leaves the file exactly as the first of them wrote it.
class LogFile {
 public:
  static constexpr std::size_t kChunkRows = 4096;

  LogFile(const std::filesystem::path& path, const RunLogHeader& header);  // throws h5::Error
  ~LogFile();

  const std::vector<LogColumn>& columns() const { return columns_; }
  void resize(std::size_t rows);  // of every dataset
  // Writes rows [chunk·kChunkRows, + rows) of column `c`; a chunk that was not full may be written again.
  void write_chunk(std::size_t c, std::size_t chunk, const std::byte* data, std::size_t rows);
  void flush();
  void close(const WallTimes& wall);
  // After an error: lets go without touching the file again. (HDF5's own close would write metadata that refers to data that is not there.)
  void abandon();

 private:
  void write_static(const RunLogHeader& header);
  std::size_t deflate_planes(std::size_t values, std::size_t size);

  struct Deflater;
  std::unique_ptr<Deflater> deflater_;
  h5::Id file_;
  std::vector<LogColumn> columns_;
  std::vector<h5::Id> datasets_;
  std::vector<std::byte> padded_, shuffled_, deflated_;
};

}  // namespace impedraw
