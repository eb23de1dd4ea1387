// The output folders of commands.
#pragma once

#include <filesystem>
#include <string>

namespace impedraw {

// Checks that the folder can be made, is empty, or already holds a result of the same kind: a run,
// a comparison, a plan, a table. Throws InputError otherwise. Writes nothing.
void require_run_folder(const std::filesystem::path& folder);
void require_comparison_folder(const std::filesystem::path& folder);
void require_plan_folder(const std::filesystem::path& folder);
// `csv`: the name of the file that marks a table's folder.
void require_table_folder(const std::filesystem::path& folder, const std::string& csv);

void make_folder(const std::filesystem::path& folder);  // throws InputError on failure
// Throws std::runtime_error with the reason on failure.
void write_file(const std::filesystem::path& file, const std::string& text);

}  // namespace impedraw
