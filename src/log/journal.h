// run.journal: the rows of a run that goes on, on the disk within seconds. Private to src/log.
//
// The journal is only ever appended to. A record holds consecutive rows of one table, column by
// column, with a sequence number and a checksum. sync() returns when all records are on the disk.
// A reader takes the records up to the first that is not whole: after a power cut, the tail of the
// file may be missing, zero or garbage.
//
// The first record says to which log the rows belong (its log_id, which changes whenever run.h5 is
// replaced), how many rows that log holds, and what the columns are. A journal of another log is
// stale.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

namespace impedraw {

std::filesystem::path journal_of(const std::filesystem::path& log);  // run.h5 → run.journal

struct JournalHeader {
  struct Column {
    std::string name;
    std::size_t row_bytes;
    bool operator==(const Column&) const = default;
  };
  double log_id = 0.0;
  std::vector<std::size_t> rows;             // of each table, in the log
  std::vector<std::vector<Column>> columns;  // of each table

  bool operator==(const JournalHeader&) const = default;
};

class JournalWriter {
 public:
  // Creates the file, with the header on the disk. Replaces an earlier journal. Throws
  // std::runtime_error naming the cause, as do the other functions.
  JournalWriter(const std::filesystem::path& path, const JournalHeader& header);
  ~JournalWriter();
  JournalWriter(const JournalWriter&) = delete;
  JournalWriter& operator=(const JournalWriter&) = delete;

  // Writes a record of rows [first, first + rows) of a table. `pieces`: the bytes of one column
  // after the other.
  using Piece = std::pair<const std::byte*, std::size_t>;
  void add(std::size_t table, std::size_t first, std::size_t rows,
           const std::vector<Piece>& pieces);
  void sync();

 private:
  void put(std::uint32_t kind, std::size_t first, std::size_t rows,
           const std::vector<Piece>& pieces);

  int file_ = -1;
  std::uint64_t id_ = 0, sequence_ = 0;
  std::vector<std::byte> record_;
};

class JournalReader {
 public:
  // Throws InputError if the file is no journal.
  explicit JournalReader(const std::filesystem::path& path);

  const JournalHeader& header() const { return header_; }

  struct Record {
    std::size_t table, first, rows;
    std::vector<std::byte> data;  // the columns one after the other
  };
  // The next whole record; false after the last.
  bool next(Record* record);

 private:
  bool read(std::uint32_t* kind, Record* record);

  std::ifstream file_;
  std::uint64_t id_ = 0, sequence_ = 0;
  JournalHeader header_;
  std::vector<std::size_t> expected_;  // first row of the next record, of each table
  std::uint64_t left_ = 0;             // bytes of the file not read yet
};

}  // namespace impedraw
