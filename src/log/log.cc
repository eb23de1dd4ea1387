#include "impedraw/log/log.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <optional>
#include <thread>

#include <fcntl.h>
#include <unistd.h>

#include "impedraw/common/errors.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/log/journal.h"
#include "impedraw/log/log_file.h"
#include "impedraw/log/log_reader.h"
#include "impedraw/log/log_step.h"
#include "impedraw/log/row_selection.h"

namespace impedraw {
namespace {

// Rows are on the disk after this time, or this many steps of a simulation that runs ahead of it.
constexpr auto kSyncInterval = std::chrono::milliseconds(500);
constexpr std::size_t kSyncSteps = 2000;

using Clock = std::chrono::steady_clock;

void require(bool holds, const std::string& message) {
  if (!holds) throw std::invalid_argument("run log: " + message);
}

const RunLogHeader& checked(const RunLogHeader& h) {
  const auto n = static_cast<Eigen::Index>(h.joint_names.size());
  require(n >= 1 && n <= kMaxJoints,
          "joint_names must hold 1 to " + std::to_string(kMaxJoints) + " names");
  require(h.joint_lower.size() == n && h.joint_upper.size() == n && h.torque_limit.size() == n,
          "each joint needs its limits");
  require(h.torque_terms.size() <= kMaxTorqueTerms,
          "at most " + std::to_string(kMaxTorqueTerms) + " torque terms");
  require(h.cloud_normals.size() == h.cloud_points.size() &&
              h.cloud_camera.size() == h.cloud_points.size(),
          "each cloud point needs a normal and a camera");
  require(h.cloud_colour.empty() || h.cloud_colour.size() == h.cloud_points.size(),
          "each cloud point needs a colour, or none has one");
  require(h.target_points.size() == h.target_stroke.size(), "each target point needs a stroke");
  require(h.joint_speed_limit.size() == 0 || h.joint_speed_limit.size() == n,
          "each joint needs its speed limit, or none has one");
  return h;
}

// Ring of one table's rows waiting to be written: [min(tail, synced), head). Only the loop advances
// the head; only the writer thread advances the others, the tail one full chunk at a time.
struct Stream {
  LogTable table;
  std::vector<LogColumn> columns;
  std::size_t chunk, size;                     // of a chunk and of the ring [rows]
  std::vector<std::size_t> row_bytes{};        // of each column
  std::vector<std::vector<std::byte>> ring{};  // `size` rows of each column
  // rows appended, in whole chunks of the file, in the journal on the disk
  std::atomic<std::size_t> head{0}, tail{0}, synced{0};

  Stream(LogTable which, LogRate rate, const std::vector<LogColumn>& all)
      : table(which), columns(all), chunk(LogFile::chunk_rows(which, rate)), size(4 * chunk) {
    for (const LogColumn& column : columns) {
      row_bytes.push_back(column.row_bytes());
      ring.emplace_back(size * column.row_bytes());
    }
  }
  std::byte* slot(std::size_t column, std::size_t row) {
    return ring[column].data() + row % size * row_bytes[column];
  }
  bool has_chunk() const { return head.load() - tail.load() >= chunk; }
  std::size_t unsynced() const { return head.load() - synced.load(); }
  bool is_full(std::size_t row) const {
    return row - std::min(tail.load(std::memory_order_acquire),
                          synced.load(std::memory_order_acquire)) >=
               size ||
           row - synced.load(std::memory_order_acquire) >= kMostUnsyncedSteps;
  }
};

// Runs `work`; what it throws becomes a LogError that names the log.
void as_log_error(const std::filesystem::path& path, const auto& work) {
  const std::string doing = "cannot write " + path.string() + ": ";
  try {
    work();
  } catch (const std::runtime_error& e) {
    const std::string cause = e.what();
    throw LogError(cause.starts_with("cannot write ") ? cause : doing + cause);
  }
}

}  // namespace

struct RunLog::Writer {
  std::filesystem::path path, part;  // of the log and of the file that will replace it
  RunLogHeader header;
  int joints;
  std::unique_ptr<LogFile> file;
  std::unique_ptr<JournalWriter> journal;  // none while an earlier journal is read
  // In the order of LogTable: the rows and, in a reduced log, the steps.
  std::vector<std::unique_ptr<Stream>> streams;
  std::optional<RowSelection> selection;  // reduced log only
  LogSteps measured;
  std::size_t steps = 0;
  std::atomic<bool> closing{false}, failed{false};
  std::string cause;  // of the failure; set before `failed`
  std::mutex mutex;
  std::condition_variable more, room;
  std::thread thread;

  Writer(const std::filesystem::path& log, const RunLogHeader& given)
      : path(log),
        part(unfinished(log)),
        header(given),
        joints(static_cast<int>(header.joint_names.size())),
        measured(header) {
    streams.push_back(std::make_unique<Stream>(LogTable::rows, header.rate, log_columns(header)));
    if (header.rate == LogRate::full) return;
    streams.push_back(std::make_unique<Stream>(LogTable::steps, header.rate, step_columns()));
    selection.emplace(joints);
  }
  ~Writer() {
    stop();
    if (!file) return;
    file->abandon();
    std::error_code error;
    std::filesystem::remove(part, error);
  }

  std::vector<std::size_t> heads() const {
    std::vector<std::size_t> rows;
    for (const auto& stream : streams) rows.push_back(stream->head.load(std::memory_order_acquire));
    return rows;
  }

  // Takes over the rows of the log, whose header must match.
  void go_on_from(const LogReader& in) {
    for (const auto& stream : streams) {
      const std::size_t rows = stream->table == LogTable::rows ? in.rows() : in.steps();
      // Chunks are written whole, so the rows of a partial last chunk are read back into the ring.
      const std::size_t begin = rows / stream->chunk * stream->chunk;
      for (std::size_t c = 0; c < stream->columns.size() && rows > begin; ++c) {
        if (!in.read(stream->columns[c], begin, rows - begin, stream->slot(c, begin)))
          in.fail("cannot be read");
      }
      stream->tail = begin;
      stream->head = stream->synced = rows;
    }
    steps = in.steps();
    if (header.rate == LogRate::reduced) {
      measured.set_joint_margin(in.joint_margin());
      measured.set_joint_speed_share(in.joint_speed_share());
    }
  }

  JournalHeader journal_header(double log_id) const {
    JournalHeader out{log_id, heads(), {}};
    for (const auto& stream : streams) {
      auto& columns = out.columns.emplace_back();
      for (const LogColumn& column : stream->columns)
        columns.push_back({column.name, column.row_bytes()});
    }
    return out;
  }

  // Opens a copy of the log for the rows to come, and starts the writer thread. With a log_id,
  // starts a journal of that log, too.
  void start(std::optional<double> log_id) {
    as_log_error(path, [&] {
      unlink(part.c_str());
      std::filesystem::copy_file(path, part);
      file = std::make_unique<LogFile>(part, header, heads());
      if (log_id)
        journal = std::make_unique<JournalWriter>(journal_of(path), journal_header(*log_id));
    });
    thread = std::thread([this] { run(); });
  }

  // Waits until the stream has room for row `head`.
  void make_room(Stream& stream, std::size_t head) {
    if (!stream.is_full(head)) return;
    std::unique_lock lock(mutex);
    more.notify_one();
    room.wait(lock, [&] { return failed || !stream.is_full(head); });
    if (failed) throw LogError(cause);
  }

  void advance(Stream& stream, std::size_t head) {
    stream.head.store(head, std::memory_order_release);
    if (head % stream.chunk == 0 || head % kSyncSteps == 0) {
      // Without the lock, which the writer holds: the loop must not wait. A wake-up that is lost
      // costs the writer the rest of its own 50 ms.
      more.notify_one();
    }
  }

  // `visit`: calls what it is given with each column, as visit_row() and visit_step() do.
  void add(Stream& stream, const auto& visit) {
    const std::size_t head = stream.head.load(std::memory_order_relaxed);
    make_room(stream, head);
    std::size_t c = 0;
    visit([&](const char*, const auto& value, const auto&...) {
      put_value(value, [&](const void* data, int count, std::size_t size) {
        std::memcpy(stream.slot(c++, head), data, static_cast<std::size_t>(count) * size);
      });
    });
    advance(stream, head + 1);
  }

  void add_row(const LogRow& row) {
    add(*streams[0], [&](const auto& put) { visit_row(row, header, put); });
  }

  void append(const LogRow& row) {
    ++steps;
    if (!selection) return add_row(row);
    const LogStep step = measured.measure(row);
    add(*streams[1], [&](const auto& put) { visit_step(step, "", put); });
    selection->add(row, step.force, [this](const LogRow& kept) { add_row(kept); });
  }

  // The rows of a journal's record. `offset`: where each column begins, for one row a column.
  void append(const JournalReader::Record& record, const std::vector<std::size_t>& offset) {
    Stream& stream = *streams[record.table];
    for (std::size_t i = 0; i < record.rows; ++i) {
      const std::size_t head = stream.head.load(std::memory_order_relaxed);
      make_room(stream, head);
      for (std::size_t c = 0; c < stream.columns.size(); ++c)
        std::memcpy(stream.slot(c, head),
                    record.data.data() + offset[c] * record.rows + i * stream.row_bytes[c],
                    stream.row_bytes[c]);
      advance(stream, head + 1);
    }
  }

  void write_rows(Stream& stream, std::size_t from, std::size_t to) {
    for (std::size_t c = 0; c < stream.columns.size(); ++c)
      file->write_chunk(stream.table, c, from / stream.chunk, stream.slot(c, from), to - from);
  }

  // Writes one full chunk, if there is one.
  void write_chunk(Stream& stream) {
    if (!stream.has_chunk()) return;
    const std::size_t begin = stream.tail.load(), end = begin + stream.chunk;
    file->resize(stream.table, end);
    write_rows(stream, begin, end);
    file->begin_writeback();
    {
      const std::scoped_lock lock(mutex);
      stream.tail = end;
    }
    room.notify_one();
  }

  // Writes the last, partial chunk.
  void write_rest(Stream& stream) {
    const std::size_t begin = stream.tail.load(), end = stream.head.load(std::memory_order_acquire);
    file->resize(stream.table, end);
    if (end > begin) write_rows(stream, begin, end);
  }

  // The rows between the two as one record. A ring's end makes two pieces of a column.
  void write_record(Stream& stream, std::size_t from, std::size_t to) {
    if (to == from) return;
    std::vector<JournalWriter::Piece> pieces;
    const std::size_t before_end = std::min(to - from, stream.size - from % stream.size);
    for (std::size_t c = 0; c < stream.columns.size(); ++c) {
      pieces.emplace_back(stream.slot(c, from), before_end * stream.row_bytes[c]);
      if (before_end < to - from)
        pieces.emplace_back(stream.slot(c, from + before_end),
                            (to - from - before_end) * stream.row_bytes[c]);
    }
    journal->add(static_cast<std::size_t>(stream.table), from, to - from, pieces);
  }

  // Brings all rows so far to the disk.
  void sync() {
    std::vector<std::size_t> ends = heads();
    bool any = false;
    for (std::size_t s = 0; s < streams.size(); ++s) {
      const std::size_t from = streams[s]->synced.load();
      any = any || ends[s] > from;
      if (journal) write_record(*streams[s], from, ends[s]);
    }
    if (!any) return;
    if (journal) journal->sync();
    {
      const std::scoped_lock lock(mutex);
      for (std::size_t s = 0; s < streams.size(); ++s) streams[s]->synced = ends[s];
    }
    room.notify_one();
  }

  bool is_sync_due() const {
    return std::any_of(streams.begin(), streams.end(),
                       [](const auto& s) { return s->unsynced() >= kSyncSteps; });
  }
  bool has_chunk() const {
    return std::any_of(streams.begin(), streams.end(),
                       [](const auto& s) { return s->has_chunk(); });
  }

  void run() {
    h5::quiet_errors();
    try {
      Clock::time_point last_sync = Clock::now();
      for (bool last = false; !last;) {
        {
          std::unique_lock lock(mutex);
          more.wait_for(lock, std::chrono::milliseconds(50),
                        [&] { return closing || has_chunk() || is_sync_due(); });
        }
        last = closing && !has_chunk();
        if (last || is_sync_due() || Clock::now() - last_sync >= kSyncInterval) {
          sync();
          last_sync = Clock::now();
        }
        // One chunk at a time: compressing it takes as long as a simulation takes for many steps.
        for (const auto& stream : streams) write_chunk(*stream);
      }
      for (const auto& stream : streams) write_rest(*stream);
    } catch (const std::exception& e) {
      cause = "cannot write " + path.string() + ": " + e.what();
      const std::scoped_lock lock(mutex);
      failed = true;
      room.notify_one();
    }
  }

  void stop() {
    if (!thread.joinable()) return;
    {
      const std::scoped_lock lock(mutex);
      closing = true;
    }
    more.notify_one();
    thread.join();
  }

  // Ends the thread and puts the new log into the place of the old one. From then on the journal is
  // stale.
  // Returns the time that it took [s].
  double finish(std::optional<WallTimes> wall, const Clock::time_point& start,
                const std::string& ending = {}) {
    stop();
    if (failed) throw LogError(cause);
    const double took = std::chrono::duration<double>(Clock::now() - start).count();
    if (wall) wall->writing = took;
    as_log_error(path, [&] {
      file->close(wall, ending);
      file.reset();
      put_in_place(part, path);
    });
    journal.reset();
    unlink(journal_of(path).c_str());
    return took;
  }
};

double log_bytes(const RunLogHeader& header, double seconds) {
  constexpr double kResults = 20e6;      // report, pictures, the log's canvas and cloud twice
  constexpr double kRowsOfSteps = 0.12;  // of a reduced log, drawn with many short strokes
  const auto sum = [](const std::vector<LogColumn>& columns) {
    double bytes = 0.0;
    for (const LogColumn& column : columns) bytes += static_cast<double>(column.row_bytes());
    return bytes;
  };
  const double row = sum(log_columns(header));
  const double step = header.rate == LogRate::full ? row : sum(step_columns()) + kRowsOfSteps * row;
  return kResults + 2.0 * step * seconds / header.dt;
}

RunLog::RunLog(const std::filesystem::path& path, const RunLogHeader& header)
    : RunLog(std::make_unique<Writer>(path, checked(header))) {
  h5::quiet_errors();
  Writer& w = *writer_;
  double log_id = 0.0;
  as_log_error(path, [&] {
    unlink(w.part.c_str());
    log_id = LogFile::create(w.part, header);
    put_in_place(w.part, path);
  });
  w.start(log_id);
}

RunLog::RunLog(std::unique_ptr<Writer> writer) : writer_(std::move(writer)) {}
RunLog::RunLog(RunLog&&) noexcept = default;

RunLog RunLog::append_to(const std::filesystem::path& path, const RunLogHeader& given) {
  recover_log(path);
  auto in = std::make_unique<LogReader>(path);
  in->require(given);
  RunLogHeader header = given;
  header.rate = in->rate();
  RunLog log(std::make_unique<Writer>(path, checked(header)));
  log.writer_->go_on_from(*in);
  const double log_id = in->log_id();
  in.reset();  // HDF5 is not for two threads
  log.writer_->start(log_id);
  return log;
}

bool recover_log(const std::filesystem::path& path) {
  h5::quiet_errors();
  const std::filesystem::path old = journal_of(path);
  if (!is_own_file(old) || !is_own_file(path)) return false;
  JournalReader journal(old);
  std::optional<LogReader> in(path);
  if (in->cut_short()) in->fail("is cut short: it is not the log that run.journal goes on from");
  RunLog::Writer w(path, in->header());
  w.go_on_from(*in);
  const double log_id = in->log_id();
  in.reset();
  JournalReader::Record record;
  if (journal.header().log_id != log_id || !journal.next(&record)) {
    unlink(old.c_str());  // of a log that has been replaced since, or without rows
    return false;
  }
  // The columns of both, which a file lists in an order of its own.
  const JournalHeader expected = w.journal_header(log_id);
  const JournalHeader& found = journal.header();
  std::vector<std::vector<std::size_t>> offsets;
  bool same = found.rows == expected.rows && found.columns.size() == expected.columns.size();
  for (std::size_t t = 0; same && t < expected.columns.size(); ++t) {
    same = found.columns[t].size() == expected.columns[t].size();
    auto& offset = offsets.emplace_back();
    for (const auto& column : expected.columns[t]) {
      std::size_t at = 0;
      auto there = found.columns[t].begin();
      for (; there != found.columns[t].end() && *there != column; ++there) at += there->row_bytes;
      same = same && there != found.columns[t].end();
      offset.push_back(at);
    }
  }
  if (!same) throw InputError(old.string() + ": its columns are not those of " + path.string());
  w.start(std::nullopt);
  do {
    w.append(record, offsets[record.table]);
  } while (journal.next(&record));
  w.finish(std::nullopt, {});
  return true;
}

RunLog::~RunLog() {
  try {
    if (writer_) close();
  } catch (const std::exception&) {  // a destructor must not throw
  }
}

void RunLog::append(const LogRow& row) {
  Writer& w = *writer_;
  if (w.failed.load(std::memory_order_relaxed)) throw LogError(w.cause);
  bool fits = row.joint_position.size() == w.joints && row.joint_velocity.size() == w.joints &&
              row.joint_torque.size() == w.joints;
  for (std::size_t i = 0; i < w.header.torque_terms.size(); ++i)
    fits = fits && row.torque_terms[i].size() == w.joints;
  if (!fits)
    throw std::invalid_argument("run log: a row's joint vectors must have " +
                                std::to_string(w.joints) + " values");
  w.append(row);
}

WallTimes RunLog::close(WallTimes wall, const std::string& ending) {
  Writer& w = *writer_;
  const Clock::time_point start = Clock::now();
  if (!w.file) return wall;
  if (w.selection && !w.failed) w.selection->finish([&](const LogRow& row) { w.add_row(row); });
  wall.writing = w.finish(wall, start, ending);
  return wall;
}

long RunLog::steps() const noexcept { return static_cast<long>(writer_->steps); }

}  // namespace impedraw
