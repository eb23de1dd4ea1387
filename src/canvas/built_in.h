// Built-in canvases: sphere and plane. See built_in_graphs.h and built_in_ruled.h for the others.
// Each function throws InputError naming the setting, its value and what would be valid.
#pragma once

#include <Eigen/Core>

#include "impedraw/canvas/triangle_mesh.h"
#include "impedraw/common/range.h"

namespace impedraw {

// A spherical cap. Every vertex lies on the sphere. The triangles form rings about the cap's pole
// and are nearly equilateral (no angle under 35°). Between vertices they deviate from the sphere by
// at most edge²/(4 radius): 1.9 µm on the standard bowl.
struct CapSettings {
  double radius = 0.30;                        // of the sphere [m]
  Eigen::Vector3d centre = {0.60, 0.0, 0.40};  // of the sphere, p_WC [m]
  // of the cap's rim: radius sin(slope at the rim) [m], at most radius
  double opening_radius = 0.18;
  double edge = 0.0015;  // desired length of a triangle's edge [m], at most opening_radius

  struct Limits {
    static constexpr Limit radius = {"radius", "m", {0.01, 10.0}};
    static constexpr Limit centre = {"centre", "m", {-10.0, 10.0}};
    static constexpr Limit opening_radius = {"opening_radius", "m", {0.005, 10.0}};
    static constexpr Limit edge = {"edge", "m", {2e-4, 0.2}};
  };
};
using BowlSettings = CapSettings;
using DomeSettings = CapSettings;

// The sphere's lowest part, drawn on from inside: normals point to the centre. The defaults make
// the standard bowl.
TriangleMesh make_bowl(const BowlSettings& settings = {});

// The sphere's uppermost part, drawn on from outside: normals point away from the centre.
TriangleMesh make_dome(const DomeSettings& settings = {});

struct PlaneSettings {
  Eigen::Vector3d centre = {0.60, 0.0, 0.10};         // p_WC [m]
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // of the side drawn on; not zero; in ±1
  // along W's x projected onto the plane (W's y if x is normal to the plane) [m]
  double width = 0.36;
  double height = 0.36;  // across the width [m]
  double edge = 0.01;    // desired length of a cell's side [m]

  struct Limits {
    static constexpr Limit centre = {"centre", "m", {-10.0, 10.0}};
    static constexpr Limit normal = {"normal", "", {-1.0, 1.0}};
    static constexpr Limit width = {"width", "m", {0.01, 10.0}};
    static constexpr Limit height = {"height", "m", {0.01, 10.0}};
    static constexpr Limit edge = {"edge", "m", {2e-4, 1.0}};
  };
};

// A rectangle. Every vertex lies in the plane to rounding.
TriangleMesh make_plane(const PlaneSettings& settings = {});

}  // namespace impedraw
