// Reads point clouds from files: what a scanner or another program left of an object.
//
//   PLY  ascii or binary; its vertices alone
//   PCD  ascii, binary or binary_compressed; VIEWPOINT's position
//   XYZ  text, a line each: x y z, and 3 or 6 more numbers: colours from 0 to 255, normals of
//        length 1
//
// Coordinates are in W and in m. Points with a coordinate that is not finite, as organised clouds
// have them, are skipped and counted.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

struct CloudFile {
  std::vector<Eigen::Vector3d> points;   // [m], W
  std::vector<Eigen::Vector3d> normals;  // as the file says; empty, or one each
  std::vector<std::uint8_t> rgb;         // three bytes a point; may be empty
  std::optional<Eigen::Vector3d> p_WC;   // viewpoint; none: the file says none, or the origin
  std::size_t invalid = 0;               // points that were skipped

  struct Limits {
    static constexpr std::size_t bytes = 2'000'000'000;
    static constexpr std::size_t points = 20'000'000;
  };
};

// .ply, .pcd or .xyz, ignoring case; of PLY files only those without faces.
bool is_cloud_file(const std::filesystem::path& file);

// Throws InputError naming the file and the fault: unreadable, truncated, too large, without x, y
// and z or without any valid point.
CloudFile read_cloud_file(const std::filesystem::path& file);
// `text`: the content of a file named `name`, whose ending says the format.
CloudFile parse_cloud_file(std::string_view text, const std::string& name);

}  // namespace impedraw
