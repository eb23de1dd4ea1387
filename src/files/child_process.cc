#include "impedraw/files/child_process.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <thread>

extern char** environ;

namespace impedraw {
namespace {

[[noreturn]] void fail() {
  throw std::runtime_error(std::string("no file in memory can be made: ") + std::strerror(errno));
}

namespace fs = std::filesystem;

// The folder, or a temporary one that is removed again where it cannot be written.
class CacheFolder {
 public:
  explicit CacheFolder(const fs::path& wanted) : path_(wanted) {
    if (path_.empty()) return;
    std::error_code ignored;
    fs::create_directories(path_, ignored);
    if (access(path_.c_str(), W_OK | X_OK) == 0) return;
    std::string name = (fs::temp_directory_path(ignored) / "impedraw_python_XXXXXX").string();
    if (mkdtemp(name.data()) != nullptr) path_ = scratch_ = name;
  }
  ~CacheFolder() {
    std::error_code ignored;
    if (!scratch_.empty()) fs::remove_all(scratch_, ignored);
  }
  CacheFolder(const CacheFolder&) = delete;
  CacheFolder& operator=(const CacheFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_, scratch_;
};

}  // namespace

MemoryFile::MemoryFile(std::string_view content) {
  const int file = memfd_create("impedraw", MFD_CLOEXEC);
  if (file < 0) fail();
  file_ = fcntl(file, F_DUPFD_CLOEXEC, 16);  // beyond the numbers that a child gets
  close(file);
  if (file_ < 0) fail();
  for (std::size_t at = 0; at < content.size();) {
    const ssize_t n =
        pwrite(file_, content.data() + at, content.size() - at, static_cast<off_t>(at));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) {
      const int error = errno;
      close(file_);
      errno = error;
      fail();
    }
    at += static_cast<std::size_t>(n);
  }
}

MemoryFile::~MemoryFile() { close(file_); }

std::string MemoryFile::content() const {
  struct stat status {};
  fstat(file_, &status);
  std::string content(static_cast<std::size_t>(status.st_size), '\0');
  for (std::size_t at = 0; at < content.size();) {
    const ssize_t n =
        pread(file_, content.data() + at, content.size() - at, static_cast<off_t>(at));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) fail();
    at += static_cast<std::size_t>(n);
  }
  return content;
}

int run_child(const std::vector<std::string>& arguments, const std::vector<ChildFile>& files,
              const std::function<void()>& check, const std::vector<std::string>& environment) {
  const auto pointers = [](const std::vector<std::string>& texts) {
    std::vector<char*> list;
    for (const std::string& text : texts) list.push_back(const_cast<char*>(text.c_str()));
    list.push_back(nullptr);
    return list;
  };
  const std::vector<char*> words = pointers(arguments), variables = pointers(environment);
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  posix_spawn_file_actions_init(&actions);
  posix_spawnattr_init(&attributes);
  posix_spawn_file_actions_addchdir_np(&actions, "/");
  for (const auto& [file, as] : files)
    posix_spawn_file_actions_adddup2(&actions, file->descriptor(), as);
  posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  posix_spawnattr_setpgroup(&attributes, 0);
  pid_t child = 0;
  const int error = posix_spawnp(&child, words[0], &actions, &attributes, words.data(),
                                 environment.empty() ? environ : variables.data());
  posix_spawn_file_actions_destroy(&actions);
  posix_spawnattr_destroy(&attributes);
  if (error != 0) return -1;
  int status = 0;
  try {
    for (pid_t ended = 0; ended == 0;) {
      ended = waitpid(child, &status, check ? WNOHANG : 0);
      if (ended < 0 && errno == EINTR) ended = 0;
      if (ended < 0) return -1;
      if (check) check();
      if (ended == 0) std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  } catch (...) {
    kill(-child, SIGKILL);  // its group: a shell's own children, too
    waitpid(child, nullptr, 0);
    throw;
  }
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

int run_python(const PythonCall& call) {
  const CacheFolder cache(call.matplotlib_folder);
  // A matplotlibrc counts if the working directory, MATPLOTLIBRC or MPLCONFIGDIR has one.
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    if (!text.starts_with("MPL") && !text.starts_with("MATPLOTLIB")) variables.emplace_back(text);
  }
  variables.push_back("MATPLOTLIBRC=/dev/null");
  if (!cache.path().empty()) variables.push_back("MPLCONFIGDIR=" + cache.path().string());
  std::vector<std::string> words{call.python, "-I", "-X", "utf8"};
  words.insert(words.end(), call.arguments.begin(), call.arguments.end());
  return run_child(words, call.files, call.check, variables);
}

}  // namespace impedraw
