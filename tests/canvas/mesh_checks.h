// What every built-in canvas is asked.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "impedraw/canvas/triangle_mesh.h"
#include "impedraw/common/errors.h"

namespace impedraw {

inline Eigen::Vector3d cross(const TriangleMesh& m, const Eigen::Vector3i& t) {
  return (m.vertices[t[1]] - m.vertices[t[0]]).cross(m.vertices[t[2]] - m.vertices[t[0]]);
}

inline double area(const TriangleMesh& m) {
  double sum = 0;
  for (const auto& t : m.triangles) sum += 0.5 * cross(m, t).norm();
  return sum;
}

// Every edge once (rim) or twice in opposite directions; Euler's characteristic of a disc.
inline void expect_disc(const TriangleMesh& m) {
  std::map<std::pair<int, int>, int> directed;
  for (const auto& t : m.triangles) {
    for (int i = 0; i < 3; ++i) EXPECT_EQ(++directed[std::pair(t[i], t[(i + 1) % 3])], 1);
  }
  long edges = 0;
  for (const auto& [edge, count] : directed) {
    const bool twice = directed.count({edge.second, edge.first}) > 0;
    if (!twice || edge.first < edge.second) ++edges;
  }
  EXPECT_EQ(long(m.vertices.size()) - edges + long(m.triangles.size()), 1);
}

inline void expect_refused(const std::function<void()>& make, const std::string& what) {
  try {
    make();
    ADD_FAILURE() << "accepted, though " << what;
  } catch (const InputError& e) {
    EXPECT_THAT(e.what(), testing::HasSubstr(what));
    EXPECT_THAT(e.what(), testing::Not(testing::HasSubstr("\n")));
  }
}

}  // namespace impedraw
