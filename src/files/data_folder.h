// The folder of the program's own data: scenarios/, models/, artwork/. It is the source tree,
// unless the Python package, which brings a copy, says otherwise.
#pragma once

#include <filesystem>

namespace impedraw {

const std::filesystem::path& data_folder();

// Before anything else is called; not thread-safe.
void set_data_folder(const std::filesystem::path& folder);

// The interpreter for the program's own scripts.
const std::filesystem::path& python_interpreter();
void set_python_interpreter(const std::filesystem::path& python);

}  // namespace impedraw
