#include "impedraw/run/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <string>
#include <thread>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "impedraw/common/errors.h"

namespace impedraw {

namespace {

namespace fs = std::filesystem;

// Closes the lock's file and throws.
[[noreturn]] void refuse_held(const fs::path& folder, int file) {
  std::array<char, 256> text{};
  const ssize_t n = pread(file, text.data(), text.size(), 0);
  std::string holder(text.data(), n > 0 ? static_cast<std::size_t>(n) : 0);
  while (!holder.empty() && holder.back() == '\n') holder.pop_back();
  close(file);
  throw InputError(
      fmt::format("{}: {} writes there; wait until it has ended, or name another folder with --out",
                  folder.string(), holder.empty() ? "another process" : holder));
}

// Returns false if another process holds the lock. A file system without locks has no other
// process either, as far as anyone can tell.
bool try_lock(int file, int kind) {
  return flock(file, kind | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

std::string this_process() {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  const std::time_t now = std::time(nullptr);
  return fmt::format("process {} on {} since {:%Y-%m-%d %H:%M:%S} UTC\n", getpid(), host.data(),
                     fmt::gmtime(now));
}

}  // namespace

FolderLock::FolderLock(const fs::path& folder) {
  const fs::path path = folder / kLockFile;
  file_ = open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (file_ < 0)
    throw InputError(fmt::format("{}: cannot be locked: {}", path.string(),
                                 errno == ELOOP ? "it is a symbolic link" : std::strerror(errno)));
  // require_free() of another process holds the lock for an instant.
  for (int i = 0; !try_lock(file_, LOCK_EX); ++i) {
    if (i == 5) refuse_held(folder, file_);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const std::string text = this_process();
  if (ftruncate(file_, 0) != 0 || pwrite(file_, text.data(), text.size(), 0) < 0) {
    // A full disk: the lock holds without a name.
  }
}

FolderLock::~FolderLock() { close(file_); }

void FolderLock::require_free(const fs::path& folder) {
  const int file = open((folder / kLockFile).c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
  if (file < 0) return;
  if (!try_lock(file, LOCK_SH)) refuse_held(folder, file);
  close(file);
}

}  // namespace impedraw
