// Runs one of the program's Python scripts so that the result does not depend on where, by whom and
// in which locale the program was started: isolated from the user's Python settings and packages,
// in UTF-8 mode, with matplotlib's own defaults, in the root folder. Paths must be absolute.
#pragma once

#include <filesystem>

#include "impedraw/files/child_process.h"

namespace impedraw {

struct PythonCall {
  std::string python;                  // the interpreter
  std::vector<std::string> arguments;  // the script and its own
  std::vector<ChildFile> files{};
  // Where matplotlib keeps its list of fonts. If it cannot be written, a temporary folder is used.
  std::filesystem::path matplotlib_folder{};
  std::function<void()> check{};  // as run_child()
};

// Returns what run_child() does.
int run_python(const PythonCall& call);

}  // namespace impedraw
