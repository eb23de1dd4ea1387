#include "impedraw/log/journal.h"

#include <fcntl.h>
#include <sys/random.h>
#include <unistd.h>
#include <zlib.h>

#include <cerrno>
#include <cstring>
#include <iomanip>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "impedraw/common/errors.h"
#include "impedraw/files/durable_file.h"

namespace impedraw {
namespace {

constexpr std::uint32_t kMagic = 0x314a5249;  // "IRJ1"
constexpr std::uint32_t kHeader = 0xffffffff;
constexpr std::size_t kMostTables = 2;

// Before each record's data. The checksum covers all that follows it, the data included.
struct RecordHead {
  std::uint32_t magic, checksum;
  std::uint64_t journal, sequence;
  std::uint32_t kind, unused;  // kind: the table, or kHeader
  std::uint64_t first, rows, bytes;
};
static_assert(sizeof(RecordHead) == 56);
constexpr std::size_t kNotCovered = 8;

std::uint32_t checksum(const std::byte* record, std::size_t bytes) {
  uLong crc = crc32(0, nullptr, 0);
  crc = crc32_z(crc, reinterpret_cast<const Bytef*>(record) + kNotCovered, bytes - kNotCovered);
  return static_cast<std::uint32_t>(crc);
}

[[noreturn]] void fail(const char* doing) {
  throw std::runtime_error(std::string("journal: ") + doing + ": " + std::strerror(errno));
}

std::string text_of(const JournalHeader& header) {
  std::ostringstream out;
  out << std::setprecision(std::numeric_limits<double>::max_digits10) << "log " << header.log_id
      << '\n';
  for (std::size_t t = 0; t < header.columns.size(); ++t) {
    out << "table " << header.rows[t] << ' ' << header.columns[t].size() << '\n';
    for (const auto& column : header.columns[t])
      out << column.row_bytes << ' ' << column.name << '\n';
  }
  return out.str();
}

bool read_header(const std::string& text, JournalHeader* header) {
  std::istringstream in(text);
  std::string word;
  if (!(in >> word >> header->log_id) || word != "log") return false;
  while (in >> word) {
    std::size_t rows = 0, columns = 0;
    if (word != "table" || !(in >> rows >> columns) || columns > 1000 ||
        header->columns.size() == kMostTables)
      return false;
    header->rows.push_back(rows);
    auto& table = header->columns.emplace_back();
    for (std::size_t c = 0; c < columns; ++c) {
      JournalHeader::Column column{"", 0};
      if (!(in >> column.row_bytes) || column.row_bytes > 4096 ||
          !std::getline(in >> std::ws, column.name))
        return false;
      table.push_back(column);
    }
  }
  return !header->columns.empty();
}

}  // namespace

std::filesystem::path journal_of(const std::filesystem::path& log) {
  std::filesystem::path path = log;
  return path.replace_extension(".journal");
}

JournalWriter::JournalWriter(const std::filesystem::path& path, const JournalHeader& header) {
  if (getrandom(&id_, sizeof id_, 0) != sizeof id_) fail("random numbers");
  const std::filesystem::path part = unfinished(path);
  unlink(part.c_str());
  file_ = open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (file_ < 0) fail("create");
  const std::string text = text_of(header);
  try {
    put(kHeader, 0, 0, {{reinterpret_cast<const std::byte*>(text.data()), text.size()}});
    put_in_place(part, path);
  } catch (...) {
    close(file_);
    unlink(part.c_str());
    throw;
  }
}

JournalWriter::~JournalWriter() { close(file_); }

void JournalWriter::add(std::size_t table, std::size_t first, std::size_t rows,
                        const std::vector<Piece>& pieces) {
  put(static_cast<std::uint32_t>(table), first, rows, pieces);
}

void JournalWriter::put(std::uint32_t kind, std::size_t first, std::size_t rows,
                        const std::vector<Piece>& pieces) {
  record_.resize(sizeof(RecordHead));
  for (const auto& [data, bytes] : pieces) record_.insert(record_.end(), data, data + bytes);
  RecordHead head{
      kMagic, 0, id_, sequence_++, kind, 0, first, rows, record_.size() - sizeof(RecordHead)};
  std::memcpy(record_.data(), &head, sizeof head);
  head.checksum = checksum(record_.data(), record_.size());
  std::memcpy(record_.data(), &head, sizeof head);
  errno = write_all(file_, {reinterpret_cast<const char*>(record_.data()), record_.size()});
  if (errno != 0) fail("write");
}

void JournalWriter::sync() {
  if (fdatasync(file_) != 0 && errno != EINVAL) fail("sync");
}

JournalReader::JournalReader(const std::filesystem::path& path) {
  const auto refuse = [&] {
    throw InputError(path.string() + ": not a journal that impedraw wrote");
  };
  if (!is_own_file(path)) refuse();
  file_.open(path, std::ios::binary);
  left_ = std::filesystem::file_size(path);
  std::uint32_t kind = 0;
  Record record;
  if (!read(&kind, &record) || kind != kHeader) refuse();
  const std::string text(reinterpret_cast<const char*>(record.data.data()), record.data.size());
  if (!read_header(text, &header_)) refuse();
  expected_ = header_.rows;
}

bool JournalReader::read(std::uint32_t* kind, Record* record) {
  RecordHead head{};
  if (left_ < sizeof head || !file_.read(reinterpret_cast<char*>(&head), sizeof head)) return false;
  left_ -= sizeof head;
  if (sequence_ == 0) id_ = head.journal;
  if (head.magic != kMagic || head.journal != id_ || head.sequence != sequence_ ||
      head.bytes > left_)
    return false;
  std::vector<std::byte> whole(sizeof head + head.bytes);
  std::memcpy(whole.data(), &head, sizeof head);
  if (!file_.read(reinterpret_cast<char*>(whole.data() + sizeof head),
                  static_cast<std::streamsize>(head.bytes)))
    return false;
  left_ -= head.bytes;
  if (checksum(whole.data(), whole.size()) != head.checksum) return false;
  ++sequence_;
  *kind = head.kind;
  *record = {head.kind, head.first, head.rows,
             std::vector<std::byte>(whole.begin() + sizeof head, whole.end())};
  return true;
}

bool JournalReader::next(Record* record) {
  std::uint32_t kind = 0;
  if (!read(&kind, record)) return false;
  if (kind >= header_.columns.size() || record->first != expected_[kind]) return false;
  std::size_t row_bytes = 0;
  for (const auto& column : header_.columns[kind]) row_bytes += column.row_bytes;
  if (row_bytes == 0 || record->data.size() / row_bytes != record->rows ||
      record->data.size() % row_bytes != 0)
    return false;
  expected_[kind] += record->rows;
  return true;
}

}  // namespace impedraw
