#include "impedraw/page/page_json.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <fstream>
#include <sstream>

#include <meshoptimizer.h>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

namespace impedraw {
namespace {

using Eigen::Vector3d;

Vector3d area_normal(const std::vector<Vector3d>& vertices, unsigned a, unsigned b, unsigned c) {
  return (vertices[b] - vertices[a]).cross(vertices[c] - vertices[a]);
}

// Collapsed edges leave triangles without an area, and slivers that fold over their neighbours:
// they face away from the surface as it was at their corners, and are turned over. (Without them
// there would be pinholes.)
std::vector<unsigned> unfolded(const std::vector<Vector3d>& vertices,
                               const std::vector<unsigned>& whole,
                               const std::vector<unsigned>& thinned) {
  std::vector<Vector3d> normals(vertices.size(), Vector3d::Zero());
  for (std::size_t i = 0; i + 2 < whole.size(); i += 3) {
    const Vector3d n = area_normal(vertices, whole[i], whole[i + 1], whole[i + 2]);
    for (int k = 0; k < 3; ++k) normals[whole[i + k]] += n;
  }
  std::vector<unsigned> kept;
  for (std::size_t i = 0; i + 2 < thinned.size(); i += 3) {
    const unsigned a = thinned[i], b = thinned[i + 1], c = thinned[i + 2];
    const Vector3d around =
        normals[a].normalized() + normals[b].normalized() + normals[c].normalized();
    const double faces = area_normal(vertices, a, b, c).dot(around);
    if (faces > 0.0) kept.insert(kept.end(), {a, b, c});
    if (faces < 0.0) kept.insert(kept.end(), {a, c, b});
  }
  return kept;
}

constexpr std::size_t kStride = 3 * sizeof(float);

std::vector<float> floats_of(const std::vector<Vector3d>& vertices) {
  std::vector<float> positions;
  positions.reserve(3 * vertices.size());
  for (const Vector3d& v : vertices)
    for (int k = 0; k < 3; ++k) positions.push_back(static_cast<float>(v[k]));
  return positions;
}

std::vector<unsigned> corners_of(const std::vector<Eigen::Vector3i>& triangles) {
  std::vector<unsigned> corners;
  corners.reserve(3 * triangles.size());
  for (const Eigen::Vector3i& triangle : triangles)
    for (int k = 0; k < 3; ++k) corners.push_back(static_cast<unsigned>(triangle[k]));
  return corners;
}

// Leaves out the vertices that no triangle uses.
PageMesh compacted(const std::vector<Vector3d>& vertices, const std::vector<unsigned>& corners) {
  PageMesh mesh;
  std::vector<int> place(vertices.size(), -1);
  for (std::size_t i = 0; i + 2 < corners.size(); i += 3) {
    Eigen::Vector3i triangle;
    for (int k = 0; k < 3; ++k) {
      int& to = place[corners[i + k]];
      if (to < 0) {
        to = static_cast<int>(mesh.vertices.size());
        mesh.vertices.push_back(vertices[corners[i + k]]);
      }
      triangle[k] = to;
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

std::vector<Eigen::Vector3i> coarse_triangles(const PageMesh& mesh, double off) {
  const std::vector<unsigned> corners = corners_of(mesh.triangles);
  const std::vector<float> positions = floats_of(mesh.vertices);
  const double scale = meshopt_simplifyScale(positions.data(), mesh.vertices.size(), kStride);
  if (corners.empty() || !(scale > 0.0)) return {};
  std::vector<unsigned> fewer(corners.size());
  fewer.resize(meshopt_simplify(fewer.data(), corners.data(), corners.size(), positions.data(),
                                mesh.vertices.size(), kStride, 0, static_cast<float>(off / scale),
                                meshopt_SimplifyLockBorder, nullptr));
  fewer = unfolded(mesh.vertices, corners, fewer);
  if (fewer.empty() || 3 * fewer.size() > 2 * corners.size()) return {};
  meshopt_optimizeVertexCache(fewer.data(), fewer.data(), fewer.size(), mesh.vertices.size());
  std::vector<Eigen::Vector3i> coarse;
  for (std::size_t i = 0; i + 2 < fewer.size(); i += 3)
    coarse.push_back(Eigen::Matrix<unsigned, 3, 1>(fewer.data() + i).cast<int>());
  return coarse;
}

}  // namespace

PageMesh page_mesh(const std::vector<Eigen::Vector3d>& vertices,
                   const std::vector<Eigen::Vector3i>& triangles, std::size_t most, double off) {
  std::vector<unsigned> corners = corners_of(triangles);
  double error = 0.0;
  if (triangles.size() > most) {
    const std::vector<float> positions = floats_of(vertices);
    constexpr float kAnyError = 1e-2f;  // of the mesh's extent
    const double scale = meshopt_simplifyScale(positions.data(), vertices.size(), kStride);
    std::vector<unsigned> fewer(corners.size());
    float relative = 0.0f;
    std::size_t n = meshopt_simplify(fewer.data(), corners.data(), corners.size(), positions.data(),
                                     vertices.size(), kStride, 3 * most, kAnyError,
                                     meshopt_SimplifyLockBorder, &relative);
    if (n > 6 * most)
      n = meshopt_simplifySloppy(fewer.data(), corners.data(), corners.size(), positions.data(),
                                 vertices.size(), kStride, 3 * most, 1.0f, &relative);
    fewer.resize(n);
    corners = unfolded(vertices, corners, fewer);
    error = relative * scale;
  }
  // The order of triangles that deflates best is also the one that a graphics card likes best.
  if (!corners.empty())
    meshopt_optimizeVertexCache(corners.data(), corners.data(), corners.size(), vertices.size());
  PageMesh mesh = compacted(vertices, corners);
  mesh.of = triangles.size();
  mesh.error = error;
  mesh.coarse = coarse_triangles(mesh, off);
  return mesh;
}

PageMesh canvas_mesh(const std::vector<Eigen::Vector3d>& vertices,
                     const std::vector<Eigen::Vector3i>& triangles) {
  return page_mesh(vertices, triangles, 16000, 8e-5);  // as coarseOff of web/src/scene.ts
}

namespace {

using Json = nlohmann::json;

constexpr std::size_t kMostCloudPoints = 15000;

Json pose_json(const Pose& X) {
  Json out = Json::array();  // row by row, 3×4
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) out.push_back(X.R(i, k));
    out.push_back(X.p[i]);
  }
  return out;
}

Json number_json(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json arm_json(PackedColumns& columns, const PageContext& context,
              const std::vector<std::string>& joints) {
  Json out = Json::array();
  for (std::size_t i = 0; i < context.arm.size(); ++i) {
    const DrawnLink& link = context.arm[i];
    const auto at = std::find(joints.begin(), joints.end(), link.joint_name);
    const bool moves = link.joint != DrawnLink::Joint::fixed && at != joints.end();
    Json shapes = Json::array();
    for (const VisualShape& shape : link.shapes) {
      static constexpr const char* kNames[] = {"cylinder", "sphere", "box", "mesh"};
      shapes.push_back({{"kind", kNames[static_cast<int>(shape.kind)]},
                        {"pose", pose_json(shape.X_LS)},
                        {"size", vector_json(shape.size)}});
    }
    Json meshes = Json::array();
    for (const PageLinkMesh& mesh : context.meshes)
      if (mesh.link == static_cast<int>(i)) meshes.push_back(mesh_json(columns, mesh.shape));
    out.push_back({{"name", link.name},
                   {"parent", link.parent},
                   {"pose", pose_json(link.X_PL)},
                   {"axis", vector_json(link.axis_L)},
                   {"joint", moves ? static_cast<int>(at - joints.begin()) : -1},
                   {"slides", link.joint == DrawnLink::Joint::prismatic},
                   {"shapes", std::move(shapes)},
                   {"meshes", std::move(meshes)}});
  }
  return out;
}

std::uint64_t zigzag(std::int64_t d) {
  return d < 0 ? 2 * static_cast<std::uint64_t>(-(d + 1)) + 1 : 2 * static_cast<std::uint64_t>(d);
}

// The order of differences that takes the fewest bits.
int best_order(const std::vector<std::int64_t>& k) {
  std::array<std::uint64_t, 3> bits{};
  std::int64_t last = 0, last_step = 0;
  for (const std::int64_t x : k) {
    const std::int64_t step = x - last;
    bits[0] += static_cast<std::uint64_t>(std::bit_width(zigzag(x)));
    bits[1] += static_cast<std::uint64_t>(std::bit_width(zigzag(step)));
    bits[2] += static_cast<std::uint64_t>(std::bit_width(zigzag(step - last_step)));
    last = x;
    last_step = step;
  }
  return static_cast<int>(std::min_element(bits.begin(), bits.end()) - bits.begin());
}

void put_uint32(std::string& bytes, std::uint32_t x) {
  for (int shift = 0; shift < 32; shift += 8) bytes += static_cast<char>((x >> shift) & 0xff);
}

}  // namespace

Json points_json(PackedColumns& columns, const std::vector<Eigen::Vector3d>& points,
                 double quantum) {
  Json out = Json::array();
  for (int axis = 0; axis < 3; ++axis)
    out.push_back(columns.add(
        points.size(), [&](std::size_t i) { return points[i][axis]; }, quantum));
  return out;
}

Json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json numbers_json(const Eigen::VectorXd& v) {
  Json out = Json::array();
  for (const double x : v) out.push_back(number_json(x));
  return out;
}

Json mesh_json(PackedColumns& columns, const PageMesh& mesh) {
  const auto corners = [&columns](const std::vector<Eigen::Vector3i>& of) {
    return columns.add(
        3 * of.size(), [&](std::size_t i) { return static_cast<double>(of[i / 3][i % 3]); }, 1.0);
  };
  Json out;
  out["vertices"] = points_json(columns, mesh.vertices, 2e-5);
  out["triangles"] = corners(mesh.triangles);
  if (!mesh.coarse.empty()) out["coarse"] = corners(mesh.coarse);
  out["of"] = mesh.of;
  out["error_mm"] = 1e3 * mesh.error;
  return out;
}

Json series_json(std::string name, std::string label, std::string unit, Json values) {
  values["name"] = std::move(name);
  values["label"] = std::move(label);
  values["unit"] = std::move(unit);
  return values;
}

Json cloud_json(PackedColumns& columns, const std::vector<Eigen::Vector3d>& cloud,
                const std::vector<int>& colour) {
  const std::size_t step = (cloud.size() + kMostCloudPoints - 1) / kMostCloudPoints;
  std::vector<Eigen::Vector3d> kept;
  std::vector<double> kept_colour;
  for (std::size_t i = 0; i < cloud.size(); i += step) {
    kept.push_back(cloud[i]);
    if (!colour.empty()) kept_colour.push_back(colour[i]);
  }
  return {{"points", points_json(columns, kept, 1e-4)},
          {"colour", columns.add(kept_colour, 1.0)},
          {"of", cloud.size()}};
}

Json pictures_json(PackedColumns& columns, const std::vector<PagePicture>& pictures) {
  Json out = Json::array();
  for (const PagePicture& picture : pictures) {
    const std::string content = text_of_file(picture.file);
    if (content.empty()) continue;
    Json entry = columns.add_bytes(content);
    entry["title"] = picture.title;
    entry["type"] = picture.file.extension() == ".png" ? "image/png" : "image/svg+xml";
    out.push_back(std::move(entry));
  }
  return out;
}

Json no_plots(PackedColumns& columns) {
  return {{"time", columns.add(std::vector<double>{}, 1.0)},
          {"rows_per_point", 1.0},
          {"terms", Json::array()},
          {"series", Json::array()}};
}

Json begun_page(PackedColumns& columns, const char* kind, const std::string& title,
                const RunDescription& run, const PageContext& context, const PageMesh& canvas) {
  Json page;
  page["format"] = 1;
  page["kind"] = kind;
  page["name"] = page["title"] = title;
  page["attributes"] = Json::object();
  for (const auto& [key, value] : run.attributes)
    if (key != "settings" && key != kPromiseAttribute && key != kEndingAttribute &&
        value.size() < 200)
      page["attributes"][key] = value;
  page["joints"] = {{"names", run.joint_names},
                    {"lower", numbers_json(run.joint_lower)},
                    {"upper", numbers_json(run.joint_upper)},
                    {"speed", numbers_json(run.joint_speed_limit)},
                    {"torque", numbers_json(run.torque_limit)}};
  page["modes"] = run.mode_names;
  page["version"] = IMPEDRAW_VERSION;
  page["commit"] = commit();
  page["command"] = context.command;
  page["settings"] = Json::array();
  for (const PageSetting& s : context.settings)
    page["settings"].push_back({s.name, s.value, s.initial, s.unit, s.help});
  page["arm"] = arm_json(columns, context, run.joint_names);
  page["arm_notice"] = context.meshes.empty() ? "" : context.meshes_notice;
  page["cameras"] = Json::array();
  for (const PageCamera& c : context.cameras)
    page["cameras"].push_back({{"pose", pose_json(c.X_WC)},
                               {"fov_y_deg", c.fov_y_deg},
                               {"aspect", static_cast<double>(c.width) / c.height}});
  page["drawing_axis"] = vector_json(context.R_WP.col(2));
  page["drawing_up"] = vector_json(context.R_WP.col(0));
  page["ink_width_mm"] = context.ink_width;
  page["canvas"] = mesh_json(columns, canvas);
  page["cloud"] = cloud_json(columns, run.cloud_points, run.cloud_colour);
  return page;
}

std::string text_of_file(const std::filesystem::path& path) {
  if (path.empty() || !std::filesystem::is_regular_file(path)) return {};
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

nlohmann::json PackedColumns::add(std::size_t n, const std::function<double(std::size_t)>& value,
                                  double quantum) {
  constexpr double kMost = 1e8;  // second differences then fit into 32 bits
  std::vector<std::int64_t> k(n);
  std::vector<std::uint32_t> runs;
  bool in_values = true;
  std::uint32_t run = 0;
  std::int64_t last = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double v = value(i);
    const bool is_value = std::isfinite(v);
    if (is_value != in_values) runs.push_back(run), run = 0, in_values = is_value;
    ++run;
    if (is_value) last = std::llround(std::clamp(v / quantum, -kMost, kMost));
    k[i] = last;
  }
  runs.push_back(run);

  const int order = best_order(k);
  for (int pass = 0; pass < order; ++pass)
    for (std::size_t i = n; i-- > 1;) k[i] -= k[i - 1];
  std::uint64_t most = 0;
  for (const std::int64_t d : k) most = std::max(most, zigzag(d));
  const int planes = std::max(1, (static_cast<int>(std::bit_width(most)) + 7) / 8);

  nlohmann::json how = {
      {"n", n}, {"quantum", quantum}, {"order", order}, {"planes", planes}, {"at", bytes_.size()}};
  for (int plane = 0; plane < planes; ++plane)
    for (const std::int64_t d : k) bytes_ += static_cast<char>((zigzag(d) >> (8 * plane)) & 0xff);
  if (runs.size() > 1) {
    how["runs"] = runs.size();
    how["runs_at"] = bytes_.size();
    for (const std::uint32_t length : runs) put_uint32(bytes_, length);
  }
  return how;
}

nlohmann::json PackedColumns::add(std::span<const double> values, double quantum) {
  return add(
      values.size(), [values](std::size_t i) { return values[i]; }, quantum);
}

nlohmann::json PackedColumns::add_bytes(const std::string& bytes) {
  nlohmann::json how = {{"at", bytes_.size()}, {"bytes", bytes.size()}};
  bytes_ += bytes;
  return how;
}

}  // namespace impedraw
