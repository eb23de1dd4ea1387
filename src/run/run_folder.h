// The output folders of commands.
#pragma once

#include <filesystem>
#include <string>

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

}  // namespace impedraw
