// Work done in processes of its own, several at a time: what hangs, crashes or blows up is one
// piece of work without a result.
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
  std::string text;        // what the work gave
  std::string cause;       // why there is none: "timeout: …", "crashed: …"; empty: there is
  double wall_time = 0.0;  // [s]
};

struct ProcessHooks {
  std::function<void(std::size_t, const ProcessEnd&)> finished;  // as each ends, in no order
  std::function<void()> waiting;                                 // several times a second
  std::function<bool()> interrupted;  // looked at as often: ends what runs, without a result
};

// The pieces 0 … count − 1; each may write one file, whose name it is given. False: interrupted.
// Must be called while the program has one thread. Throws std::runtime_error when no process can be
// started.
bool run_processes(
    std::size_t count,
    const std::function<std::string(std::size_t, const std::filesystem::path&)>& work,
    const ProcessSettings& settings, const ProcessHooks& hooks);

}  // namespace impedraw
