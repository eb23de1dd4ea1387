#include "impedraw/arm/enclosing_capsules.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <Eigen/Eigenvalues>
#include <assimp/Importer.hpp>

#include "impedraw/common/child_process.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/input_file.h"

namespace impedraw {
namespace {

using Eigen::Matrix3Xd;
using Eigen::Vector3d;

double volume(const std::vector<Capsule>& capsules) {
  double sum = 0.0;
  for (const Capsule& c : capsules)
    sum += c.radius * c.radius * ((c.b - c.a).norm() + 4.0 / 3.0 * c.radius);
  return sum;
}

// Along column i of R: midway between the extents across it, with the least length whose rounded
// ends hold every point.
Capsule along(const Matrix3Xd& points, const Eigen::Matrix3d& R, int i) {
  Matrix3Xd p = R.transpose() * points;
  const Vector3d middle = 0.5 * (p.rowwise().minCoeff() + p.rowwise().maxCoeff());
  p.colwise() -= middle;
  const Eigen::ArrayXd across2 =
      p.colwise().squaredNorm().transpose().array() - p.row(i).transpose().array().square();
  const Eigen::ArrayXd end = (across2.maxCoeff() - across2).sqrt();
  double low = (p.row(i).transpose().array() + end).minCoeff(),
         high = (p.row(i).transpose().array() - end).maxCoeff();
  if (low > high) low = high = 0.5 * (low + high);
  return {R * middle + low * R.col(i), R * middle + high * R.col(i),
          std::sqrt(std::max(0.0, across2.maxCoeff())) + 1e-6};
}

// The corners of all triangles, as bytes after a space.
std::string corners_of(const std::filesystem::path& file) {
  Assimp::Importer importer;
  // URDF takes a mesh's axes as they are.
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);
  const aiScene* scene =
      importer.ReadFile(file.string(), aiProcess_Triangulate | aiProcess_PreTransformVertices);
  if (!scene) throw InputError(importer.GetErrorString());
  std::string corners = " ";
  for (unsigned m = 0; m < scene->mNumMeshes; ++m)
    for (unsigned f = 0; f < scene->mMeshes[m]->mNumFaces; ++f) {
      const aiFace& face = scene->mMeshes[m]->mFaces[f];
      Triangle t;
      for (unsigned i = 0; i < 3 && face.mNumIndices == 3; ++i) {
        const aiVector3D& p = scene->mMeshes[m]->mVertices[face.mIndices[i]];
        t[i] = {p.x, p.y, p.z};
      }
      if (face.mNumIndices == 3 && (t[0] + t[1] + t[2]).allFinite())
        corners.append(reinterpret_cast<const char*>(&t), sizeof(t));
    }
  if (corners.size() == 1) throw InputError("no triangle");
  return corners;
}

}  // namespace

std::vector<Capsule> enclosing_capsules(const std::vector<Triangle>& triangles, int cuts) {
  const Eigen::Map<const Matrix3Xd> points(triangles[0][0].data(), 3,
                                           3 * static_cast<Eigen::Index>(triangles.size()));
  const Matrix3Xd centred = points.colwise() - points.rowwise().mean();
  const Eigen::Matrix3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(centred * centred.transpose()).eigenvectors();
  std::vector<Capsule> whole{along(points, axes, 0)};
  for (const Eigen::Matrix3d& R : {axes, Eigen::Matrix3d(Eigen::Matrix3d::Identity())})
    for (int i = 0; i < 3; ++i)
      if (const Capsule other = along(points, R, i); volume({other}) < volume(whole))
        whole = {other};
  if (cuts == 0) return whole;
  const auto at = [&axes](const Triangle& t) { return axes.col(2).dot(t[0] + t[1] + t[2]); };
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Triangle& t : triangles) low = std::min(low, at(t)), high = std::max(high, at(t));
  std::vector<Triangle> halves[2];
  for (const Triangle& t : triangles) halves[2.0 * at(t) > low + high].push_back(t);
  if (halves[0].empty() || halves[1].empty()) return whole;
  std::vector<Capsule> parts = enclosing_capsules(halves[0], cuts - 1);
  for (const Capsule& c : enclosing_capsules(halves[1], cuts - 1)) parts.push_back(c);
  return volume(parts) < 0.8 * volume(whole) ? parts : whole;
}

std::vector<Triangle> read_triangles(const std::filesystem::path& file) {
  if (InputFile(file).size() > 100'000'000) throw InputError("more than 100 MB");
  const std::string corners =
      read_in_child(file.string(), "Assimp", [&file] { return corners_of(file); });
  std::vector<Triangle> triangles(corners.size() / sizeof(Triangle));
  std::memcpy(static_cast<void*>(triangles.data()), corners.data() + 1,
              triangles.size() * sizeof(Triangle));
  return triangles;
}

}  // namespace impedraw
