// The folders that commands write into.
#pragma once

#include <filesystem>
#include <string>

namespace impedraw {

// A folder may be written where it can be made, is empty, or holds a run (a comparison, a
// robustness.csv) already. Else throws InputError. Touches nothing.
void require_run_folder(const std::filesystem::path& folder);
void require_comparison_folder(const std::filesystem::path& folder);
void require_plan_folder(const std::filesystem::path& folder);
void require_table_folder(const std::filesystem::path& folder,
                          const std::string& csv);  // new, empty, or holds a file of that name

void make_folder(const std::filesystem::path& folder);  // InputError where it cannot be made
void write_file(
    const std::filesystem::path& file,
    const std::string& text);  // std::runtime_error that says why where it cannot be written

}  // namespace impedraw
