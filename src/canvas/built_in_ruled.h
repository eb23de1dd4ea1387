// Built-in ruled canvases: cylinder, trough, cone. Vertices lie on the surface to rounding.
// Each function throws InputError naming the setting, its value and what would be valid.
#pragma once

#include <Eigen/Core>

#include "impedraw/canvas/triangle_mesh.h"
#include "impedraw/common/range.h"

namespace impedraw {

// Part of a cylinder with a horizontal axis, e = (cos heading, sin heading, 0). Facets deviate by
// at most edge²/(8 radius): 0.9 µm with the defaults. The slope at the sides is
// asin(width/(2 radius)): 37° with the defaults.
struct CylinderSettings {
  // of the top line (cylinder) or bottom line (trough), p_WM [m]
  Eigen::Vector3d middle = {0.60, 0.0, 0.10};
  double heading_deg = 0.0;  // of the axis about W's z [deg]
  double radius = 0.30;      // [m]
  double length = 0.36;      // along the axis [m]
  double width = 0.36;       // across, seen from above [m], at most 2 radius
  double edge = 0.0015;      // longest side of a cell [m], at most width

  struct Limits {
    static constexpr Limit middle = {"middle", "m", {-10.0, 10.0}};
    static constexpr Limit heading = {"heading", "deg", {-360.0, 360.0}};
    static constexpr Limit radius = {"radius", "m", {0.01, 10.0}};
    static constexpr Limit length = {"length", "m", {0.01, 10.0}};
    static constexpr Limit width = {"width", "m", {0.01, 10.0}};
    static constexpr Limit edge = {"edge", "m", {2e-4, 0.1}};
  };
};

// The upper part, drawn on from outside: the axis lies `radius` below the middle, and normals
// point away from it.
TriangleMesh make_cylinder(const CylinderSettings& settings = {});

// The lower part, drawn on from inside: the axis lies `radius` above the middle, and normals point
// to it.
TriangleMesh make_trough(const CylinderSettings& settings = {});

// An upright cone, apex up, drawn on from outside: z = apex.z − tan(slope) ρ, where ρ ≤ base_radius
// is the distance from its axis. Normals point up and away from the axis; at the apex they have a
// kink of 2 slope. The vertices form rings about the apex that are denser near it, so that facets
// deviate from the cone by at most edge² sin(slope)/base_radius: 4.3 µm with the defaults.
struct ConeSettings {
  Eigen::Vector3d apex = {0.60, 0.0, 0.14};  // p_WA [m]
  // between its side and the horizontal; the cone's half-angle is 90° − slope [deg]
  double slope_deg = 20.0;
  double base_radius = 0.18;  // of its rim [m]
  double edge = 0.0015;       // desired length of a triangle's edge [m], at most base_radius

  struct Limits {
    static constexpr Limit apex = {"apex", "m", {-10.0, 10.0}};
    static constexpr Limit slope = {"slope", "deg", {0.1, 80.0}};
    static constexpr Limit base_radius = {"base_radius", "m", {0.005, 10.0}};
    static constexpr Limit edge = {"edge", "m", {2e-4, 0.1}};
  };
};

TriangleMesh make_cone(const ConeSettings& settings = {});

}  // namespace impedraw
