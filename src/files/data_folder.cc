#include "impedraw/files/data_folder.h"

namespace impedraw {
namespace {

std::filesystem::path& folder() {
  static std::filesystem::path path = IMPEDRAW_ROOT;
  return path;
}

std::filesystem::path& interpreter() {
  static std::filesystem::path path = IMPEDRAW_PYTHON;
  return path;
}

}  // namespace

const std::filesystem::path& data_folder() { return folder(); }
void set_data_folder(const std::filesystem::path& path) { folder() = path; }
const std::filesystem::path& python_interpreter() { return interpreter(); }
void set_python_interpreter(const std::filesystem::path& python) { interpreter() = python; }

}  // namespace impedraw
