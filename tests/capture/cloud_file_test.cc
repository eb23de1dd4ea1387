// Point clouds from files, written here by hand in every format.
#include "impedraw/capture/cloud_file.h"

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>
#include <random>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "../scratch_folder.h"
#include "impedraw/capture/capture_cloud.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

using Eigen::Vector3d;
using ::testing::HasSubstr;
using CloudFolder = ScratchFolder;

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

struct Sample {
  float x, y, z, nx, ny, nz;
  std::uint8_t r, g, b;
};
const std::vector<Sample> kSamples = {{0.5f, -0.25f, 0.125f, 0, 0, 1, 255, 0, 7},
                                      {kNan, kNan, kNan, kNan, kNan, kNan, 0, 0, 0},
                                      {0.75f, 0.5f, 0.25f, 0, 1, 0, 1, 128, 254}};

template <class T>
void put(std::string* out, T value, bool big_endian = false) {
  char raw[sizeof value];
  std::memcpy(raw, &value, sizeof value);
  if (big_endian) std::reverse(std::begin(raw), std::end(raw));
  out->append(raw, sizeof value);
}

std::string ply(bool ascii, bool big_endian) {
  std::string out = fmt::format(
      "ply\r\nformat {} 1.0\r\ncomment a, b\r\nelement vertex 3\r\nproperty double x\r\nproperty "
      "float y\r\nproperty float z\r\nproperty uchar red\r\nproperty uchar green\r\nproperty uchar "
      "blue\r\nproperty float nx\r\nproperty float ny\r\nproperty float nz\r\nelement face "
      "0\r\nproperty list uchar int vertex_indices\r\nend_header\r\n",
      ascii        ? "ascii"
      : big_endian ? "binary_big_endian"
                   : "binary_little_endian");
  for (const Sample& s : kSamples) {
    if (ascii) {
      out += fmt::format("{} {} {} {} {} {} {} {} {}\n", s.x, s.y, s.z, s.r, s.g, s.b, s.nx, s.ny,
                         s.nz);
      continue;
    }
    put(&out, static_cast<double>(s.x), big_endian);
    for (const float v : {s.y, s.z}) put(&out, v, big_endian);
    for (const std::uint8_t v : {s.r, s.g, s.b}) put(&out, v);
    for (const float v : {s.nx, s.ny, s.nz}) put(&out, v, big_endian);
  }
  return out;
}

// Literal runs, but for a reference where the last 4 bytes come again.
std::string compressed(const std::string& in) {
  std::string out;
  for (std::size_t i = 0; i < in.size();) {
    if (i >= 4 && i + 4 <= in.size() && in.substr(i, 4) == in.substr(i - 4, 4)) {
      out += {static_cast<char>((4 - 2) << 5), static_cast<char>(3)};
      i += 4;
    } else {
      const std::size_t n = std::min<std::size_t>(4, in.size() - i);
      out += static_cast<char>(n - 1) + in.substr(i, n);
      i += n;
    }
  }
  return out;
}

std::string pcd(const std::string& data, const std::string& viewpoint = "1 2 3 1 0 0 0") {
  std::string out = fmt::format(
      "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z _ rgb normal_x normal_y normal_z\nSIZE 4 4 4 2 4 4 4 "
      "4\nTYPE F F F U F F F F\nCOUNT 1 1 1 3 1 1 1 1\nWIDTH 3\nHEIGHT 1\nVIEWPOINT {}\nPOINTS "
      "3\nDATA {}\n",
      viewpoint, data);
  std::vector<std::string> columns(8);
  std::string rows;
  for (const Sample& s : kSamples) {
    const std::uint32_t packed = s.r << 16 | s.g << 8 | s.b;
    float rgb;
    std::memcpy(&rgb, &packed, 4);
    if (data == "ascii")
      out += fmt::format("{} {} {} 9 9 9 {} {} {} {}\n", s.x, s.y, s.z, rgb, s.nx, s.ny, s.nz);
    std::vector<std::string> fields(8);
    put(&fields[0], s.x), put(&fields[1], s.y), put(&fields[2], s.z);
    fields[3] = "padded";
    put(&fields[4], rgb);
    put(&fields[5], s.nx), put(&fields[6], s.ny), put(&fields[7], s.nz);
    for (std::size_t i = 0; i < 8; ++i) rows += fields[i], columns[i] += fields[i];
  }
  if (data == "binary") return out + rows;
  if (data == "ascii") return out;
  std::string all;
  for (const std::string& column : columns) all += column;
  const std::string small = compressed(all);
  put(&out, static_cast<std::uint32_t>(small.size()));
  put(&out, static_cast<std::uint32_t>(all.size()));
  return out + small;
}

std::string xyz() {
  std::string out = "3\n# x y z r g b nx ny nz\n";
  for (const Sample& s : kSamples)
    out +=
        fmt::format("{} {} {} {} {} {} {} {} {}\n", s.x, s.y, s.z, s.r, s.g, s.b, s.nx, s.ny, s.nz);
  return out;
}

std::vector<std::pair<std::string, std::string>> every_format() {
  return {{"a.ply", ply(true, false)},
          {"little.ply", ply(false, false)},
          {"big.PLY", ply(false, true)},
          {"a.pcd", pcd("ascii")},
          {"b.pcd", pcd("binary")},
          {"c.pcd", pcd("binary_compressed")},
          {"a.xyz", xyz()}};
}

TEST(CloudFile, EveryFormatTellsTheSamePoints) {
  for (const auto& [name, text] : every_format()) {
    SCOPED_TRACE(name);
    const CloudFile cloud = parse_cloud_file(text, name);
    EXPECT_EQ(cloud.invalid, 1u);
    ASSERT_EQ(cloud.points.size(), 2u);
    EXPECT_EQ(cloud.points[0], Vector3d(0.5, -0.25, 0.125));
    EXPECT_EQ(cloud.points[1], Vector3d(0.75, 0.5, 0.25));
    ASSERT_EQ(cloud.normals.size(), 2u);
    EXPECT_EQ(cloud.normals[1], Vector3d(0, 1, 0));
    EXPECT_EQ(cloud.rgb, (std::vector<std::uint8_t>{255, 0, 7, 1, 128, 254}));
    EXPECT_EQ(cloud.viewpoints,
              name.ends_with(".pcd") ? std::vector{Vector3d(1, 2, 3)} : std::vector<Vector3d>{});
  }
  EXPECT_TRUE(parse_cloud_file(pcd("binary", "0 0 0 1 0 0 0"), "b.pcd").viewpoints.empty());
}

// As PCL writes them: a camera behind the vertices of a PLY, a viewpoint for each point of a PCD.
TEST(CloudFile, SeveralViewpoints) {
  const CloudFile ply = parse_cloud_file(
      "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\nproperty float "
      "z\nelement camera 2\nproperty float view_px\nproperty float view_py\nproperty float "
      "view_pz\nproperty int viewportx\nend_header\n1 2 3\n4 5 6\n0.5 0 1 640\n-0.5 0 1 640\n",
      "a.ply");
  EXPECT_EQ(ply.viewpoints, (std::vector{Vector3d(0.5, 0, 1), Vector3d(-0.5, 0, 1)}));
  EXPECT_TRUE(ply.seen_from.empty());
  const CloudFile pcd = parse_cloud_file(
      "FIELDS x y z vp_x vp_y vp_z\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\nCOUNT 1 1 1 1 1 1\nWIDTH "
      "3\nHEIGHT 1\nPOINTS 3\nDATA ascii\n1 2 3 0 0 1\n1 2 4 0 0 2\n1 2 5 0 0 1\n",
      "a.pcd");
  EXPECT_EQ(pcd.viewpoints, (std::vector{Vector3d(0, 0, 1), Vector3d(0, 0, 2)}));
  EXPECT_EQ(pcd.seen_from, (std::vector{0, 1, 0}));
}

TEST(CloudFile, AnXyzNamesItsColumnsByItsFirstPoint) {
  const CloudFile intensity = parse_cloud_file("nan 0 0 5 0 0 0\n1 2 3 0.5 9 8 7\n", "a.xyz");
  EXPECT_EQ(intensity.rgb, (std::vector<std::uint8_t>{9, 8, 7}));
  EXPECT_EQ(intensity.invalid, 1u);
  const CloudFile normals = parse_cloud_file("2\n1,2,3,0,0.6,0.8\n1,2,4,0,0,1\n", "a.xyz");
  ASSERT_EQ(normals.normals.size(), 2u);
  EXPECT_EQ(normals.normals[0], Vector3d(0, 0.6, 0.8));
}

// Cut anywhere, or with any byte changed: points or one line, never a crash.
TEST(CloudFile, WhatIsCutOrDamagedIsRefusedInOneLine) {
  for (const auto& [name, text] : every_format()) {
    SCOPED_TRACE(name);
    const auto refused = [&, file = name](const std::string& bytes) {
      try {
        parse_cloud_file(bytes, file);
        return false;
      } catch (const InputError& error) {
        EXPECT_THAT(error.what(), HasSubstr(file));
        EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
        return true;
      }
    };
    const bool ends_by_itself = name.ends_with(".xyz");
    for (std::size_t n = 0; n + 40 < text.size(); ++n)
      EXPECT_TRUE(refused(text.substr(0, n)) || ends_by_itself) << n << " bytes";
    for (unsigned seed = 1; seed <= 300; ++seed) {
      std::mt19937 random(seed);
      std::string bytes = text;
      for (int k = 0; k < 3; ++k) bytes[random() % bytes.size()] = static_cast<char>(random());
      refused(bytes);
    }
  }
}

TEST(CloudFile, AWrongHeaderSaysWhatIsWrong) {
  const auto said = [](std::string text, const std::string& from, const std::string& to,
                       const char* name) -> std::string {
    if (const auto at = text.find(from); at != text.npos) text.replace(at, from.size(), to);
    try {
      parse_cloud_file(text, name);
    } catch (const InputError& error) {
      return error.what();
    }
    return "nothing";
  };
  const std::string b = pcd("binary"), c = pcd("binary_compressed"), p = ply(false, false);
  EXPECT_THAT(said(b, "WIDTH 3", "WIDTH 7", "b.pcd"), HasSubstr("POINTS 3"));
  EXPECT_THAT(said(b, "POINTS 3", "POINTS 99999999999", "b.pcd"), HasSubstr("at most 20000000"));
  EXPECT_THAT(said(b, "FIELDS x", "FIELDS u", "b.pcd"), HasSubstr("no x, y and z"));
  EXPECT_THAT(said(b, "SIZE 4", "SIZE 3", "b.pcd"), HasSubstr("3 bytes"));
  EXPECT_THAT(said(b, "DATA binary", "DATA zip", "b.pcd"), HasSubstr("'DATA zip' is not valid"));
  EXPECT_THAT(said(c, "COUNT 1 1 1 3", "COUNT 1 1 1 4", "c.pcd"), HasSubstr("its fields need"));
  EXPECT_THAT(said(p, "vertex 3", "vertex 4", "p.ply"), HasSubstr("truncated"));
  EXPECT_THAT(said(p, "element vertex", "element camera", "p.ply"), HasSubstr("first element"));
  EXPECT_THAT(said("1 2\n", "", "", "a.xyz"), HasSubstr("has 2 numbers, must have 3"));
  EXPECT_THAT(said("1 2 3\n1 2\n", "", "", "a.xyz"), HasSubstr("has 2 numbers, must have 3"));
  EXPECT_THAT(said("1 2 3\n1 2 z\n", "", "", "a.xyz"), HasSubstr("'z' is no number"));
  EXPECT_THAT(said("nan 2 3\n", "", "", "a.xyz"), HasSubstr("none of its 1 points is valid"));
  EXPECT_THAT(said("1 2 3\n", "", "", "a.las"), HasSubstr("valid are .ply, .pcd and .xyz"));
}

TEST_F(CloudFolder, APlyWithFacesIsAMesh) {
  const auto written = [&](const char* name, const std::string& text) {
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  };
  EXPECT_TRUE(is_cloud_file(written("a.ply", ply(true, false))));
  std::string mesh = ply(true, false);
  mesh.replace(mesh.find("face 0"), 6, "face 1");
  EXPECT_FALSE(is_cloud_file(written("b.ply", mesh)));
  EXPECT_TRUE(is_cloud_file(written("c.PCD", "")));
  EXPECT_FALSE(is_cloud_file(folder_ / "d.obj"));
}

// A ball about the origin, seen from above: normals that tell its outside leave the upper half.
TEST(CloudOfFile, NormalsThatAgreeHideWhatFacesAway) {
  CloudFile ball;
  std::mt19937 random(5);
  for (int i = 0; i < 20000; ++i) {
    const auto unit = [&] { return 2.0 * random() / std::mt19937::max() - 1.0; };
    Vector3d n(unit(), unit(), unit());
    if (n.norm() > 1.0 || n.norm() < 0.1) continue;
    n.normalize();
    ball.points.push_back(0.1 * n);
    ball.normals.push_back(n);
  }
  const Vector3d eye(0, 0, 10);
  const PointCloud upper = cloud_of(ball, "ball", {eye}, {}).cloud;
  for (const Vector3d& p : upper.points) EXPECT_GT(p.z(), 0.0);
  EXPECT_NEAR(static_cast<double>(upper.points.size()), 0.5 * ball.points.size(),
              0.02 * ball.points.size());
  // Signs by chance tell nothing: all points stay.
  CloudFile mixed = ball;
  for (Vector3d& n : mixed.normals) n *= random() % 2 ? 1.0 : -1.0;
  EXPECT_EQ(cloud_of(mixed, "ball", {eye}, {}).cloud.points.size(), ball.points.size());
  // Nothing says whence: from 1 m above the middle.
  EXPECT_NEAR(cloud_of(ball, "ball", {}, {}).cloud.eyes[0].z(), 1.0, 0.01);
  // From both sides all points are seen, each from the side that it faces.
  const PointCloud both = cloud_of(ball, "ball", {eye, -eye}, {}).cloud;
  EXPECT_GT(both.points.size(), 0.98 * ball.points.size()) << "all but a rim";
  for (std::size_t i = 0; i < both.points.size(); ++i)
    EXPECT_EQ(both.camera[i], both.points[i].z() > 0 ? 0 : 1);
  CloudSettings elsewhere;
  elsewhere.region = {Vector3d(1, 1, 1), Vector3d(2, 2, 2)};
  EXPECT_THROW(cloud_of(ball, "ball", {eye}, elsewhere), InputError);
}

}  // namespace
}  // namespace impedraw
