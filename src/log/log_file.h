// run.h5 on disk. Datasets are written chunk by chunk, so the file stays readable even if the
// process is killed. Private to src/log. The writer thread and the ring of rows are in log.cc.
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

// A log's rows and, in a reduced log, its steps. Each table is a set of datasets of equal length.
enum class LogTable { rows, steps };

// This class compresses chunks itself (shuffle, deflate 1) and passes them to HDF5 as raw chunks.
// Metadata reaches the disk only in flush(). Raw data reaches it at once and always in fresh space.
// A kill between two flushes therefore leaves the file as the first flush wrote it. A flush writes
// the tables' times last, so rows that have a time are complete even if the kill comes during a
// flush.
class LogFile {
 public:
  static constexpr std::size_t kChunkRows = 4096;
  // Rows of a reduced log arrive 12 times more slowly. Each flush writes a partial chunk, whose
  // space is not reused.
  static constexpr std::size_t kReducedChunkRows = 256;
  static constexpr std::size_t chunk_rows(LogTable table, LogRate rate) {
    return table == LogTable::rows && rate == LogRate::reduced ? kReducedChunkRows : kChunkRows;
  }

  LogFile(const std::filesystem::path& path,
          const RunLogHeader& header);  // creates the file; throws h5::Error
  // Opens the file of an earlier run with the same header and rate, and keeps the first `rows` of
  // each table. Its wall times are removed until close().
  LogFile(const std::filesystem::path& path, const RunLogHeader& header,
          const std::vector<std::size_t>& rows);
  ~LogFile();

  void resize(LogTable table, std::size_t rows);  // resizes all datasets of the table
  // Writes rows [chunk · chunk_rows, + rows) of column `c`. A partial chunk may be written again.
  void write_chunk(LogTable table, std::size_t c, std::size_t chunk, const std::byte* data,
                   std::size_t rows);
  void flush();
  void close(const WallTimes& wall);  // adds the times to those of the earlier runs
  // Releases the file after an error without touching it again. (HDF5's own close would write
  // metadata that refers to missing data.)
  void abandon();

 private:
  struct Table {
    std::vector<LogColumn> columns;  // the first is the time
    std::size_t chunk_rows;
    std::vector<h5::Id> datasets{};
    std::size_t rows = 0;
    // chunks of the time column, held back until the next flush
    std::vector<std::pair<std::size_t, std::vector<std::byte>>> held_back{};
  };

  void make_tables(const RunLogHeader& header);
  void create_datasets(Table& table, const RunLogHeader& header);
  Table& at(LogTable table) { return tables_[static_cast<std::size_t>(table)]; }
  void resize_one(Table& table, std::size_t c, std::size_t rows);
  void put_chunk(Table& table, std::size_t c, std::size_t chunk, const std::byte* data,
                 std::size_t rows);
  void write_static(const RunLogHeader& header);
  std::size_t deflate_planes(std::size_t values, std::size_t size);

  struct Deflater;
  std::unique_ptr<Deflater> deflater_;
  h5::Id file_;
  std::vector<Table> tables_;  // in the order of LogTable; a full log has only the first
  WallTimes before_{0.0, 0.0, 0.0};
  std::vector<std::byte> padded_, shuffled_, deflated_;
};

}  // namespace impedraw
