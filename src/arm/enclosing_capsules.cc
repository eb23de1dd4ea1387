#include "impedraw/arm/enclosing_capsules.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <assimp/Importer.hpp>

#include "impedraw/common/errors.h"
#include "impedraw/common/input_file.h"

namespace impedraw {

namespace {

using Eigen::Vector3d;

constexpr double kWorthwhile = 0.8;
constexpr int kMostCuts = 2;             // one after the other
constexpr std::size_t kLooked = 500;     // points that place the axis; all of them give the radius
constexpr int kRounds = 200;             // error of the axis about 1/200 of the radius
constexpr double kRoundedOff = 1e-6;     // [m]
constexpr std::size_t kLargest = 100e6;  // [bytes]

std::vector<Vector3d> corners(const std::vector<Triangle>& triangles) {
  std::vector<Vector3d> points;
  for (const Triangle& t : triangles) points.insert(points.end(), t.begin(), t.end());
  return points;
}

Eigen::Matrix3d principal_axes(const std::vector<Vector3d>& points) {
  const Eigen::Map<const Eigen::Matrix3Xd> p(points[0].data(), 3,
                                             static_cast<Eigen::Index>(points.size()));
  const Eigen::Matrix3Xd centred = p.colwise() - p.rowwise().mean();
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(centred * centred.transpose())
      .eigenvectors();
}

// The axis' place by Bădoiu and Clarkson's steps towards the farthest point; then the radius, and
// the least length whose rounded ends hold every point.
Capsule along(const std::vector<Vector3d>& points, const Vector3d& axis) {
  const auto across = [&axis](const Vector3d& p) -> Vector3d { return p - axis.dot(p) * axis; };
  const std::size_t step = 1 + points.size() / kLooked;
  Vector3d centre = across(points[0]);
  for (int round = 1; round <= kRounds; ++round) {
    Vector3d farthest = centre;
    for (std::size_t i = 0; i < points.size(); i += step)
      if ((across(points[i]) - centre).squaredNorm() > (farthest - centre).squaredNorm())
        farthest = across(points[i]);
    centre += (farthest - centre) / (round + 1);
  }
  double radius2 = 0.0;
  for (const Vector3d& p : points) radius2 = std::max(radius2, (across(p) - centre).squaredNorm());
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Vector3d& p : points) {
    const double end = std::sqrt(std::max(0.0, radius2 - (across(p) - centre).squaredNorm()));
    low = std::min(low, axis.dot(p) + end);
    high = std::max(high, axis.dot(p) - end);
  }
  if (low > high) low = high = 0.5 * (low + high);
  return {centre + low * axis, centre + high * axis, std::sqrt(radius2) + kRoundedOff};
}

Capsule smallest_capsule(const std::vector<Vector3d>& points) {
  Eigen::Matrix<double, 3, 6> axes;
  axes << principal_axes(points), Eigen::Matrix3d::Identity();
  Capsule best = along(points, axes.col(0));
  for (int i = 1; i < 6; ++i) {
    const Capsule other = along(points, axes.col(i));
    if (other.volume() < best.volume()) best = other;
  }
  return best;
}

double volume_of(const std::vector<Capsule>& capsules) {
  double sum = 0.0;
  for (const Capsule& c : capsules) sum += c.volume();
  return sum;
}

std::vector<Capsule> cut(const std::vector<Triangle>& triangles, int cuts) {
  const std::vector<Vector3d> points = corners(triangles);
  const std::vector<Capsule> whole{smallest_capsule(points)};
  if (cuts == 0) return whole;
  const Vector3d axis = principal_axes(points).col(2);
  const auto at = [&axis](const Triangle& t) { return axis.dot(t[0] + t[1] + t[2]) / 3.0; };
  const auto [low, high] =
      std::minmax_element(triangles.begin(), triangles.end(),
                          [&at](const Triangle& s, const Triangle& t) { return at(s) < at(t); });
  const double middle = 0.5 * (at(*low) + at(*high));
  std::vector<Triangle> halves[2];
  for (const Triangle& t : triangles) halves[at(t) > middle].push_back(t);
  if (halves[0].empty() || halves[1].empty()) return whole;
  std::vector<Capsule> parts = cut(halves[0], cuts - 1);
  for (const Capsule& c : cut(halves[1], cuts - 1)) parts.push_back(c);
  return volume_of(parts) < kWorthwhile * whole[0].volume() ? parts : whole;
}

}  // namespace

double Capsule::volume() const {
  return std::numbers::pi * radius * radius * ((b - a).norm() + 4.0 / 3.0 * radius);
}

std::vector<Capsule> enclosing_capsules(const std::vector<Triangle>& triangles) {
  return cut(triangles, kMostCuts);
}

std::vector<Triangle> read_triangles(const std::filesystem::path& file) {
  const std::size_t bytes = InputFile(file).size();
  if (bytes > kLargest)
    throw InputError(fmt::format("{}: {:.0f} MB, at most 100 MB are read", file.string(),
                                 1e-6 * static_cast<double>(bytes)));
  Assimp::Importer importer;
  // URDF takes a mesh's axes as they are.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene =
      importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_PreTransformVertices);
  if (!scene) throw InputError(fmt::format("{}: {}", file.string(), importer.GetErrorString()));
  std::vector<Triangle> triangles;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    for (unsigned f = 0; f < mesh.mNumFaces; ++f) {
      const aiFace& face = mesh.mFaces[f];
      if (face.mNumIndices != 3) continue;
      Triangle t;
      for (unsigned i = 0; i < 3; ++i) {
        const aiVector3D& p = mesh.mVertices[face.mIndices[i]];
        t[i] = {p.x, p.y, p.z};
      }
      if (t[0].allFinite() && t[1].allFinite() && t[2].allFinite()) triangles.push_back(t);
    }
  }
  if (triangles.empty()) throw InputError(file.string() + ": no triangle");
  return triangles;
}

std::vector<Triangle> box_triangles(const Vector3d& edges) {
  const auto corner = [&edges](int i) -> Vector3d {
    return 0.5 *
           edges.cwiseProduct(Vector3d(i & 1 ? 1.0 : -1.0, i & 2 ? 1.0 : -1.0, i & 4 ? 1.0 : -1.0));
  };
  std::vector<Triangle> triangles;
  for (const auto& f : {std::array{0, 1, 3, 2},
                        {4, 5, 7, 6},
                        {0, 1, 5, 4},
                        {2, 3, 7, 6},
                        {0, 2, 6, 4},
                        {1, 3, 7, 5}})
    for (int half : {1, 2})
      triangles.push_back({corner(f[0]), corner(f[half]), corner(f[half + 1])});
  return triangles;
}

}  // namespace impedraw
