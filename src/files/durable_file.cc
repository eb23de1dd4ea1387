#include "impedraw/files/durable_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

namespace impedraw {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kUnfinished = ".impedraw-part-";

[[noreturn]] void fail(const fs::path& file, int error) {
  throw std::runtime_error("cannot write " + file.string() + ": " + std::strerror(error));
}

fs::path folder_of(const fs::path& file) {
  const fs::path folder = file.parent_path();
  return folder.empty() ? fs::path(".") : folder;
}

// Owns a descriptor.
struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) close(fd);
  }
};

// True if the process whose id is in the name of the temporary file is this one or has ended.
bool is_orphan(const fs::path& file) {
  const long process = std::atol(file.filename().c_str() + kUnfinished.size());
  return process <= 0 || process == getpid() ||
         (kill(static_cast<pid_t>(process), 0) != 0 && errno == ESRCH);
}

// Some file systems have no sync; they have nothing to lose either.
bool is_failure(int error) { return error != EINVAL && error != EROFS && error != ENOTSUP; }

}  // namespace

fs::path unfinished(const fs::path& file) {
  return file.parent_path() /
         (std::string(kUnfinished) + std::to_string(getpid()) + "-" + file.filename().string());
}

void write_whole(const fs::path& file, std::string_view content) {
  const fs::path part = unfinished(file);
  unlink(part.c_str());
  {
    const Descriptor out{
        open(part.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666)};
    if (out.fd < 0) fail(file, errno);
    if (const int error = write_all(out.fd, content)) {
      unlink(part.c_str());
      fail(file, error);
    }
  }
  put_in_place(part, file);
}

void put_in_place(const fs::path& from, const fs::path& to) {
  int error = 0;
  {
    const Descriptor in{open(from.c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC)};
    if (in.fd < 0 || (fsync(in.fd) != 0 && is_failure(errno))) error = errno;
  }
  if (error == 0 && rename(from.c_str(), to.c_str()) != 0) error = errno;
  if (error != 0) {
    unlink(from.c_str());
    fail(to, error);
  }
  sync_folder(folder_of(to));
}

int write_all(int fd, std::string_view content) noexcept {
  while (!content.empty()) {
    const ssize_t n = write(fd, content.data(), content.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return n < 0 ? errno : EIO;
    content.remove_prefix(static_cast<std::size_t>(n));
  }
  return 0;
}

void sync_folder(const fs::path& folder) noexcept {
  const Descriptor entries{open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)};
  if (entries.fd >= 0) fsync(entries.fd);
}

bool is_unfinished(const fs::path& file) {
  return file.filename().string().starts_with(kUnfinished);
}

void remove_unfinished(const fs::path& folder) noexcept {
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    if (is_unfinished(entry->path()) && is_own_file(entry->path()) && is_orphan(entry->path()))
      unlink(entry->path().c_str());
  }
}

bool is_own_file(const fs::path& path) noexcept {
  std::error_code error;
  return fs::symlink_status(path, error).type() == fs::file_type::regular;
}

}  // namespace impedraw
