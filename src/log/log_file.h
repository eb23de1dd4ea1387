// run.h5 on disk. Private to src/log. The writer thread and the ring of rows are in log.cc.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <vector>

#include "impedraw/log/h5.h"
#include "impedraw/log/log.h"
#include "impedraw/log/log_columns.h"

namespace impedraw {

// The root attribute that marks a file as a log of ours: the version of its layout. Logs written
// before version 2 have none.
inline constexpr const char* kLogMark = "impedraw_log";
inline constexpr double kLogVersion = 2.0;

// A log's rows and, in a reduced log, its steps. Each table is a set of datasets of equal length.
enum class LogTable { rows, steps };

// This class compresses chunks itself (shuffle, deflate 1), where that gains enough, and gives them
// to HDF5 as they are. The file is complete only once it is closed: it is written under a temporary
// name.
class LogFile {
 public:
  static constexpr std::size_t kChunkRows = 4096;
  // Rows of a reduced log arrive 12 times more slowly.
  static constexpr std::size_t kReducedChunkRows = 256;
  static constexpr std::size_t chunk_rows(LogTable table, LogRate rate) {
    return table == LogTable::rows && rate == LogRate::reduced ? kReducedChunkRows : kChunkRows;
  }

  // Writes a log without rows and returns its log_id. Throws h5::Error, as the other functions do.
  static double create(const std::filesystem::path& path, const RunLogHeader& header);
  // Opens a log with the same header and rate, and keeps the first `rows` of each table. It gets a
  // new log_id. Its wall times are removed until close().
  LogFile(const std::filesystem::path& path, const RunLogHeader& header,
          const std::vector<std::size_t>& rows);

  void resize(LogTable table, std::size_t rows);  // resizes all datasets of the table
  // Writes rows [chunk · chunk_rows, + rows) of column `c`. A partial chunk may be written again.
  void write_chunk(LogTable table, std::size_t c, std::size_t chunk, const std::byte* data,
                   std::size_t rows);
  // Lets the disk begin to write what the file holds so far, and waits for nothing.
  void begin_writeback();
  // Adds the times to those of the earlier runs. Without times: of a run that was killed.
  void close(const std::optional<WallTimes>& wall, const std::string& ending = {});
  // Releases the file after an error without touching it again. (HDF5's own close would write
  // metadata that refers to missing data.)
  void abandon();

 private:
  struct Table {
    std::vector<LogColumn> columns;  // the first is the time
    std::size_t chunk_rows;
    std::vector<h5::Id> datasets{};
  };

  LogFile() = default;
  void make_tables(const RunLogHeader& header);
  void create_datasets(Table& table, const RunLogHeader& header);
  Table& at(LogTable table) { return tables_[static_cast<std::size_t>(table)]; }
  double write_static(const RunLogHeader& header);  // returns the log_id
  void write_fixed(const char* name, hid_t type, const void* data, std::size_t n, int width,
                   const char* unit, const char* frame, const char* description);
  void write_chunk(hid_t dataset, const char* name, std::size_t chunk, std::size_t chunk_rows,
                   std::size_t row_bytes, std::size_t size, const std::byte* data,
                   std::size_t rows);

  h5::Id file_;
  std::vector<Table> tables_;  // in the order of LogTable; a full log has only the first
  WallTimes before_{0.0, 0.0, 0.0};
  std::vector<std::byte> padded_, shuffled_, deflated_;
};

}  // namespace impedraw
