#include "impedraw/log/log.h"

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "impedraw/log/log_file.h"
#include "impedraw/log/log_reader.h"

namespace impedraw {
namespace {

constexpr std::size_t kChunk = LogFile::kChunkRows;
constexpr std::size_t kRing = 4 * kChunk;  // rows
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

}  // namespace

// The loop owns [tail, head) growing at the head, the thread owns shrinking it at the tail, one
// full chunk at a time.
struct RunLog::Writer {
  std::filesystem::path path;
  int joints, terms;
  std::vector<LogColumn> columns;
  std::unique_ptr<LogFile> file;
  std::vector<std::size_t> row_bytes;         // of each column
  std::vector<std::vector<std::byte>> ring;   // kRing rows of each column
  std::atomic<std::size_t> head{0}, tail{0};  // rows appended, rows that need not be kept
  std::atomic<bool> closing{false}, failed{false};
  std::string cause;  // of the failure; written before `failed`
  std::mutex mutex;
  std::condition_variable more, room;
  std::thread thread;

  Writer(const std::filesystem::path& log, const RunLogHeader& header)
      : path(log),
        joints(static_cast<int>(header.joint_names.size())),
        terms(static_cast<int>(header.torque_terms.size())),
        columns(log_columns(header)) {
    for (const LogColumn& column : columns) {
      row_bytes.push_back(column.row_bytes());
      ring.emplace_back(kRing * column.row_bytes());
    }
  }

  // Opens the file (as LogFile's arguments say) and begins to write.
  template <typename... Arguments>
  void start(const Arguments&... arguments) {
    h5::quiet_errors();
    try {
      file = std::make_unique<LogFile>(path, arguments...);
    } catch (const h5::Error& e) {
      throw LogError("cannot write " + path.string() + ": " + e.what());
    }
    thread = std::thread([this, rows = head.load()] { run(rows); });  // what the file holds already
  }

  void write_rows(std::size_t from, std::size_t to) {
    const std::size_t slot = from % kRing;
    for (std::size_t c = 0; c < ring.size(); ++c)
      file->write_chunk(c, from / kChunk, ring[c].data() + slot * row_bytes[c], to - from);
  }

  void run(std::size_t flushed) {
    h5::quiet_errors();
    try {
      Clock::time_point last_flush = Clock::now();
      for (bool last = false; !last;) {
        {
          std::unique_lock lock(mutex);
          more.wait_for(lock, std::chrono::milliseconds(50),
                        [&] { return closing || head.load() - tail.load() >= kChunk; });
        }
        last = closing;
        std::size_t end = head.load(std::memory_order_acquire), begin = tail.load();
        if (end - begin >= kChunk) file->resize(end);
        for (; end - begin >= kChunk; begin += kChunk) {
          write_rows(begin, begin + kChunk);
          {
            const std::scoped_lock lock(mutex);
            tail = begin + kChunk;
          }
          room.notify_one();
        }
        if (!last && Clock::now() - last_flush < kFlushInterval) continue;
        last_flush = Clock::now();
        end = std::min(head.load(std::memory_order_acquire), begin + kChunk);
        if (end == flushed) continue;
        file->resize(end);
        if (end > begin) write_rows(begin, end);
        file->flush();
        flushed = end;
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

RunLog RunLog::append_to(const std::filesystem::path& path, const RunLogHeader& header) {
  RunLog log(std::make_unique<Writer>(path, checked(header)));
  Writer& w = *log.writer_;
  std::size_t rows = 0;
  {
    const LogReader in(path);
    in.require(header);
    rows = in.rows();
    // A chunk is written whole: the rows of the last one, where it is not full, come back into the
    // ring.
    const std::size_t begin = rows / kChunk * kChunk;
    for (std::size_t c = 0; c < w.columns.size() && rows > begin; ++c) {
      if (!in.read(w.columns[c], begin, rows - begin,
                   w.ring[c].data() + begin % kRing * w.row_bytes[c]))
        in.fail("cannot be read");
    }
    w.tail = begin;
  }
  w.head = rows;
  w.start(header, rows);
  return log;
}

RunLog::~RunLog() {
  try {
    if (writer_ && writer_->file) close();
  } catch (const std::exception&) {  // nobody is left to tell
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
  const std::size_t head = w.head.load(std::memory_order_relaxed);
  if (head - w.tail.load(std::memory_order_acquire) == kRing) {
    std::unique_lock lock(w.mutex);
    w.room.wait(lock, [&] { return w.failed || head - w.tail.load() < kRing; });
    if (w.failed) throw LogError(w.cause);
  }
  const std::size_t slot = head % kRing;
  std::size_t c = 0;
  put_row(row, w.terms, [&](const void* data, int count, std::size_t size) {
    std::memcpy(w.ring[c].data() + slot * w.row_bytes[c], data, count * size);
    ++c;
  });
  w.head.store(head + 1, std::memory_order_release);
  if ((head + 1) % kChunk == 0) {
    const std::scoped_lock lock(w.mutex);
    w.more.notify_one();
  }
}

WallTimes RunLog::close(WallTimes wall) {
  Writer& w = *writer_;
  const Clock::time_point start = Clock::now();
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

long RunLog::rows() const noexcept { return static_cast<long>(writer_->head.load()); }

}  // namespace impedraw
