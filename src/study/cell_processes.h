// Runs pieces of work in separate processes, several at a time. A piece that hangs or crashes only
// loses its own result.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>

namespace impedraw {

struct ProcessSettings {
  int jobs = 1;
  double time_limit = 120.0;      // of a piece, wall time [s]
  std::filesystem::path scratch;  // a folder for files that are removed as each piece ends
};

struct ProcessEnd {
  std::string text;        // the result
  std::string cause;       // why there is no result: "timeout: …", "crashed: …"; empty: success
  double wall_time = 0.0;  // [s]
};

struct ProcessHooks {
  std::function<void(std::size_t, const ProcessEnd&)> finished;  // as each ends, in no order
  std::function<void()> waiting;                                 // several times a second
  std::function<bool()> interrupted;  // polled as often; true ends all pieces without a result
};

// Runs the pieces 0 … count − 1. Each may write one file, under the given name. Returns false if
// interrupted. The program must have a single thread. Throws std::runtime_error if no process can
// be started.
bool run_processes(
    std::size_t count,
    const std::function<std::string(std::size_t, const std::filesystem::path&)>& work,
    const ProcessSettings& settings, const ProcessHooks& hooks);

}  // namespace impedraw
