#include "impedraw/log/log.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>

#include "impedraw/log/log_file.h"
#include "impedraw/log/log_reader.h"
#include "impedraw/log/log_step.h"
#include "impedraw/log/row_selection.h"

namespace impedraw {
namespace {

constexpr auto kFlushInterval = std::chrono::milliseconds(400);

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
  require(h.target_points.size() == h.target_stroke.size(), "each target point needs a stroke");
  return h;
}

// Ring of one table's rows waiting to be written: [tail, head). Only the loop advances the head;
// only the writer thread advances the tail, one full chunk at a time.
struct Stream {
  LogTable table;
  std::vector<LogColumn> columns;
  std::size_t chunk, size;                     // of a chunk and of the ring [rows]
  std::vector<std::size_t> row_bytes{};        // of each column
  std::vector<std::vector<std::byte>> ring{};  // `size` rows of each column
  std::atomic<std::size_t> head{0}, tail{0};   // rows appended, rows no longer needed

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
};

}  // namespace

struct RunLog::Writer {
  std::filesystem::path path;
  int joints, terms;
  std::unique_ptr<LogFile> file;
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

  Writer(const std::filesystem::path& log, const RunLogHeader& header)
      : path(log),
        joints(static_cast<int>(header.joint_names.size())),
        terms(static_cast<int>(header.torque_terms.size())),
        measured(header) {
    streams.push_back(std::make_unique<Stream>(LogTable::rows, header.rate, log_columns(header)));
    if (header.rate == LogRate::full) return;
    streams.push_back(std::make_unique<Stream>(LogTable::steps, header.rate, step_columns()));
    selection.emplace(joints);
  }

  std::vector<std::size_t> heads() const {
    std::vector<std::size_t> rows;
    for (const auto& stream : streams) rows.push_back(stream->head.load(std::memory_order_acquire));
    return rows;
  }

  // Opens the file with LogFile's arguments and starts the writer thread.
  template <typename... Arguments>
  void start(const Arguments&... arguments) {
    h5::quiet_errors();
    try {
      file = std::make_unique<LogFile>(path, arguments...);
    } catch (const h5::Error& e) {
      throw LogError("cannot write " + path.string() + ": " + e.what());
    }
    thread = std::thread([this, rows = heads()] { run(rows); });  // rows already in the file
  }

  void add(Stream& stream, const auto& visit) {
    const std::size_t head = stream.head.load(std::memory_order_relaxed);
    if (head - stream.tail.load(std::memory_order_acquire) == stream.size) {
      std::unique_lock lock(mutex);
      room.wait(lock, [&] { return failed || head - stream.tail.load() < stream.size; });
      if (failed) throw LogError(cause);
    }
    std::size_t c = 0;
    visit([&](const void* data, int count, std::size_t size) {
      std::memcpy(stream.slot(c++, head), data, static_cast<std::size_t>(count) * size);
    });
    stream.head.store(head + 1, std::memory_order_release);
    if ((head + 1) % stream.chunk == 0) {
      const std::scoped_lock lock(mutex);
      more.notify_one();
    }
  }

  void add_row(const LogRow& row) {
    add(*streams[0], [&](const auto& put) { put_row(row, terms, put); });
  }

  void append(const LogRow& row) {
    ++steps;
    if (!selection) return add_row(row);
    const LogStep step = measured.measure(row);
    add(*streams[1], [&](const auto& put) { put_step(step, put); });
    selection->add(row, step.force, [this](const LogRow& kept) { add_row(kept); });
  }

  void write_rows(Stream& stream, std::size_t from, std::size_t to) {
    for (std::size_t c = 0; c < stream.columns.size(); ++c)
      file->write_chunk(stream.table, c, from / stream.chunk, stream.slot(c, from), to - from);
  }

  void write_chunks(Stream& stream) {
    const std::size_t end = stream.head.load(std::memory_order_acquire);
    std::size_t begin = stream.tail.load();
    if (end - begin >= stream.chunk) file->resize(stream.table, end);
    for (; end - begin >= stream.chunk; begin += stream.chunk) {
      write_rows(stream, begin, begin + stream.chunk);
      {
        const std::scoped_lock lock(mutex);
        stream.tail = begin + stream.chunk;
      }
      room.notify_one();
    }
  }

  // Writes the last, partial chunk as well. Returns the number of rows then in the file.
  std::size_t write_rest(Stream& stream) {
    const std::size_t begin = stream.tail.load();
    const std::size_t end =
        std::min(stream.head.load(std::memory_order_acquire), begin + stream.chunk);
    file->resize(stream.table, end);
    if (end > begin) write_rows(stream, begin, end);
    return end;
  }

  void run(std::vector<std::size_t> flushed) {
    h5::quiet_errors();
    try {
      Clock::time_point last_flush = Clock::now();
      for (bool last = false; !last;) {
        {
          std::unique_lock lock(mutex);
          more.wait_for(lock, std::chrono::milliseconds(50), [&] {
            return closing || std::any_of(streams.begin(), streams.end(),
                                          [](const auto& s) { return s->has_chunk(); });
          });
        }
        last = closing;
        for (const auto& stream : streams) write_chunks(*stream);
        if (!last && Clock::now() - last_flush < kFlushInterval) continue;
        last_flush = Clock::now();
        if (heads() == flushed) continue;
        for (std::size_t s = 0; s < streams.size(); ++s) flushed[s] = write_rest(*streams[s]);
        file->flush();
      }
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
};

RunLog::RunLog(const std::filesystem::path& path, const RunLogHeader& header)
    : RunLog(std::make_unique<Writer>(path, checked(header))) {
  writer_->start(header);
}

RunLog::RunLog(std::unique_ptr<Writer> writer) : writer_(std::move(writer)) {}
RunLog::RunLog(RunLog&&) noexcept = default;

RunLog RunLog::append_to(const std::filesystem::path& path, const RunLogHeader& given) {
  auto in = std::make_unique<LogReader>(path);
  in->require(given);
  RunLogHeader header = given;
  header.rate = in->rate();
  RunLog log(std::make_unique<Writer>(path, checked(header)));
  Writer& w = *log.writer_;
  for (const auto& stream : w.streams) {
    const std::size_t rows = stream->table == LogTable::rows ? in->rows() : in->steps();
    // Chunks are written whole, so the rows of a partial last chunk are read back into the ring.
    const std::size_t begin = rows / stream->chunk * stream->chunk;
    for (std::size_t c = 0; c < stream->columns.size() && rows > begin; ++c) {
      if (!in->read(stream->columns[c], begin, rows - begin, stream->slot(c, begin)))
        in->fail("cannot be read");
    }
    stream->tail = begin;
    stream->head = rows;
  }
  w.steps = in->steps();
  if (header.rate == LogRate::reduced) w.measured.set_joint_margin(in->joint_margin());
  in.reset();  // the file must be open only once
  w.start(header, w.heads());
  return log;
}

RunLog::~RunLog() {
  try {
    if (writer_ && writer_->file) close();
  } catch (const std::exception&) {  // a destructor must not throw
  }
}

void RunLog::append(const LogRow& row) {
  Writer& w = *writer_;
  if (w.failed.load(std::memory_order_relaxed)) throw LogError(w.cause);
  bool fits = row.joint_position.size() == w.joints && row.joint_velocity.size() == w.joints &&
              row.joint_torque.size() == w.joints;
  for (int i = 0; i < w.terms; ++i) fits = fits && row.torque_terms[i].size() == w.joints;
  if (!fits)
    throw std::invalid_argument("run log: a row's joint vectors must have " +
                                std::to_string(w.joints) + " values");
  w.append(row);
}

WallTimes RunLog::close(WallTimes wall) {
  Writer& w = *writer_;
  const Clock::time_point start = Clock::now();
  if (w.selection && !w.failed) w.selection->finish([&](const LogRow& row) { w.add_row(row); });
  w.stop();
  if (w.failed) {
    if (w.file) w.file->abandon();
    w.file.reset();
    throw LogError(w.cause);
  }
  if (!w.file) return wall;
  wall.writing = std::chrono::duration<double>(Clock::now() - start).count();
  try {
    w.file->close(wall);
    w.file.reset();
  } catch (const h5::Error& e) {
    w.file->abandon();
    w.file.reset();
    throw LogError("cannot write " + w.path.string() + ": " + e.what());
  }
  return wall;
}

long RunLog::steps() const noexcept { return static_cast<long>(writer_->steps); }

}  // namespace impedraw
