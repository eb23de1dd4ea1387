#include "impedraw/canvas/mesh_file.h"

#include <cmath>
#include <string>
#include <utility>

#include <assimp/DefaultIOSystem.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <fmt/format.h>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>

#include "impedraw/canvas/validate_file.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

constexpr std::size_t kMostTriangles = 20'000'000;

// An OBJ names other files; only the mesh itself is opened.
class OneFile : public Assimp::IOSystem {
 public:
  explicit OneFile(std::string name) : name_(std::move(name)) {}
  bool Exists(const char* file) const override { return name_ == file && disk_.Exists(file); }
  char getOsSeparator() const override { return disk_.getOsSeparator(); }
  Assimp::IOStream* Open(const char* file, const char* mode) override {
    return name_ == file ? disk_.Open(file, mode) : nullptr;
  }
  void Close(Assimp::IOStream* stream) override { disk_.Close(stream); }

 private:
  std::string name_;
  Assimp::DefaultIOSystem disk_;
};

// Faces with an area: lines and points, which an OBJ may hold too, have fewer corners.
template <class Do>
void for_each_face(const aiScene& scene, Do&& visit) {
  for (unsigned m = 0; m < scene.mNumMeshes; ++m) {
    const aiMesh& part = *scene.mMeshes[m];
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      if (part.mFaces[f].mNumIndices >= 3) visit(part, part.mFaces[f]);
    }
  }
}

}  // namespace

TriangleMesh read_mesh(const std::filesystem::path& file, double unit) {
  const std::string name = file.string();
  const std::size_t promised = validate_mesh_file(file);
  if (promised == 0)
    throw InputError(fmt::format("{}: holds no triangle, must hold at least one", name));
  if (promised > kMostTriangles) {
    throw InputError(fmt::format("{}: holds {} faces, at most {} are read: thin the mesh out", name,
                                 promised, kMostTriangles));
  }
  Assimp::Importer importer;
  importer.SetIOHandler(new OneFile(name));  // the importer's from here on
  const aiScene* scene = importer.ReadFile(name, 0);
  if (!scene) throw InputError(fmt::format("{}: {}", name, importer.GetErrorString()));

  std::size_t faces = 0;
  bool polygons = false;
  for_each_face(*scene, [&](const aiMesh& part, const aiFace& face) {
    for (unsigned k = 0; k < face.mNumIndices; ++k) {
      const unsigned v = face.mIndices[k];
      if (v >= part.mNumVertices) {
        throw InputError(fmt::format("{}: face {} names vertex {}, must be in 0 … {}", name, faces,
                                     static_cast<int>(v), part.mNumVertices - 1));
      }
      const aiVector3D& p = part.mVertices[v];
      if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
        throw InputError(fmt::format("{}: face {} has a corner at ({}, {}, {}), must be finite",
                                     name, faces, p.x, p.y, p.z));
      }
    }
    polygons = polygons || face.mNumIndices > 3;
    ++faces;
  });
  if (faces != promised)
    throw InputError(
        fmt::format("{}: {} of its {} faces could be read, must be all", name, faces, promised));
  if (polygons) scene = importer.ApplyPostProcessing(aiProcess_Triangulate);
  if (!scene) throw InputError(fmt::format("{}: {}", name, importer.GetErrorString()));

  TriangleMesh mesh;
  std::size_t triangles = 0, vertices = 0;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    triangles += scene->mMeshes[m]->mNumFaces;
    vertices += scene->mMeshes[m]->mNumVertices;
  }
  mesh.triangles.reserve(triangles);
  mesh.vertices.reserve(vertices);
  const aiMesh* last = nullptr;
  int offset = 0;
  for_each_face(*scene, [&](const aiMesh& part, const aiFace& face) {
    if (&part != last) {
      offset = static_cast<int>(mesh.vertices.size());
      for (unsigned i = 0; i < part.mNumVertices; ++i) {
        const aiVector3D& p = part.mVertices[i];
        mesh.vertices.push_back(unit * Eigen::Vector3d(p.x, p.y, p.z));
      }
      last = &part;
    }
    mesh.triangles.push_back(Eigen::Vector3i(offset + face.mIndices[0], offset + face.mIndices[1],
                                             offset + face.mIndices[2]));
  });
  return mesh;
}

}  // namespace impedraw
