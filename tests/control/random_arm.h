// Random serial arms with 6 or 7 joints, generated from a seed and written as URDF.
#pragma once

#include <filesystem>
#include <fstream>
#include <numbers>
#include <random>
#include <string>

#include <unistd.h>

#include <fmt/format.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace impedraw::testing_arm {

// Owns the URDF file and deletes it. Links have 0.1 to 0.35 m, 1 to 4 kg, random axes and full
// inertia tensors. The last link carries the pen's frames.
class RandomArm {
 public:
  RandomArm(int joints, unsigned seed)
      : path_(std::filesystem::temp_directory_path() /
              fmt::format("impedraw-random-arm-{}-{}-{}.urdf", getpid(), joints, seed)) {
    std::mt19937 rng(seed);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    std::string text = "<?xml version=\"1.0\"?>\n<robot name=\"random\">\n<link name=\"base\"/>\n";
    std::string parent = "base";
    const auto vector = [&] { return Eigen::Vector3d(unit(rng), unit(rng), unit(rng)); };
    Eigen::Vector3d last_axis = Eigen::Vector3d::Zero();
    for (int j = 1; j <= joints; ++j) {
      Eigen::Vector3d axis = vector().normalized();
      while (std::abs(axis.dot(last_axis)) > 0.5)
        axis = vector().normalized();  // neighbours well apart
      last_axis = axis;
      const Eigen::Vector3d offset = (0.225 + 0.125 * unit(rng)) * vector().normalized(),
                            rpy = std::numbers::pi * vector();
      // A cloud of point masses has an inertia that is positive definite and keeps the triangle
      // inequality.
      const double mass = 2.5 + 1.5 * unit(rng);
      Eigen::Matrix3d I = Eigen::Matrix3d::Zero();
      for (int k = 0; k < 8; ++k) {
        const Eigen::Vector3d r = 0.09 * vector();
        I += mass / 8.0 * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
      }
      I += 2e-3 * Eigen::Matrix3d::Identity();
      const Eigen::Vector3d centre = 0.08 * vector(), turned = std::numbers::pi * vector();
      text += fmt::format(
          "<joint name=\"j{0}\" type=\"revolute\"><parent link=\"{1}\"/><child link=\"l{0}\"/>"
          "<origin xyz=\"{2:.6f} {3:.6f} {4:.6f}\" rpy=\"{5:.6f} {6:.6f} {7:.6f}\"/>"
          "<axis xyz=\"{8:.17g} {9:.17g} {10:.17g}\"/><limit lower=\"-3\" upper=\"3\" "
          "effort=\"300\" "
          "velocity=\"3\"/></joint>\n",
          j, parent, offset[0], offset[1], offset[2], rpy[0], rpy[1], rpy[2], axis[0], axis[1],
          axis[2]);
      text += fmt::format(
          "<link name=\"l{0}\"><inertial>"
          "<origin xyz=\"{1:.6f} {2:.6f} {3:.6f}\" rpy=\"{4:.6f} {5:.6f} {6:.6f}\"/>"
          "<mass value=\"{7:.6f}\"/>"
          "<inertia ixx=\"{8:.9f}\" iyy=\"{9:.9f}\" izz=\"{10:.9f}\" "
          "ixy=\"{11:.9f}\" ixz=\"{12:.9f}\" iyz=\"{13:.9f}\"/></inertial></link>\n",
          j, centre[0], centre[1], centre[2], turned[0], turned[1], turned[2], mass, I(0, 0),
          I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2));
      parent = fmt::format("l{}", j);
    }
    const Eigen::Vector3d pen = 0.15 * vector().normalized(), rpy = std::numbers::pi * vector();
    text += fmt::format(
        "<joint name=\"pen\" type=\"fixed\"><parent link=\"{}\"/><child link=\"tip\"/><origin "
        "xyz=\"{:.6f} {:.6f} {:.6f}\" "
        "rpy=\"{:.6f} {:.6f} {:.6f}\"/></joint>\n<link name=\"tip\"/>\n</robot>\n",
        parent, pen[0], pen[1], pen[2], rpy[0], rpy[1], rpy[2]);
    std::ofstream(path_) << text;
  }
  ~RandomArm() { std::filesystem::remove(path_); }
  RandomArm(const RandomArm&) = delete;
  RandomArm& operator=(const RandomArm&) = delete;

  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

}  // namespace impedraw::testing_arm
