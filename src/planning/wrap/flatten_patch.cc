#include "impedraw/planning/wrap/flatten_patch.h"

#include <cmath>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>

#include <fmt/format.h>
#include <Eigen/LU>

#include "impedraw/common/cross.h"
#include "impedraw/common/errors.h"
#include "impedraw/files/child_process.h"
#include "impedraw/files/data_folder.h"

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
  return flat;
}

std::vector<int> folded_triangles(const SurfacePatch& patch, const std::vector<Vector2d>& flat) {
  constexpr double kMostStretch = 4.0;  // a sheet that gives 400 % is torn
  std::vector<int> folded;
  for (std::size_t k = 0; k < patch.triangles.size(); ++k) {
    const Eigen::Vector3i& t = patch.triangles[k];
    const Vector2d a = flat[t[1]] - flat[t[0]], b = flat[t[2]] - flat[t[0]];
    const Eigen::Vector3d u = patch.samples[t[1]].p_P - patch.samples[t[0]].p_P,
                          v = patch.samples[t[2]].p_P - patch.samples[t[0]].p_P;
    // Squares of the singular values of the map from the surface to the page: their sum, product.
    Eigen::Matrix2d page, surface;
    page << a.squaredNorm(), a.dot(b), a.dot(b), b.squaredNorm();
    surface << u.squaredNorm(), u.dot(v), u.dot(v), v.squaredNorm();
    const Eigen::Matrix2d ratio = page * surface.inverse();
    const double half = ratio.trace() / 2;
    const double largest = half + std::sqrt(std::max(0.0, half * half - ratio.determinant()));
    const double smallest = ratio.determinant() / largest;
    if (cross(a, b) > 0 && largest < kMostStretch * kMostStretch &&
        smallest > 1 / (kMostStretch * kMostStretch))
      continue;
    folded.push_back(static_cast<int>(k));
  }
  return folded;
}

}  // namespace impedraw
