// Meshes written by hand for the tests of what reads them.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

class MeshFiles : public ::testing::Test {
 protected:
  MeshFiles() {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ = std::filesystem::temp_directory_path() /
              (std::string("impedraw-") + test->name() + "-" + std::to_string(getpid()));
    std::filesystem::create_directories(folder_);
  }
  ~MeshFiles() override { std::filesystem::remove_all(folder_); }

  std::string write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name, std::ios::binary) << text;
    return (folder_ / name).string();
  }

  std::filesystem::path folder_;
};

// A box from the origin to (a, b, c), outward; 12 triangles, two a side: −z, +z, −y, +y, −x, +x.
inline TriangleMesh box(double a, double b, double c) {
  TriangleMesh m;
  for (int i = 0; i < 8; ++i) m.vertices.push_back({i & 1 ? a : 0, i & 2 ? b : 0, i & 4 ? c : 0});
  m.triangles = {{0, 2, 1}, {1, 2, 3}, {4, 5, 6}, {5, 7, 6}, {0, 1, 4}, {1, 5, 4},
                 {2, 6, 3}, {3, 6, 7}, {0, 4, 2}, {2, 4, 6}, {1, 3, 5}, {3, 7, 5}};
  return m;
}

template <class T>
std::string bytes(T value, bool big_endian = false) {
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  std::string text(raw, sizeof(T));
  return big_endian ? std::string(text.rbegin(), text.rend()) : text;
}

inline std::string obj(const TriangleMesh& m) {
  std::string text = "# by hand\no box\n";
  for (const auto& p : m.vertices)
    text += fmt::format("v {:.9g} {:.9g} {:.9g}\n", p.x(), p.y(), p.z());
  for (const auto& t : m.triangles)
    text += fmt::format("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1);
  return text;
}

inline std::string text_stl(const TriangleMesh& m) {
  std::string text = "solid box\n";
  for (const auto& t : m.triangles) {
    text += "  facet normal 0 0 0\n    outer loop\n";
    for (const int v : t) {
      const auto& p = m.vertices[v];
      text += fmt::format("      vertex {:.9g} {:.9g} {:.9g}\n", p.x(), p.y(), p.z());
    }
    text += "    endloop\n  endfacet\n";
  }
  return text + "endsolid box\n";
}

inline std::string binary_stl(const TriangleMesh& m, std::string header = "solid it is not") {
  header.resize(80, ' ');
  std::string text = header + bytes(static_cast<std::uint32_t>(m.triangles.size()));
  for (const auto& t : m.triangles) {
    text += std::string(12, '\0');
    for (const int v : t)
      for (const double x : m.vertices[v]) text += bytes(static_cast<float>(x));
    text += std::string(2, '\0');
  }
  return text;
}

inline std::string ply(const TriangleMesh& m, const std::string& format) {
  std::string text = fmt::format(
      "ply\nformat {} 1.0\ncomment by hand\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\n"
      "element face {}\nproperty list uchar int vertex_indices\nend_header\n",
      format, m.vertices.size(), m.triangles.size());
  const bool big = format == "binary_big_endian";
  for (const auto& p : m.vertices) {
    if (format == "ascii")
      text += fmt::format("{:.9g} {:.9g} {:.9g}\n", p.x(), p.y(), p.z());
    else
      for (const double x : p) text += bytes(static_cast<float>(x), big);
  }
  for (const auto& t : m.triangles) {
    if (format == "ascii")
      text += fmt::format("3 {} {} {}\n", t[0], t[1], t[2]);
    else {
      text += '\3';
      for (const int v : t) text += bytes(static_cast<std::int32_t>(v), big);
    }
  }
  return text;
}

}  // namespace impedraw
