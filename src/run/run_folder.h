// The output folders of commands.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "impedraw/experiment/input_files.h"
#include "impedraw/settings/yaml_read.h"

namespace impedraw {

// Checks that the folder can be made, is empty, or already holds a result of the same kind: a run,
// a comparison, a plan, a table. Throws InputError otherwise. Writes nothing. A run is one whose
// run.h5 has our mark, and that no other process writes.
void require_run_folder(const std::filesystem::path& folder);
// Throws InputError if the folder holds the results of a run that did not stop on a fault: only
// --overwrite replaces them in a folder that was named with --out.
void require_no_finished_run(const std::filesystem::path& folder);
// Throws InputError if folder/run.h5 exists, but is not ours to replace.
void require_own_log(const std::filesystem::path& folder);
void require_comparison_folder(const std::filesystem::path& folder);
// Checks that the folder holds a finished run.
void require_page_folder(const std::filesystem::path& folder);
void require_plan_folder(const std::filesystem::path& folder);

// Throws InputError unless the folder's disk has room for a run that is planned to take `seconds`
// and needs `bytes`.
void require_space(const std::filesystem::path& folder, double bytes, double seconds);

void make_folder(const std::filesystem::path& folder);  // throws InputError on failure

// One process at a time writes into a run's folder.
//
// The lock is the kernel's (flock) on the file run.lock, which stays. It ends with its process,
// however that ends, so that a lock cannot be stale. The file says who holds the lock, or held it
// last.

inline constexpr const char* kLockFile = "run.lock";
inline constexpr const char* kCoverLines = "cover.csv";  // laid before the run begins

class FolderLock {
 public:
  // Throws InputError naming the process that holds the lock.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  // Throws as the constructor, but takes no lock and makes no file.
  static void require_free(const std::filesystem::path& folder);

 private:
  int file_;
};

// The inputs of a run: the log carries its settings and the hashes of its input files, the
// folder has copies of them (inputs/). A run can so be continued and reported wherever its folder
// is, and what has been edited since is noticed.

// The log's attributes for them. Each input has "input <setting>": "<SHA-256> <name in inputs/>".
std::map<std::string, std::string> record_of(const Scenario& scenario,
                                             const std::vector<KeptInput>& inputs);

// Writes scenario.yaml and inputs/.
void write_inputs(const std::filesystem::path& folder, const Scenario& scenario,
                  const std::vector<KeptInput>& inputs);

// The settings with which the run in `folder` was begun: the log's, or scenario.yaml's where an
// older version wrote the log. Throws InputError if there are none.
Scenario recorded_scenario(const std::filesystem::path& folder, Places* places);

// Throws InputError naming the first setting that is another one than the run in `folder` was begun
// with.
void require_same_settings(const Scenario& scenario, const std::filesystem::path& folder);

enum class InputsFrom {
  originals,  // of a run that goes on: the files themselves; the copies where they are gone
  folder      // the copies; the files themselves where copies are gone
};

// Lets the scenario read its inputs from where they are. Throws InputError naming an input that is
// not what the run was started with. Logs of older versions have no hashes: nothing is compared.
void find_inputs(Scenario* scenario, const std::filesystem::path& folder, InputsFrom from);

}  // namespace impedraw
