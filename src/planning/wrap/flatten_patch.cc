#include "impedraw/planning/wrap/flatten_patch.h"

#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>

#include <fmt/format.h>

#include "impedraw/common/cross.h"
#include "impedraw/common/errors.h"
#include "impedraw/files/data_folder.h"
#include "impedraw/files/run_python.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

std::string patch_data(const SurfacePatch& patch) {
  std::string data;
  const auto put = [&data](const auto* values, std::size_t count) {
    data.append(reinterpret_cast<const char*>(values), count * sizeof *values);
  };
  const std::int64_t head[] = {static_cast<std::int64_t>(patch.samples.size()),
                               static_cast<std::int64_t>(patch.triangles.size()), patch.centre};
  put(head, 3);
  for (const SurfaceSample& s : patch.samples) put(s.p_P.data(), 3);
  for (const Eigen::Vector3i& t : patch.triangles) {
    const std::int64_t row[] = {t[0], t[1], t[2]};
    put(row, 3);
  }
  return data;
}

std::string last_line(const std::string& text) {
  std::istringstream in(text);
  std::string last;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

std::string script_file() {
  return (data_folder() / "src/planning/wrap/flatten_patch.py").string();
}

// Runs the script on the patch's data. Returns what it makes of them.
std::string run_script(const std::string& data, const std::filesystem::path& wanted_python) {
  const std::string python =
      (wanted_python.empty() ? python_interpreter() : wanted_python).string();
  const std::string script = script_file();
  const MemoryFile patch(data), flat, said;
  const int code = run_python({.python = python,
                               .arguments = {script, "/dev/fd/3", "/dev/fd/4"},
                               .files = {{&patch, 3}, {&flat, 4}, {&said, 1}, {&said, 2}}});
  if (code < 0) throw InputError(fmt::format("wrap: {} does not start", python));
  if (code == 0) return flat.content();
  const std::string why = last_line(said.content());
  throw InputError(
      fmt::format("wrap: {} failed: {}", script, why.empty() ? "it said nothing" : why));
}

void require_unfolded(const SurfacePatch& patch, const std::vector<Vector2d>& flat) {
  int folded = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3i& t : patch.triangles) {
    if (cross(flat[t[1]] - flat[t[0]], flat[t[2]] - flat[t[0]]) > 0) continue;
    if (folded++ == 0) first = patch.samples[t[0]].p_P;
  }
  if (folded == 0) return;
  throw InputError(fmt::format(
      "wrap: the surface cannot be flattened, {} of {} triangles fold over, the first at ({:.4f}, "
      "{:.4f}) m in "
      "the drawing plane; make the drawing smaller, move it, or set drawing.mapping=project",
      folded, patch.triangles.size(), first.x(), first.y()));
}

}  // namespace

std::vector<Vector2d> flatten_patch(const SurfacePatch& patch,
                                    const std::filesystem::path& python) {
  const std::string made = run_script(patch_data(patch), python);
  std::vector<Vector2d> flat(patch.samples.size());
  const std::size_t size = flat.size() * sizeof(Vector2d);
  if (made.size() != size)
    throw InputError(
        fmt::format("wrap: {} gave {} bytes, not {}", script_file(), made.size(), size));
  std::memcpy(static_cast<void*>(flat.data()), made.data(), size);
  require_unfolded(patch, flat);
  return flat;
}

}  // namespace impedraw
