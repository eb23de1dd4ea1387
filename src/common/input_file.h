// Opens the files that a user names. Only regular files are read: a pipe, a socket or a device
// could block for ever or never end.
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <string>

#include "impedraw/common/errors.h"

namespace impedraw {

class InputFile {
 public:
  // Throws InputError "<name>: <why>" unless the file is a regular file that can be read.
  InputFile(const std::filesystem::path& file, const std::string& name) : name_(name) {
    // O_NONBLOCK: a pipe without a writer would block open() itself.
    descriptor_ = open(file.c_str(), O_RDONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
    if (descriptor_ < 0) {
      if (errno == ENOENT || errno == ENOTDIR) fail("no such file");
      fail(errno == ENXIO ? "is a socket or a device, must be a regular file"
                          : std::string("cannot be read: ") + std::strerror(errno));
    }
    struct stat status {};
    if (fstat(descriptor_, &status) == 0 && S_ISREG(status.st_mode)) {
      size_ = static_cast<std::size_t>(status.st_size);
      return;
    }
    const char* kind = S_ISDIR(status.st_mode)    ? "a folder"
                       : S_ISFIFO(status.st_mode) ? "a pipe"
                                                  : "a socket or a device";
    close(descriptor_);
    fail(std::string("is ") + kind + ", must be a regular file");
  }
  explicit InputFile(const std::filesystem::path& file) : InputFile(file, file.string()) {}
  ~InputFile() { close(descriptor_); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  std::size_t size() const { return size_; }  // [bytes], when it was opened

  // The content, at most `most` bytes of it.
  std::string read(std::size_t most) const {
    constexpr std::size_t kBlock = 1 << 20;  // beyond the size: the file may have grown
    std::string text;
    while (text.size() < most) {
      // One byte more than the size: the end shows without growing the text.
      const std::size_t before = text.size(),
                        wanted = before <= size_ ? size_ + 1 - before : kBlock;
      text.resize(before + std::min(wanted, most - before));
      ssize_t n;
      do n = ::read(descriptor_, text.data() + before, text.size() - before);
      while (n < 0 && errno == EINTR);
      if (n < 0) fail(std::string("cannot be read: ") + std::strerror(errno));
      text.resize(before + static_cast<std::size_t>(n));
      if (n == 0) break;
    }
    return text;
  }

 private:
  [[noreturn]] void fail(const std::string& why) const { throw InputError(name_ + ": " + why); }

  std::string name_;
  int descriptor_ = -1;
  std::size_t size_ = 0;
};

// For readers that open the file by themselves.
inline void require_input_file(const std::filesystem::path& file) { InputFile{file}; }

}  // namespace impedraw
