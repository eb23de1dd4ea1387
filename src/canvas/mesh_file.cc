#include "impedraw/canvas/mesh_file.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <map>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/canvas/polygon_mesh.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/file_extension.h"
#include "impedraw/common/input_file.h"

namespace impedraw {
namespace {

constexpr std::size_t kMostTriangles = 20'000'000;
constexpr char kCloud[] = "is a point cloud, must be made into a mesh (as by MeshLab)";
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

// Text without its byte-order mark. Of UTF-16, `bytes` gets what is ASCII, and "?" for the rest.
std::string_view plain_text(std::string_view text, std::string* bytes) {
  if (text.starts_with("\xef\xbb\xbf")) return text.substr(3);
  const bool little = text.starts_with("\xff\xfe"), big = text.starts_with("\xfe\xff");
  if (!little && !big) return text;
  for (std::size_t at = 2; at + 1 < text.size(); at += 2) {
    const char low = text[at + big], high = text[at + little];
    bytes->push_back(high == 0 && low > 0 ? low : '?');
  }
  return *bytes;
}

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3i;

struct NamedMesh {
  std::filesystem::path file;
  std::optional<Eigen::Vector3d> colour;  // of the faces that are meant [0 … 1]
};

NamedMesh named_mesh(const std::filesystem::path& name) {
  constexpr std::size_t kDigits = 6;
  const std::string text = name.string();
  const std::size_t hash = text.find_last_of('#');
  if (hash == text.npos || text.size() != hash + 1 + kDigits) return {name, std::nullopt};
  unsigned rgb = 0;
  const char* const end = text.data() + text.size();
  if (std::from_chars(end - kDigits, end, rgb, 16).ptr != end) return {name, std::nullopt};
  return {text.substr(0, hash), Eigen::Vector3d(rgb >> 16, rgb >> 8 & 255U, rgb & 255U) / 255.0};
}

// Keeps the triangles of faces of the colour, or that have two corners of it, or three.
void keep_painted(const PolygonMesh& polygons, const Eigen::Vector3d& colour,
                  const std::string& name, TriangleMesh* mesh) {
  constexpr double kSameColour = 0.1;  // of each channel
  const bool by_face = polygons.colours.size() != mesh->vertices.size();
  if (by_face && polygons.face_colours.size() != polygons.faces())
    throw InputError(name +
                     ": neither its vertices nor its faces have colours; valid is a .ply with red, "
                     "green and blue, or an .obj with six numbers for each vertex, or with its "
                     ".mtl file beside it");
  const auto& colours = by_face ? polygons.face_colours : polygons.colours;
  double brightest = 1.0;
  for (const Eigen::Vector3d& c : colours) brightest = std::max(brightest, c.maxCoeff());
  const double scale = brightest > 1.0 ? 255.0 : 1.0;  // some write an .obj with bytes
  const auto of = [&](std::size_t face, int v) -> Eigen::Vector3d {
    return colours[by_face ? face : static_cast<std::size_t>(v)] / scale;
  };
  std::vector<Vector3i> kept;
  std::size_t next = 0;
  for (std::size_t f = 0; f < polygons.faces(); ++f)
    for (std::size_t k = 2; k < polygons.face(f).size(); ++k) {
      const Vector3i& t = mesh->triangles[next++];
      const auto same = [&](int v) {
        return (of(f, v) - colour).cwiseAbs().maxCoeff() <= kSameColour;
      };
      if (std::ranges::count_if(t, same) >= 2) kept.push_back(t);
    }
  mesh->triangles = std::move(kept);
  if (!mesh->triangles.empty()) return;
  std::map<std::string, std::size_t> others;  // of the faces' corners
  for (std::size_t f = 0; f < polygons.faces(); ++f)
    for (const int v : polygons.face(f)) {
      const Vector3i c = (255.0 * of(f, v)).array().round().cast<int>();
      if (c.minCoeff() >= 0) ++others[fmt::format("#{:02x}{:02x}{:02x}", c[0], c[1], c[2])];
    }
  const auto most = std::ranges::max_element(others, {}, [](const auto& o) { return o.second; });
  throw InputError(fmt::format("{}: no face has that colour; of {} colours {} is the commonest",
                               name, others.size(), others.empty() ? "none" : most->first));
}

using Parser = PolygonMesh (*)(std::string_view, const std::string&);
Parser parser_of(const std::filesystem::path& file) {
  static constexpr std::pair<const char*, Parser> kParsers[] = {
      {".obj", parse_obj},   {".stl", parse_stl},    {".ply", parse_ply},   {".off", parse_off},
      {".glb", parse_scene}, {".gltf", parse_scene}, {".3mf", parse_scene}, {".dae", parse_scene}};
  const std::string ending = lower_extension(named_mesh(file).file);
  for (const auto& [known, parser] : kParsers)
    if (ending == known) return parser;
  return nullptr;
}

Parser require_parser(const std::filesystem::path& file) {
  if (const Parser parser = parser_of(file)) return parser;
  const std::string ending = lower_extension(file);
  for (const char* cloud : {".xyz", ".pcd", ".pts", ".ptx", ".las", ".laz", ".e57"}) {
    if (ending == cloud) throw InputError(fmt::format("{}: {}", file.string(), kCloud));
  }
  throw InputError(
      fmt::format("{}: has the type '{}', a mesh must be {}", file.string(), ending, kMeshFiles));
}

constexpr std::size_t kMostCorners = 2000;  // ear clipping takes up to n³ steps

double cross(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

// The outline projected along its mean normal, counter-clockwise.
std::vector<Vector2d> flattened(const std::vector<Vector3d>& vertices, std::span<const int> face) {
  const Vector3d& origin = vertices[face[0]];
  Vector3d normal = Vector3d::Zero();
  for (std::size_t i = 1; i + 1 < face.size(); ++i)
    normal += (vertices[face[i]] - origin).cross(vertices[face[i + 1]] - origin);
  const Vector3d u = normal.normalized().unitOrthogonal(), v = normal.normalized().cross(u);
  std::vector<Vector2d> outline;
  for (const int i : face)
    outline.emplace_back(u.dot(vertices[i] - origin), v.dot(vertices[i] - origin));
  return outline;
}

bool is_fan(const std::vector<Vector2d>& outline) {
  for (std::size_t i = 1; i + 1 < outline.size(); ++i) {
    if (!(cross(outline[0], outline[i], outline[i + 1]) > 0)) return false;
  }
  return true;
}

// True if the triangle at the k-th of the corners `left` lies inside the outline.
bool is_ear(const std::vector<Vector2d>& outline, const std::vector<int>& left, std::size_t k) {
  const std::size_t n = left.size();
  const Vector2d &a = outline[left[(k + n - 1) % n]], &b = outline[left[k]],
                 &c = outline[left[(k + 1) % n]];
  if (!(cross(a, b, c) > 0)) return false;
  for (const int i : left) {
    const Vector2d& p = outline[i];
    if (p == a || p == b || p == c) continue;
    if (cross(a, b, p) >= 0 && cross(b, c, p) >= 0 && cross(c, a, p) >= 0) return false;
  }
  return true;
}

}  // namespace

bool is_mesh_file(const std::filesystem::path& file) { return parser_of(file) != nullptr; }

bool says_frame(const std::filesystem::path& file) { return parser_of(file) == parse_scene; }

TriangleMesh parse_mesh(std::string_view text, const std::string& name, const MeshReading& reading,
                        std::vector<std::string>* warnings) {
  const Parser parse = require_parser(name);
  const NamedMesh named = named_mesh(name);
  const auto fail = [&](const std::string& what) { throw InputError(name + ": " + what); };
  if (text.empty()) fail("the file is empty, must hold triangles");
  static constexpr std::pair<std::string_view, const char*> kHeads[] = {
      {"glTF", ".glb"}, {"ply\n", ".ply"}, {"ply\r", ".ply"}, {"OFF\n", ".off"}};
  for (const auto& [head, ending] : kHeads)
    if (text.starts_with(head) && lower_extension(named.file) != ending)
      fail(fmt::format("holds what a {} file holds, must be named so", ending));
  if (text.starts_with("PK\3\4") && lower_extension(name) != ".3mf")
    fail("is a zip archive, must be unpacked (or named .3mf, if it is one)");
  if (text.starts_with("\x1f\x8b")) fail("is packed by gzip, must be unpacked");
  std::string bytes;
  PolygonMesh polygons =
      parse(says_frame(name) ? text : plain_text(text, &bytes), named.file.string());
  if (polygons.faces() == 0) {
    throw InputError(fmt::format(
        "{}: holds no triangle{}", name,
        polygons.vertices.empty()
            ? ", must hold at least one"
            : fmt::format(": its {} points have no faces. A point cloud, or lines, must be made "
                          "into a mesh (as by MeshLab)",
                          polygons.vertices.size())));
  }
  const std::size_t triangles = polygons.corners.size() - 2 * polygons.faces();
  if (triangles > kMostTriangles) {
    throw InputError(fmt::format("{}: holds {} triangles, at most {} are read: decimate the mesh",
                                 name, triangles, kMostTriangles));
  }
  require_valid_corners(polygons, name);
  TriangleMesh mesh;
  mesh.triangles = triangulate(polygons, name);
  mesh.vertices = std::move(polygons.vertices);
  const double unit = reading.unit.value_or(polygons.unit > 0.0 ? polygons.unit : 1.0);
  const bool turn = says_frame(name) ? polygons.y_up : reading.y_up;
  for (Eigen::Vector3d& p : mesh.vertices)
    p = unit * (turn ? Eigen::Vector3d(p.x(), 0.0 - p.z(), p.y()) : p);
  if (reading.recentre) {
    Eigen::AlignedBox3d box;  // of what the triangles use
    for (const Eigen::Vector3i& t : mesh.triangles)
      for (const int v : t) box.extend(mesh.vertices[v]);
    const Eigen::Vector3d origin(box.center().x(), box.center().y(), box.min().z());
    for (Eigen::Vector3d& p : mesh.vertices) p -= origin;
  }
  if (named.colour) keep_painted(polygons, *named.colour, name, &mesh);
  if (warnings)
    std::move(polygons.warnings.begin(), polygons.warnings.end(), std::back_inserter(*warnings));
  return mesh;
}

TriangleMesh read_mesh(const std::filesystem::path& file, const MeshReading& reading,
                       std::vector<std::string>* warnings) {
  require_parser(file);  // before a large file of another kind is read
  return parse_mesh(read_all(named_mesh(file).file), file.string(), reading, warnings);
}

std::vector<Vector3i> triangulate(const PolygonMesh& mesh, const std::string& name) {
  std::vector<Vector3i> triangles;
  triangles.reserve(mesh.corners.size() - 2 * mesh.faces());
  for (std::size_t f = 0; f < mesh.faces(); ++f) {
    const std::span<const int> face = mesh.face(f);
    std::vector<int> left;  // corners not cut off yet
    if (face.size() > 3) {
      const std::vector<Vector2d> outline = flattened(mesh.vertices, face);
      if (!is_fan(outline)) {
        if (face.size() > kMostCorners) {
          throw InputError(fmt::format("{}: face {} has {} corners and is not convex, at most {}",
                                       name, f, face.size(), kMostCorners));
        }
        for (std::size_t i = 0; i < face.size(); ++i) left.push_back(static_cast<int>(i));
        std::size_t passed = 0;  // corners since the last ear; if all, no ear exists
        for (std::size_t k = 1; left.size() > 3 && passed < left.size();) {
          k %= left.size();
          if (!is_ear(outline, left, k)) {
            ++k, ++passed;
            continue;
          }
          const std::size_t n = left.size();
          triangles.emplace_back(face[left[(k + n - 1) % n]], face[left[k]],
                                 face[left[(k + 1) % n]]);
          left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
          passed = 0;
        }
      }
    }
    const auto corner = [&](std::size_t i) { return face[left.empty() ? i : left[i]]; };
    const std::size_t rest = left.empty() ? face.size() : left.size();
    for (std::size_t i = 1; i + 1 < rest; ++i)
      triangles.emplace_back(corner(0), corner(i), corner(i + 1));
  }
  return triangles;
}

}  // namespace impedraw
