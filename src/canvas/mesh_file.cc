#include "impedraw/canvas/mesh_file.h"

#include <fmt/format.h>

#include "impedraw/canvas/polygon_mesh.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/file_extension.h"
#include "impedraw/common/input_file.h"

namespace impedraw {
namespace {

constexpr std::size_t kMostTriangles = 20'000'000;
constexpr double kFarthest = 1e30;  // [file's unit]; areas and volumes stay finite

std::string read_all(const std::filesystem::path& file) {
  constexpr std::size_t kLargest = std::size_t{1} << 31;  // [bytes]
  const InputFile in(file);
  if (in.size() > kLargest) {
    throw InputError(fmt::format("{}: {:.1f} GiB, at most 2 GiB are read: decimate the mesh",
                                 file.string(), static_cast<double>(in.size()) / 1073741824.0));
  }
  return in.read(kLargest);
}

void require_valid_corners(const PolygonMesh& mesh, const std::string& name) {
  const auto count = static_cast<long>(mesh.vertices.size());
  for (std::size_t f = 0; f < mesh.faces(); ++f) {
    for (const int v : mesh.face(f)) {
      if (v < 0 || v >= count) {
        throw InputError(
            fmt::format("{}: face {} names vertex {}, must be in 0 … {}", name, f, v, count - 1));
      }
      const Eigen::Vector3d& p = mesh.vertices[v];
      if (!(p.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= kFarthest)) {
        throw InputError(
            fmt::format("{}: face {} has a corner at ({}, {}, {}), must be finite and within ± {}",
                        name, f, p.x(), p.y(), p.z(), kFarthest));
      }
    }
  }
}

}  // namespace

bool is_mesh_file(const std::filesystem::path& file) {
  const std::string ending = lower_extension(file);
  return ending == ".obj" || ending == ".stl" || ending == ".ply";
}

TriangleMesh parse_mesh(std::string_view text, const std::string& name, double unit) {
  const std::string ending = lower_extension(name);
  if (!is_mesh_file(name)) {
    throw InputError(
        fmt::format("{}: has the type '{}', must be .obj, .stl or .ply", name, ending));
  }
  if (text.empty())
    throw InputError(fmt::format("{}: the file is empty, must hold triangles", name));
  const auto parse = ending == ".obj" ? parse_obj : ending == ".stl" ? parse_stl : parse_ply;
  PolygonMesh polygons = parse(text, name);
  if (polygons.faces() == 0)
    throw InputError(fmt::format("{}: holds no triangle, must hold at least one", name));
  const std::size_t triangles = polygons.corners.size() - 2 * polygons.faces();
  if (triangles > kMostTriangles) {
    throw InputError(fmt::format("{}: holds {} triangles, at most {} are read: decimate the mesh",
                                 name, triangles, kMostTriangles));
  }
  require_valid_corners(polygons, name);
  TriangleMesh mesh;
  mesh.triangles = triangulate(polygons, name);
  mesh.vertices = std::move(polygons.vertices);
  for (Eigen::Vector3d& p : mesh.vertices) p *= unit;
  return mesh;
}

TriangleMesh read_mesh(const std::filesystem::path& file, double unit) {
  if (!is_mesh_file(file)) return parse_mesh("", file.string(), unit);  // throws for the extension
  return parse_mesh(read_all(file), file.string(), unit);
}

}  // namespace impedraw
