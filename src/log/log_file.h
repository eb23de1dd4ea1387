// run.h5 on the disk: its datasets, written chunk by chunk so that the file stays readable whatever
// happens to the process. Private to src/log; the thread and the ring of rows are in log.cc.
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

// A log's rows, and of a reduced one every step. Each is a set of datasets of equal length.
enum class LogTable { rows, steps };

// Chunks are compressed here (shuffle, deflate 1) and handed to HDF5 ready made. Metadata reaches
// the disk in flush() alone, raw data at once and always into fresh space: a kill between two
// flushes leaves the file exactly as the first of them wrote it. In a flush the tables' times come
// after all else: rows that have their time are whole, wherever in a flush the kill comes.
class LogFile {
 public:
  static constexpr std::size_t kChunkRows = 4096;
  // Rows of a reduced log come 12 times as slowly; a part of a chunk is written at every flush, and
  // its space is not used again.
  static constexpr std::size_t kReducedChunkRows = 256;
  static constexpr std::size_t chunk_rows(LogTable table, LogRate rate) {
    return table == LogTable::rows && rate == LogRate::reduced ? kReducedChunkRows : kChunkRows;
  }

  LogFile(const std::filesystem::path& path,
          const RunLogHeader& header);  // makes the file; throws h5::Error
  // Opens one that a run of the same header and rate left, and keeps the first rows of its tables;
  // its wall times are taken out until close().
  LogFile(const std::filesystem::path& path, const RunLogHeader& header,
          const std::vector<std::size_t>& rows);
  ~LogFile();

  void resize(LogTable table, std::size_t rows);  // all its datasets
  // Writes rows [chunk · chunk_rows, + rows) of column `c`; a chunk that was not full may be
  // written again.
  void write_chunk(LogTable table, std::size_t c, std::size_t chunk, const std::byte* data,
                   std::size_t rows);
  void flush();
  void close(const WallTimes& wall);  // the times are added to those of the runs before
  // After an error: lets go without touching the file again. (HDF5's own close would write metadata
  // that refers to data that is not there.)
  void abandon();

 private:
  struct Table {
    std::vector<LogColumn> columns;  // the first is the time
    std::size_t chunk_rows;
    std::vector<h5::Id> datasets{};
    std::size_t rows = 0;
    // chunks of the time until the next flush
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
  std::vector<Table> tables_;  // in the order of LogTable; of a full log the first alone
  WallTimes before_{0.0, 0.0, 0.0};
  std::vector<std::byte> padded_, shuffled_, deflated_;
};

}  // namespace impedraw
