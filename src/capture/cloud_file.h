// Reads point clouds from files: what a scanner or another program left of an object.
//
//   PLY  ascii or binary; its vertices, and the positions of an element `camera` that follows them
//   PCD  ascii, binary or binary_compressed; VIEWPOINT's position
//   XYZ  text, a line each: x y z, an intensity or none, and 3 or 6 more numbers: colours from 0 to
//        255, normals of length 1
//
// Coordinates are in W and in m. Points with a coordinate that is not finite, as organised clouds
// have them, are skipped and counted. The fields vp_x, vp_y and vp_z of a point (PCL's
// PointWithViewpoint) say whence it was seen.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

struct CloudFile {
  std::vector<Eigen::Vector3d> points;      // [m], W
  std::vector<Eigen::Vector3d> normals;     // as the file says; empty, or one each
  std::vector<std::uint8_t> rgb;            // three bytes a point; may be empty
  std::vector<Eigen::Vector3d> viewpoints;  // p_WC [m]; empty: the file says none, or the origin
  std::vector<int> seen_from;               // index into viewpoints; empty, or one each
  std::size_t invalid = 0;                  // points that were skipped

  struct Limits {
    static constexpr std::size_t bytes = 2'000'000'000;
    static constexpr std::size_t points = 20'000'000;
  };
};

// .pcd, .xyz, or .ply without faces, ignoring case.
bool is_cloud_file(const std::filesystem::path& file);

// Throws InputError naming the file and the fault: unreadable, truncated, too large, without x, y
// and z or without any valid point.
CloudFile read_cloud_file(const std::filesystem::path& file);
// `text`: the content of a file named `name`, whose ending says the format.
CloudFile parse_cloud_file(std::string_view text, const std::string& name);

}  // namespace impedraw
