// Runs a program that reads and writes files in memory, so that nothing is left on the disk
// whatever ends it or us.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

namespace impedraw {

// A file without a name. A child process finds it as /dev/fd/N.
class MemoryFile {
 public:
  explicit MemoryFile(std::string_view content = {});  // throws std::runtime_error
  ~MemoryFile();
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  int descriptor() const { return file_; }
  std::string content() const;

 private:
  int file_ = -1;
};

// The child's descriptor N (`as`) is the file.
struct ChildFile {
  const MemoryFile* file;
  int as;
};

// Runs the program in the root folder and waits for its end. `environment`: its variables, as
// NAME=value; empty: this process's. `check`, if given, is called now and then; if it throws, the
// child is killed. A signal from the terminal goes to this process alone, which decides. Returns
// the exit code; 128 + the signal that ended the child; −1 if it did not start.
int run_child(const std::vector<std::string>& arguments, const std::vector<ChildFile>& files,
              const std::function<void()>& check = {},
              const std::vector<std::string>& environment = {});

// Runs one of the program's Python scripts so that the result does not depend on where, by whom and
// in which locale the program was started: isolated from the user's Python settings and packages,
// in UTF-8 mode, with matplotlib's own defaults, in the root folder. Paths must be absolute.
struct PythonCall {
  std::string python;                  // the interpreter
  std::vector<std::string> arguments;  // the script and its own
  std::vector<ChildFile> files{};
  // matplotlib's folder for its list of fonts. If it cannot be written, a temporary one is used.
  std::filesystem::path matplotlib_folder{};
  std::function<void()> check{};  // as run_child()
};

// Returns what run_child() does.
int run_python(const PythonCall& call);

}  // namespace impedraw
