// run.h5 on the disk: its datasets, written chunk by chunk so that the file stays readable whatever
// happens to the process. Private to src/report; the thread and the ring of rows are in log.cc.
#pragma once

#include <cstddef>
#include <filesystem>
#include <memory>
#include <utility>
#include <vector>

#include "impedraw/log/h5.h"
#include "impedraw/log/log.h"
#include "impedraw/log/log_columns.h"

namespace impedraw {

// Chunks are compressed here (shuffle, deflate 1) and handed to HDF5 ready made. Metadata reaches
// the disk in flush() alone, raw data at once and always into fresh space: a kill between two
// flushes leaves the file exactly as the first of them wrote it. In a flush /time comes after all
// others: rows that have their time are whole, wherever in a flush the kill comes.
class LogFile {
 public:
  static constexpr std::size_t kChunkRows = 4096;

  LogFile(const std::filesystem::path& path,
          const RunLogHeader& header);  // makes the file; throws h5::Error
  // Opens one that a run of the same header left, and keeps its first `rows` rows; its wall times
  // are taken out until close().
  LogFile(const std::filesystem::path& path, const RunLogHeader& header, std::size_t rows);
  ~LogFile();

  void resize(std::size_t rows);  // of every dataset
  // Writes rows [chunk·kChunkRows, + rows) of column `c`; a chunk that was not full may be written
  // again.
  void write_chunk(std::size_t c, std::size_t chunk, const std::byte* data, std::size_t rows);
  void flush();
  void close(const WallTimes& wall);  // the times are added to those of the runs before
  // After an error: lets go without touching the file again. (HDF5's own close would write metadata
  // that refers to data that is not there.)
  void abandon();

 private:
  void make_room();
  void resize_one(std::size_t c, std::size_t rows);
  void put_chunk(std::size_t c, std::size_t chunk, const std::byte* data, std::size_t rows);
  void write_static(const RunLogHeader& header);
  std::size_t deflate_planes(std::size_t values, std::size_t size);

  struct Deflater;
  std::unique_ptr<Deflater> deflater_;
  h5::Id file_;
  std::vector<LogColumn> columns_;
  WallTimes before_{0.0, 0.0, 0.0};
  std::size_t rows_ = 0;
  std::vector<std::pair<std::size_t, std::vector<std::byte>>>
      held_back_;  // chunks of /time until the next flush
  std::vector<h5::Id> datasets_;
  std::vector<std::byte> padded_, shuffled_, deflated_;
};

}  // namespace impedraw
