// Files of scenes and what scanners write beside the standard: each against a box or square whose
// corners are known.
#include <cstdlib>
#include <filesystem>
#include <functional>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "impedraw/canvas/mesh_check.h"
#include "impedraw/common/errors.h"
#include "mesh_checks.h"
#include "mesh_files.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string refused(const std::function<void()>& read) {
  try {
    read();
  } catch (const InputError& error) {
    return error.what();
  }
  return "nothing was refused";
}

class SceneFile : public MeshFiles {
 protected:
  std::string refusal_of(const std::string& name, const std::string& text) {
    return refused([&] { load_mesh(write(name, text), {}); });
  }
  CheckedMesh load(const std::string& name, const std::string& text,
                   const MeshReading& reading = {}) {
    return load_mesh(write(name, text), reading);
  }
};

void expect_box(const CheckedMesh& mesh, const Vector3d& low, const Vector3d& high) {
  EXPECT_LT((mesh.bounds.min() - low).norm(), 1e-6) << mesh.bounds.min().transpose();
  EXPECT_LT((mesh.bounds.max() - high).norm(), 1e-6) << mesh.bounds.max().transpose();
}

// ---- glTF: 0.3 m along x, 0.1 m along y, facing z, in two places, one of them mirrored.

std::string square_buffer() {
  std::string buffer;
  for (const float x : {0.f, 0.f, 0.f, .3f, 0.f, 0.f, .3f, .1f, 0.f, 0.f, .1f, 0.f})
    buffer += bytes(x);
  for (const std::uint16_t i : {0, 1, 2, 0, 2, 3}) buffer += bytes(i);
  return buffer;
}

json square_scene() {
  return json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0, "translation": [1, 2, 3], "children": [1]},
              {"mesh": 0, "scale": [-1, 1, 1]}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "buffers": [{"byteLength": 60}],
    "bufferViews": [{"buffer": 0, "byteLength": 48},
                    {"buffer": 0, "byteOffset": 48, "byteLength": 12}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
                   "min": [0, 0, 0], "max": [0.3, 0.1, 0]},
                  {"bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR"}]})");
}

std::string glb(const json& scene, std::string buffer = square_buffer()) {
  std::string text = scene.dump();
  text.resize((text.size() + 3) / 4 * 4, ' ');
  const auto u32 = [](std::size_t n) { return bytes(static_cast<std::uint32_t>(n)); };
  return "glTF" + u32(2) + u32(28 + text.size() + buffer.size()) + u32(text.size()) + "JSON" +
         text + u32(buffer.size()) + std::string("BIN\0", 4) + buffer;
}

std::string with_buffer(const std::string& uri) {
  json scene = square_scene();
  scene["buffers"][0]["uri"] = uri;
  return scene.dump();
}

// y up: (x, y, z) of the file is (x, −z, y) of the world. Both squares face +z of the file, −y.
void expect_two_squares(const CheckedMesh& mesh) {
  EXPECT_EQ(mesh.given_triangles, 4u);
  expect_box(mesh, {0.7, -3, 2}, {1.3, -3, 2.1});
  EXPECT_NEAR(area(mesh.mesh), 0.06, 1e-6);
  for (const auto& t : mesh.mesh.triangles) EXPECT_LT(cross(mesh.mesh, t).y(), 0.0);
  EXPECT_THAT(mesh.warnings, IsEmpty());
}

TEST_F(SceneFile, GltfIsInMetresWithYUpAndItsNodesPlaceItsMeshes) {
  expect_two_squares(load("a.glb", glb(square_scene())));
  expect_two_squares(load("a.gltf", with_buffer("data:application/octet-stream;base64,"
                                                "AAAAAAAAAAAAAAAAmpmZPgAAAAAAAAAAmpmZPs3MzD0AAAAA"
                                                "AAAAAM3MzD0AAAAAAAABAAIAAAACAAMA")));
  write("a b.bin", square_buffer());
  expect_two_squares(load("b.gltf", with_buffer("a%20b.bin")));
  json picture = square_scene();  // a picture that is missing is not needed
  picture["images"] = {{{"uri", "gone.png"}}};
  picture["extensionsRequired"] = {"KHR_materials_unlit", "KHR_texture_transform"};
  expect_two_squares(load("c.glb", glb(picture)));
  MeshReading mm;
  mm.unit = 1e-3;
  mm.recentre = true;
  expect_box(load("a.glb", glb(square_scene()), mm), {-3e-4, 0, 0}, {3e-4, 0, 1e-4});
}

TEST_F(SceneFile, GltfThatCannotBeReadIsRefusedByName) {
  const auto required = [&](const char* extension) {
    json scene = square_scene();
    scene["extensionsRequired"] = {extension};
    return refusal_of("a.glb", glb(scene));
  };
  for (const char* extension : {"KHR_draco_mesh_compression", "EXT_meshopt_compression",
                                "KHR_mesh_quantization", "EXT_mesh_gpu_instancing"})
    EXPECT_THAT(required(extension), HasSubstr(extension));
  EXPECT_THAT(refusal_of("a.gltf", with_buffer("gone.bin")), HasSubstr("names 'gone.bin'"));
  EXPECT_THAT(refusal_of("a.gltf", with_buffer("/etc/hostname")), HasSubstr("/etc/hostname"));
  EXPECT_THAT(refusal_of("a.gltf", with_buffer("../secret.bin")), HasSubstr("../secret.bin"));
  json points = square_scene();
  points["meshes"][0]["primitives"] = {{{"attributes", {{"POSITION", 0}}}, {"mode", 0}}};
  EXPECT_THAT(refusal_of("a.glb", glb(points)), HasSubstr("point cloud"));
  std::string far = square_buffer();
  far.back() = 9;
  EXPECT_THAT(refusal_of("a.glb", glb(square_scene(), far)), HasSubstr("out-of-range"));
  EXPECT_THAT(refusal_of("a.glb", "PK\3\4"), HasSubstr("zip"));
  const std::string whole = glb(square_scene());
  for (std::size_t n = 0; n < whole.size(); n += 31)
    EXPECT_THROW(load("cut.glb", whole.substr(0, n)), InputError) << n;
}

TEST_F(SceneFile, HostileGltfIsRefused) {
  json cycle = square_scene(), deep = square_scene(), huge = square_scene();
  cycle["nodes"] = {{{"children", {1}}}, {{"children", {0}}, {"mesh", 0}}};
  EXPECT_THAT(refusal_of("a.glb", glb(cycle)), HasSubstr("recursive"));
  deep["nodes"] = json::array();
  for (int i = 1; i < 200'000; ++i) deep["nodes"].push_back({{"children", {i}}});
  deep["nodes"].push_back({{"mesh", 0}});
  EXPECT_THAT(refusal_of("a.glb", glb(deep)), HasSubstr("crashed"));  // the process that reads it
  huge["accessors"][0]["count"] = 2'000'000'000;
  EXPECT_THAT(refusal_of("a.glb", glb(huge)), HasSubstr("out of range"));
  EXPECT_THAT(refusal_of("a.gltf", std::string(100'000, '[')), HasSubstr("JSON is damaged"));
}

// ---- 3MF

// An archive of files that are stored as they are.
std::string zip(const std::vector<std::pair<std::string, std::string>>& files) {
  const auto u16 = [](std::size_t n) { return bytes(static_cast<std::uint16_t>(n)); };
  const auto u32 = [](std::size_t n) { return bytes(static_cast<std::uint32_t>(n)); };
  std::string text, central;
  for (const auto& [name, content] : files) {
    std::uint32_t crc = ~0u;
    for (const unsigned char c : content) {
      crc ^= c;
      for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xedb88320u : 0u);
    }
    const std::string common = u16(0) + u16(0) + u32(0) + u32(~crc) + u32(content.size()) +
                               u32(content.size()) + u16(name.size()) + u16(0);
    central += "PK\1\2" + u16(20) + u16(20) + common + u16(0) + u16(0) + u16(0) + u32(0) +
               u32(text.size()) + name;
    text += "PK\3\4" + u16(20) + common + name + content;
  }
  return text + central + "PK\5\6" + u16(0) + u16(0) + u16(files.size()) + u16(files.size()) +
         u32(central.size()) + u32(text.size()) + u16(0);
}

// Object 1 is the square of glTF; 2 is 1, turned by 90°; 2 stands at (10, 20, 30), 1 at the origin.
std::string square_3mf(const std::string& unit, const std::string& more = "") {
  const std::string model =
      "<?xml version=\"1.0\"?>\n<model" + unit +
      " xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\"><resources><object "
      "id=\"1\"><mesh><vertices><vertex x=\"0\" y=\"0\" z=\"0\"/><vertex x=\"0.3\" y=\"0\" "
      "z=\"0\"/><vertex x=\"0.3\" y=\"0.1\" z=\"0\"/><vertex x=\"0\" y=\"0.1\" z=\"0\"/>"
      "</vertices><triangles><triangle v1=\"0\" v2=\"1\" v3=\"2\"/><triangle v1=\"0\" v2=\"2\" "
      "v3=\"3\"/></triangles></mesh></object><object id=\"2\"><components><component "
      "objectid=\"1\" transform=\"0 1 0 -1 0 0 0 0 1 0 0 0\"/></components></object>" +
      more +
      "</resources><build><item objectid=\"2\" transform=\"1 0 0 0 1 0 0 0 1 10 20 30\"/><item "
      "objectid=\"1\"/></build></model>";
  return zip(
      {{"_rels/.rels",
        "<?xml version=\"1.0\"?><Relationships xmlns=\"http://schemas.openxmlformats.org/package/"
        "2006/relationships\"><Relationship Target=\"/3D/3dmodel.model\" Id=\"r\" Type=\"http://"
        "schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/></Relationships>"},
       {"3D/3dmodel.model", model}});
}

TEST_F(SceneFile, A3mfIsPlacedByItsBuildAndScaledByItsUnit) {
  const std::pair<const char*, double> units[] = {
      {" unit=\"inch\"", 0.0254}, {"", 1e-3}, {"\n unit='centimeter'", 1e-2}};
  for (const auto& [unit, metres] : units) {
    const CheckedMesh mesh = load("a.3mf", square_3mf(unit));
    EXPECT_EQ(mesh.given_triangles, 4u);
    expect_box(mesh, {0, 0, 0}, metres * Vector3d(10, 20.3, 30));
    EXPECT_NEAR(area(mesh.mesh), 0.06 * metres * metres, 1e-4 * metres * metres);
  }
  EXPECT_THAT(refusal_of("a.3mf", square_3mf(" unit=\"furlong\"")), HasSubstr("unit"));
  EXPECT_THAT(refusal_of("a.3mf", square_3mf("",
                                             "<object id=\"5\"><components><component "
                                             "p:path=\"/3D/o.model\"/></components></object>")),
              HasSubstr("production extension"));
  EXPECT_THAT(refusal_of("a.3mf", zip({{"a.txt", "x"}})), HasSubstr("no archive with a 3D model"));
  EXPECT_THAT(refusal_of("a.stl", square_3mf("")), HasSubstr("zip archive"));
  EXPECT_THAT(refusal_of("a.stl", "glTF\2"), HasSubstr("what a .glb file holds"));
  EXPECT_THAT(refusal_of("a.obj", "ply\r\n"), HasSubstr("what a .ply file holds"));
}

// ---- Collada

std::string square_dae(const std::string& asset) {
  return "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" "
         "version=\"1.4.1\"><asset>" +
         asset +
         "</asset><library_geometries><geometry id=\"g\"><mesh><source id=\"p\"><float_array "
         "id=\"a\" count=\"12\">0 0 0 .3 0 0 .3 .1 0 0 .1 0</float_array><technique_common>"
         "<accessor source=\"#a\" count=\"4\" stride=\"3\"><param name=\"X\" type=\"float\"/>"
         "<param name=\"Y\" type=\"float\"/><param name=\"Z\" type=\"float\"/></accessor>"
         "</technique_common></source><vertices id=\"v\"><input semantic=\"POSITION\" "
         "source=\"#p\"/></vertices><polylist count=\"1\"><input semantic=\"VERTEX\" source=\"#v\" "
         "offset=\"0\"/><vcount>4</vcount><p>0 1 2 3</p></polylist></mesh></geometry>"
         "</library_geometries><library_visual_scenes><visual_scene id=\"s\"><node><translate>1 0 "
         "5</translate><instance_geometry url=\"#g\"/></node></visual_scene>"
         "</library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>";
}

TEST_F(SceneFile, ADaeSaysItsUnitAndWhichAxisIsUp) {
  const std::string cm = "<unit name=\"centimeter\" meter=\"0.01\"/>";
  expect_box(load("z.dae", square_dae(cm + "<up_axis>Z_UP</up_axis>")), {0.01, 0, 0.05},
             {0.013, 0.001, 0.05});
  expect_box(load("y.dae", square_dae(cm + "<up_axis>Y_UP</up_axis>")), {0.01, -0.05, 0},
             {0.013, -0.05, 0.001});
  expect_box(load("none.dae", square_dae("")), {1, -5, 0}, {1.3, -5, 0.1});
  expect_box(load("z.dae", square_dae(cm + "<up_axis>Z_UP</up_axis>"), 0.1), {0.1, 0, 0.5},
             {0.13, 0.01, 0.5});
  EXPECT_THAT(refusal_of("u.dae", square_dae("<unit meter=\"0\"/>")), HasSubstr("unit"));
  EXPECT_THAT(refusal_of("c.dae", square_dae(cm).substr(0, 700)), HasSubstr("malformed"));
}

// ---- OFF

TEST_F(SceneFile, AnOffMayHaveColoursCommentsAndLargeFaces) {
  std::string disc = "COFF # of a scanner\r\n12 1 0\r\n";
  for (int i = 0; i < 12; ++i)
    disc += fmt::format("{} {} 0  255 0 0\r\n", std::cos(M_PI / 6 * i), std::sin(M_PI / 6 * i));
  disc += "\n12 0 1 2 3 4 5 6 7 8 9 10 11  0.5 0.5 0.5";
  const CheckedMesh mesh = load("a.off", disc);
  EXPECT_EQ(mesh.given_triangles, 10u);
  EXPECT_NEAR(area(mesh.mesh), 3.0, 1e-5);  // 12 · sin(30°)/2
  EXPECT_EQ(load("b.off", "OFF 3 1 3\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n").given_triangles, 1u);
  EXPECT_THAT(refusal_of("v.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n"),
              HasSubstr("truncated in vertex 2"));
  EXPECT_THAT(refusal_of("f.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n"),
              HasSubstr("truncated in face 0"));
  EXPECT_THAT(refusal_of("i.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"),
              HasSubstr("names vertex 3"));
  EXPECT_THAT(refusal_of("c.off", "OFF\n1 0 0\n0 0 0\n"), HasSubstr("point cloud"));
}

// ---- What text editors and scanners do to OBJ, STL and PLY

TEST_F(SceneFile, TextHasAnyMarkCodingAndLineEnd) {
  const std::string lf =
      "v 0 0 0\nv 0.3 0 0 1 1 1\nv 0.3 0.1 0\nv 0 0.1 0\nvt 0 0\nf 1/1 2/1 3/1\nf -4 -2 -1\n";
  const auto ends = [&lf](const std::string& end) {
    std::string text;
    for (const char c : lf) text += c == '\n' ? end : std::string(1, c);
    return text;
  };
  const auto utf16 = [&lf](bool big) {
    std::string text = big ? "\xfe\xff" : "\xff\xfe";
    for (const char c : lf) text += big ? std::string{'\0', c} : std::string{c, '\0'};
    return text;
  };
  for (const std::string& text :
       {lf, "\xef\xbb\xbf" + lf, ends("\r\n"), ends("\r"), utf16(false), utf16(true)}) {
    const CheckedMesh mesh = load("a.obj", text);
    EXPECT_EQ(mesh.given_triangles, 2u);
    expect_box(mesh, {0, 0, 0}, {0.3, 0.1, 0});
  }
  std::string mac = ply(box(1, 2, 3), "binary_little_endian");
  std::replace(mac.begin(), mac.begin() + static_cast<long>(mac.find("end_header") + 11), '\n',
               '\r');
  expect_box(load("mac.ply", mac), {0, 0, 0}, {1, 2, 3});
}

TEST_F(SceneFile, AnObjsCommentsEndALineAndAreNotContinued) {
  const CheckedMesh mesh = load("a.obj",
                                "# C:\\scans\\\nv 0 0 0#first\nv 0.3 0 0 \\ \n# in between\nv 0.3 "
                                "0.1 0\nv 0 0.1 0\nf 1/1 2/2 "
                                "\\\n 3/3#x\nf -4//1 -2//2 -1//3# end \\\n");
  EXPECT_EQ(mesh.given_triangles, 2u);
  EXPECT_NEAR(area(mesh.mesh), 0.03, 1e-9);
}

TEST_F(SceneFile, AnStlWithAWrongCountOrEndIsReadWithAWarning) {
  const TriangleMesh m = box(0.1, 0.25, 0.4);
  const std::string good = binary_stl(m);
  const auto counted = [&good](std::uint32_t count) {
    return good.substr(0, 80) + bytes(count) + good.substr(84);
  };
  const auto expect_whole = [&](const std::string& text, const std::string& warning) {
    const CheckedMesh mesh = load("a.stl", text);
    EXPECT_TRUE(mesh.closed) << warning;
    EXPECT_EQ(mesh.given_triangles, 12u) << warning;
    EXPECT_THAT(mesh.warnings, ElementsAre(HasSubstr(warning)));
  };
  expect_whole(good + "....", "4 bytes follow the 12 triangles");
  expect_whole(good + std::string(100, '\0'), "100 bytes follow the 12 triangles");
  expect_whole(good + std::string(50, 'x'), "50 bytes follow the 12 triangles");
  expect_whole(counted(0), "declares 0 triangles, 12 are there");
  expect_whole(counted(0) + "..", "declares 0 triangles, 12 are there");
  expect_whole(counted(5), "declares 5 triangles, 12 are there");
  expect_whole(counted(~0u), "declares 4294967295 triangles, 12 are there");
  std::string text = text_stl(m);
  const std::string end = "endsolid box";
  for (const std::string written : {"end solid box", "endsolidbox", "END SOLID"}) {
    std::string odd = text;
    expect_whole(odd.replace(odd.rfind(end), end.size(), written), "is read as endsolid");
  }
  EXPECT_THAT(load("b.stl", "\xef\xbb\xbf\n " + text).warnings, IsEmpty());
  expect_whole(text + "\nexported by a program\n", "'exported by a program' follows endsolid");
  EXPECT_THAT(refusal_of("a.stl", text + "\nsolid second\n"), HasSubstr("truncated"));
}

TEST_F(SceneFile, StripsOfAPlyAlternateAndBeginAnew) {
  // A strip of three triangles in the plane z = 0, all counter-clockwise; a restart; one more.
  const std::vector<std::int32_t> strip = {0, 1, 2, 3, 4, -1, 5, 6, 7};
  const std::vector<Eigen::Vector2d> points = {{0, 0}, {1, 0}, {0, 1}, {1, 1},
                                               {0, 2}, {5, 0}, {6, 0}, {5, 1}};
  for (const bool big : {false, true}) {
    std::string text = fmt::format(
        "ply\nformat {} 1.0\nelement vertex 8\nproperty double x\nproperty double y\nproperty "
        "uchar "
        "z\nelement material 0\nelement tristrips 1\nproperty list ushort int "
        "vertex_indices\nend_header\n",
        big ? "binary_big_endian" : "ascii");
    for (const auto& p : points)
      text += big ? bytes(p.x(), true) + bytes(p.y(), true) + '\0'
                  : fmt::format("{} {} 0\n", p.x(), p.y());
    text += big ? bytes(std::uint16_t{9}, true) : "9";
    for (const std::int32_t i : strip) text += big ? bytes(i, true) : fmt::format(" {}", i);
    const CheckedMesh mesh = load("a.ply", text);
    EXPECT_EQ(mesh.given_triangles, 4u);
    EXPECT_NEAR(area(mesh.mesh), 2.0, 1e-12);
    for (const auto& t : mesh.mesh.triangles) EXPECT_GT(cross(mesh.mesh, t).z(), 0.0);
  }
}

TEST_F(SceneFile, APointCloudIsCalledOne) {
  const std::string cloud =
      "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
      "z\nend_header\n0 0 0\n";
  EXPECT_THAT(refusal_of("a.ply", cloud), HasSubstr("point cloud"));
  EXPECT_THAT(refusal_of("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"), HasSubstr("point cloud"));
  EXPECT_THAT(refusal_of("a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n"), HasSubstr("2 points have no"));
  for (const char* name : {"a.xyz", "a.pcd", "a.LAS"})
    EXPECT_THAT(refusal_of(name, "0 0 0\n"), HasSubstr("point cloud"));
}

// ---- Where a mesh stands

TEST_F(SceneFile, AMeshThatStandsUprightAsYIsNoticed) {
  const auto turned = [](TriangleMesh m) {  // z up to y up
    for (Vector3d& p : m.vertices) p = Vector3d(p.x(), p.z(), -p.y());
    return m;
  };
  const auto shifted = [](TriangleMesh m, const Vector3d& by) {
    for (Vector3d& p : m.vertices) p += by;
    return m;
  };
  TriangleMesh sheet;  // open, facing z
  sheet.vertices = {{0, 0, 5}, {80, 0, 5}, {80, 320, 5}, {0, 320, 20}};
  sheet.triangles = {{0, 1, 2}, {0, 2, 3}};
  const TriangleMesh figure = shifted(box(80, 80, 320), {-40, -40, 0});  // stands on z = 0
  for (const TriangleMesh& m : {sheet, figure}) {
    EXPECT_THAT(load("z.obj", obj(m), 1e-3).warnings, IsEmpty());
    const std::string y = obj(turned(m));
    EXPECT_THAT(load("y.obj", y, 1e-3).warnings, ElementsAre(HasSubstr("stands upright as y")));
    MeshReading up(1e-3);
    up.y_up = true;
    const CheckedMesh accepted = load("y.obj", y, up);
    EXPECT_THAT(accepted.warnings, IsEmpty());
    EXPECT_LT((accepted.bounds.min() - load("z.obj", obj(m), 1e-3).bounds.min()).norm(), 1e-9);
  }
  EXPECT_THAT(load("y.obj", obj(turned(figure))).warnings,
              ElementsAre(HasSubstr(
                  "stands upright as y; 0.32 m high if the unit is mm: canvas.mesh.up=y")));
}

TEST_F(SceneFile, CoordinatesOfAMapAreRecentredOnRequest) {
  const std::string map =
      "v 500000.0 5200000.0 412.0\nv 500000.0 5200000.3 412.0\nv 500000.3 5200000.0 412.0\nv "
      "500000.3 5200000.3 412.02\nf 1 3 4 2\n";
  EXPECT_THAT(load("utm.obj", map).warnings, ElementsAre(HasSubstr("canvas.mesh.recentre=true")));
  MeshReading centred;
  centred.recentre = true;
  const CheckedMesh mesh = load("utm.obj", map, centred);
  EXPECT_THAT(mesh.warnings, IsEmpty());
  expect_box(mesh, {-0.15, -0.15, 0}, {0.15, 0.15, 0.02});
}

}  // namespace
}  // namespace impedraw
