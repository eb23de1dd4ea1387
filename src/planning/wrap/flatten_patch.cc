#include "impedraw/planning/wrap/flatten_patch.h"

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/run_python.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

// A unique folder under the system's temporary one, removed with this object.
struct ScratchFolder {
  ScratchFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "impedraw_wrap_XXXXXX").string();
    if (mkdtemp(name.data()) == nullptr)
      throw InputError(fmt::format("wrap: no temporary folder can be made as {}", name));
    path = name;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  std::filesystem::path path;
};

void write_patch(const SurfacePatch& patch, const std::filesystem::path& file) {
  std::ofstream out(file, std::ios::binary);
  const auto put = [&out](const auto* values, std::size_t count) {
    out.write(reinterpret_cast<const char*>(values),
              static_cast<std::streamsize>(count * sizeof *values));
  };
  const std::int64_t head[] = {static_cast<std::int64_t>(patch.samples.size()),
                               static_cast<std::int64_t>(patch.triangles.size()), patch.centre};
  put(head, 3);
  for (const SurfaceSample& s : patch.samples) put(s.p_P.data(), 3);
  for (const Eigen::Vector3i& t : patch.triangles) {
    const std::int64_t row[] = {t[0], t[1], t[2]};
    put(row, 3);
  }
  if (!out.flush()) throw InputError(fmt::format("wrap: cannot write {}", file.string()));
}

std::string last_line(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::string last;
  for (std::string line; std::getline(in, line);) {
    if (!line.empty()) last = line;
  }
  return last;
}

// Runs the script on the folder; its output goes to a file there.
void run_script(const std::filesystem::path& folder, const std::filesystem::path& wanted_python) {
  const std::string python = wanted_python.empty() ? IMPEDRAW_PYTHON : wanted_python.string();
  const std::filesystem::path said = folder / "said.txt";
  const PythonEnd end = run_python({python, {IMPEDRAW_FLATTEN_SCRIPT, folder.string()}, said, {}});
  if (end == PythonEnd::not_started)
    throw InputError(fmt::format("wrap: {} does not start", python));
  if (end == PythonEnd::succeeded) return;
  const std::string why = last_line(said);
  throw InputError(fmt::format("wrap: {} failed: {}", IMPEDRAW_FLATTEN_SCRIPT,
                               why.empty() ? "it said nothing" : why));
}

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

void require_unfolded(const SurfacePatch& patch, const std::vector<Vector2d>& flat) {
  int folded = 0;
  Eigen::Vector3d first = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3i& t : patch.triangles) {
    if (cross(flat[t[1]] - flat[t[0]], flat[t[2]] - flat[t[0]]) > 0) continue;
    if (folded++ == 0) first = patch.samples[t[0]].p_P;
  }
  if (folded == 0) return;
  throw InputError(fmt::format(
      "wrap: the surface cannot be laid flat, {} of {} triangles fold over, the first at ({:.4f}, "
      "{:.4f}) m in "
      "the drawing plane; a smaller drawing, another place or the mapping `project` does without",
      folded, patch.triangles.size(), first.x(), first.y()));
}

}  // namespace

std::vector<Vector2d> flatten_patch(const SurfacePatch& patch,
                                    const std::filesystem::path& python) {
  const ScratchFolder scratch;
  write_patch(patch, scratch.path / "patch.bin");
  run_script(scratch.path, python);
  std::vector<Vector2d> flat(patch.samples.size());
  std::ifstream in(scratch.path / "flat.bin", std::ios::binary);
  const auto size = static_cast<std::streamsize>(flat.size() * sizeof(Vector2d));
  if (!in.read(reinterpret_cast<char*>(flat.data()), size) ||
      in.peek() != std::ifstream::traits_type::eof()) {
    throw InputError(
        fmt::format("wrap: {} left no flat.bin of {} bytes", IMPEDRAW_FLATTEN_SCRIPT, size));
  }
  require_unfolded(patch, flat);
  return flat;
}

}  // namespace impedraw
