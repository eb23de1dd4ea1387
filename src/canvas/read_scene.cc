#include <algorithm>
#include <cstring>
#include <map>
#include <set>

#include <assimp/BaseImporter.h>
#include <assimp/MemoryIOWrapper.h>
#include <assimp/config.h>
#include <assimp/scene.h>
#include <fmt/format.h>
#include <zlib.h>
#include <Eigen/Geometry>
#include <assimp/DefaultLogger.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <assimp/LogStream.hpp>
#include <nlohmann/json.hpp>

#include "impedraw/canvas/polygon_mesh.h"
#include "impedraw/common/child_process.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/file_extension.h"
#include "impedraw/common/input_file.h"

namespace impedraw {
namespace {

constexpr std::size_t kMostBeside = std::size_t{1} << 30;  // [bytes] of each file that it names
constexpr std::size_t kMostCornersOfAll = 60'000'000;      // of all instances of its meshes

// The file itself, from memory, and those that it names in its folder or below.
class SceneFiles : public Assimp::IOSystem {
 public:
  SceneFiles(std::string_view text, const std::string& name)
      : own("scene" + lower_extension(name)), text_(text), file_(name) {}

  const std::string own;
  std::string missing;

  bool Exists(const char* path) const override { return own == path || !beside(path).empty(); }
  char getOsSeparator() const override { return '/'; }
  void Close(Assimp::IOStream* stream) override { delete stream; }
  Assimp::IOStream* Open(const char* path, const char*) override {
    if (own == path) {
      return new Assimp::MemoryIOStream(reinterpret_cast<const std::uint8_t*>(text_.data()),
                                        text_.size());
    }
    const std::filesystem::path file = beside(path);
    if (file.empty()) missing = path;
    if (file.empty()) return nullptr;
    const std::string text = InputFile(file).read(kMostBeside);
    auto* copy = new std::uint8_t[text.size()];
    std::copy(text.begin(), text.end(), copy);
    return new Assimp::MemoryIOStream(copy, text.size(), true);
  }

 private:
  std::filesystem::path beside(std::string path) const {
    for (std::size_t at; (at = path.find("%20")) != path.npos;) path.replace(at, 3, " ");
    const auto file = file_.parent_path() / path;
    std::error_code error;
    const bool within = !std::filesystem::path(path).is_absolute() && path.find("..") == path.npos;
    return within && std::filesystem::is_regular_file(file, error) ? file : "";
  }

  std::string_view text_;
  std::filesystem::path file_;
};

// Keeps the line that says that Assimp left out a part of the mesh.
class SceneLog : public Assimp::LogStream {
 public:
  explicit SceneLog(std::string* lost) : lost_(lost) {}
  void write(const char* line) override {
    if (std::strstr(line, "dropped")) *lost_ = std::strstr(line, ": ") + 2;
  }

 private:
  std::string* lost_;
};

// Refuses extensions that pack or move vertices: Assimp takes packed vertices for plain ones.
void require_plain_gltf(std::string_view text, const std::string& name) {
  if (text.starts_with("glTF") && text.size() > 20)
    text = text.substr(20, little_endian_u32(text.substr(12)));
  const auto json = nlohmann::json::parse(text, nullptr, false);
  if (!json.is_object()) throw InputError(name + ": its JSON is damaged or cut short");
  for (const std::string list : {"extensionsRequired", "extensionsUsed"}) {
    for (const auto& entry : json.value(list, nlohmann::json::array())) {
      const std::string extension = entry.is_string() ? entry.get<std::string>() : "?";
      const auto is = [&](const char* part) { return extension.find(part) != extension.npos; };
      const bool look = is("_materials_") || is("_texture_") || is("_lights_");
      if (is("compression") || (!look && list == "extensionsRequired")) {
        throw InputError(
            fmt::format("{}: needs the glTF extension {}, which is not read: export it "
                        "without, uncompressed",
                        name, extension));
      }
    }
  }
}

// The quoted value of the attribute `key` of the first tag that begins with `tag`.
std::string_view attribute(std::string_view xml, std::string_view tag, std::string_view key) {
  const std::size_t at = xml.find(tag);
  if (at == xml.npos) return {};
  xml = xml.substr(at, xml.find('>', at) - at);
  for (std::size_t from = 0; (from = xml.find(key, from + 1)) != xml.npos;) {
    const std::string_view value = xml.substr(from + key.size());
    if (std::isspace(static_cast<unsigned char>(xml[from - 1])) && value.size() > 2 &&
        value[0] == '=')
      return value.substr(2, value.find(value[1], 2) - 2);
  }
  return {};
}

// The parts of a 3mf that hold objects, unpacked.
std::vector<std::string> parts_of_3mf(std::string_view zip) {
  std::vector<std::string> parts;
  const auto number = [zip](std::size_t at, int bytes) -> std::size_t {
    return at + 4 > zip.size() ? 0 : unsigned_bytes(zip.substr(at), bytes, false);
  };
  std::size_t at = number(zip.rfind("PK\5\6") + 16, 4);
  for (; zip.substr(std::min(at, zip.size()), 4) == "PK\1\2";
       at += 46 + number(at + 28, 2) + number(at + 30, 2) + number(at + 32, 2)) {
    const std::size_t local = number(at + 42, 4), packed = number(at + 20, 4),
                      from = local + 30 + number(local + 26, 2) + number(local + 28, 2);
    if (!zip.substr(at + 46, number(at + 28, 2)).ends_with(".model") || from > zip.size()) continue;
    const std::string_view data = zip.substr(from, packed);
    parts.emplace_back(number(at + 24, 4), ' ');
    if (number(at + 10, 2) == 0) parts.back() = data;
    if (number(at + 10, 2) == 0) continue;
    z_stream stream{};
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(data.data()));
    stream.avail_in = static_cast<uInt>(data.size());
    stream.next_out = reinterpret_cast<Bytef*>(parts.back().data());
    stream.avail_out = static_cast<uInt>(parts.back().size());
    inflateInit2(&stream, -MAX_WBITS);
    inflate(&stream, Z_FINISH);
    inflateEnd(&stream);
  }
  return parts;
}

// [m]. Assimp ignores it.
double unit_of_3mf(std::string_view text, const std::string& name) {
  static const std::map<std::string_view, double> units{
      {"", 1e-3},       {"micron", 1e-6}, {"millimeter", 1e-3}, {"centimeter", 1e-2},
      {"inch", 0.0254}, {"foot", 0.3048}, {"meter", 1.0}};
  double unit = 0.0;
  for (const std::string& model : parts_of_3mf(text)) {
    if (model.find("p:path=") != model.npos) {
      throw InputError(name +
                       ": has its objects in further parts (3MF's production extension), "
                       "which are not read: export it as STL");
    }
    const auto known = units.find(attribute(model, "<model", "unit"));
    if (known == units.end())
      throw InputError(name + ": has an unknown unit, must be one of 3MF's, such as millimeter");
    unit = known->second;
  }
  if (unit == 0.0) throw InputError(name + ": is damaged, or no archive with a 3D model in it");
  return unit;
}

void add_node(const aiScene& scene, const aiNode& node, const Eigen::Matrix4d& above,
              PolygonMesh* mesh) {
  using RowMajor = Eigen::Matrix<ai_real, 4, 4, Eigen::RowMajor>;
  const Eigen::Matrix4d X =
      above * Eigen::Map<const RowMajor>(&node.mTransformation.a1).cast<double>();
  const Eigen::Matrix3d A = X.topLeftCorner<3, 3>();
  const bool mirrored = A.col(0).cross(A.col(1)).dot(A.col(2)) < 0.0;
  for (unsigned m = 0; m < node.mNumMeshes; ++m) {
    const aiMesh& part = *scene.mMeshes[node.mMeshes[m]];
    const std::size_t base = mesh->vertices.size();
    for (unsigned v = 0; v < part.mNumVertices; ++v) {
      const aiVector3D& p = part.mVertices[v];
      mesh->vertices.push_back((X * Eigen::Vector4d(p.x, p.y, p.z, 1.0)).head<3>());
    }
    for (unsigned f = 0; f < part.mNumFaces; ++f) {
      const aiFace& face = part.mFaces[f];
      if (face.mNumIndices < 3) continue;  // a point or a line
      for (unsigned k = 0; k < face.mNumIndices; ++k) {
        const unsigned v = face.mIndices[mirrored ? face.mNumIndices - 1 - k : k];
        mesh->corners.push_back(v < part.mNumVertices ? static_cast<int>(base + v) : -1);
      }
      mesh->ends.push_back(mesh->corners.size());
    }
    if (std::max(mesh->vertices.size(), mesh->corners.size()) > kMostCornersOfAll)
      throw InputError(
          fmt::format("has more than {} corners: decimate the mesh", kMostCornersOfAll));
  }
  for (unsigned c = 0; c < node.mNumChildren; ++c) add_node(scene, *node.mChildren[c], X, mesh);
}

PolygonMesh import_scene(std::string_view text, const std::string& name) {
  PolygonMesh mesh;
  const std::string ending = lower_extension(name);
  mesh.unit = 1.0;
  if (ending == ".3mf") mesh.unit = unit_of_3mf(text, name);
  if (ending == ".glb" || ending == ".gltf") require_plain_gltf(text, name);
  const std::string_view metres = ending == ".dae" ? attribute(text, "<unit", "meter") : "";
  if (!metres.empty() && (!finite_number(metres, &mesh.unit) || mesh.unit <= 0.0))
    throw InputError(name + ": its unit has no length, must be a positive number of metres");
  Assimp::Importer importer;
  for (std::size_t i = importer.GetImporterCount(); i-- > 0;) {  // no format but the one named
    std::set<std::string> endings;
    importer.GetImporter(i)->GetExtensionList(endings);
    if (!endings.count(ending.substr(1))) importer.UnregisterLoader(importer.GetImporter(i));
  }
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UNIT_SIZE, true);
  std::string lost;
  Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0)
      ->attachStream(new SceneLog(&lost), Assimp::Logger::Warn);
  auto* files = new SceneFiles(text, name);
  importer.SetIOHandler(files);  // takes it
  const aiScene* scene = importer.ReadFile(files->own, 0);
  if (!files->missing.empty()) {
    throw InputError(fmt::format("{}: names '{}', which is not in its folder", name,
                                 files->missing.substr(0, 200)));
  }
  if (!scene) lost = importer.GetErrorString();
  if (lost.find("bad_alloc") != lost.npos) throw std::bad_alloc();
  std::replace(lost.begin(), lost.end(), '\n', ' ');
  if (!lost.empty()) throw InputError(name + ": is damaged or not read: " + lost.substr(0, 400));
  add_node(*scene, *scene->mRootNode, Eigen::Matrix4d::Identity(), &mesh);
  return mesh;
}

// The mesh as its unit and a binary PLY for parse_ply().
std::string ply_of(const PolygonMesh& mesh) {
  std::string ply = fmt::format(
      "{}\nply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty double x\nproperty "
      "double y\nproperty double z\nelement face {}\nproperty list uint int vertex_indices\n"
      "end_header\n",
      mesh.unit, mesh.vertices.size(), mesh.faces());
  const auto put = [&ply](const auto* values, std::size_t count) {
    ply.append(reinterpret_cast<const char*>(values), count * sizeof(*values));
  };
  put(mesh.vertices.data(), mesh.vertices.size());
  for (std::size_t f = 0; f < mesh.faces(); ++f) {
    const auto count = static_cast<std::uint32_t>(mesh.face(f).size());
    put(&count, 1);
    put(mesh.face(f).data(), count);
  }
  return ply;
}

}  // namespace

PolygonMesh parse_scene(std::string_view text, const std::string& name) {
  const std::string result =
      read_in_child(name, "Assimp", [&] { return ply_of(import_scene(text, name)); });
  std::string_view ply = result, unit;
  next_line(&ply, &unit);
  PolygonMesh mesh = parse_ply(ply, name);
  finite_number(unit, &mesh.unit);
  mesh.y_up = lower_extension(name) != ".3mf";  // Assimp turns a dae so
  return mesh;
}

}  // namespace impedraw
