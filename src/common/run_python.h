// Runs one of the program's Python scripts so that the result does not depend on where, by whom and
// in which locale the program was started: isolated from the user's Python settings and packages,
// in UTF-8 mode, with matplotlib's own defaults, in the root folder. Paths must be absolute.
#pragma once

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

extern char** environ;

namespace impedraw {

struct PythonCall {
  std::string python;                  // the interpreter
  std::vector<std::string> arguments;  // the script and its own
  std::filesystem::path said{};        // file for what it prints; empty: where the program prints
  // Where matplotlib keeps its list of fonts. If it cannot be written, a temporary folder is used.
  std::filesystem::path matplotlib_folder{};
};

enum class PythonEnd { succeeded, failed, not_started };

inline PythonEnd run_python(const PythonCall& call) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  fs::path cache = call.matplotlib_folder, scratch;
  if (!cache.empty()) {
    fs::create_directories(cache, ignored);
    if (access(cache.c_str(), W_OK | X_OK) != 0) {
      std::string name = (fs::temp_directory_path(ignored) / "impedraw_python_XXXXXX").string();
      if (mkdtemp(name.data()) != nullptr) cache = scratch = name;
    }
  }
  // A matplotlibrc counts if the working directory, MATPLOTLIBRC or MPLCONFIGDIR has one.
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    if (text.starts_with("MPL") || text.starts_with("MATPLOTLIB")) continue;
    variables.emplace_back(text);
  }
  variables.push_back("MATPLOTLIBRC=/dev/null");
  if (!cache.empty()) variables.push_back("MPLCONFIGDIR=" + cache.string());
  std::vector<std::string> words{call.python, "-I", "-X", "utf8"};
  words.insert(words.end(), call.arguments.begin(), call.arguments.end());
  const auto pointers = [](std::vector<std::string>& strings) {
    std::vector<char*> list;
    for (std::string& s : strings) list.push_back(s.data());
    list.push_back(nullptr);
    return list;
  };

  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addchdir_np(&actions, "/");
  if (!call.said.empty()) {
    posix_spawn_file_actions_addopen(&actions, 1, call.said.c_str(), O_WRONLY | O_CREAT | O_APPEND,
                                     0600);
    posix_spawn_file_actions_adddup2(&actions, 1, 2);
  }
  pid_t child = 0;
  const int error = posix_spawnp(&child, call.python.c_str(), &actions, nullptr,
                                 pointers(words).data(), pointers(variables).data());
  posix_spawn_file_actions_destroy(&actions);
  int status = 0;
  pid_t ended = -1;
  if (error == 0) do {
      ended = waitpid(child, &status, 0);
    } while (ended < 0 && errno == EINTR);
  if (!scratch.empty()) fs::remove_all(scratch, ignored);
  if (error != 0) return PythonEnd::not_started;
  // Without a status (SIGCHLD is ignored) nothing is known of success.
  return ended == child && WIFEXITED(status) && WEXITSTATUS(status) == 0 ? PythonEnd::succeeded
                                                                         : PythonEnd::failed;
}

}  // namespace impedraw
