// Built-in canvases: sphere, plane, height fields, ruled surfaces, and rough ones. Their edges are
// longer than set where a canvas would take over two million triangles.
// Each function throws InputError naming the setting, its value and what would be valid.
#pragma once

#include <Eigen/Core>

#include "impedraw/canvas/triangle_mesh.h"

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
};

// A rectangle. Every vertex lies in the plane to rounding.
TriangleMesh make_plane(const PlaneSettings& settings = {});

// Built-in canvases given by a height over a rectangle: wave, saddle, terrain. Normals point up.
//
// Law         p_W = centre + x e_x + y e_y + h(x, y) e_z,  |x| ≤ width/2, |y| ≤ height/2
//             e_x = (cos heading, sin heading, 0), e_y = (−sin heading, cos heading, 0), e_z up
// Vertices    on the law to rounding, in a grid along e_x and e_y. Between them the triangles
//             deviate vertically from the surface by at most c = edge²/4 times its greatest
//             second derivative; less where it bends in one direction only.
//
// Each function throws InputError naming the setting, its value and what would be valid.

// The rectangle below the surface.
struct FootprintSettings {
  Eigen::Vector3d centre = {0.60, 0.0, 0.10};  // of the rectangle, at height h = 0, p_WC [m]
  double heading_deg = 0.0;                    // of e_x about W's z [deg]
  double width = 0.36;                         // along e_x [m]
  double height = 0.36;                        // along e_y [m]
  double edge = 0.0015;                        // longest side of a cell, seen from above [m]
};

// h = amplitude sin(2π x/wavelength). With the defaults the greatest slope, 2π
// amplitude/wavelength, is 25°; the smallest radius of curvature, 1/(amplitude (2π/wavelength)²),
// is 68 mm; and the facets deviate by at most edge²/8 of the curvature, 4.2 µm.
struct WaveSettings {
  FootprintSettings footprint;
  double amplitude = 0.015;  // [m]
  double wavelength = 0.20;  // [m]; a cell is at most an eighth of it
};

TriangleMesh make_wave(const WaveSettings& settings = {});

// h = (x² − y²)/(2 radius): rises along e_x and falls along e_y, with that radius of curvature at
// the centre. Facets deviate by at most edge²/(8 radius): 0.7 µm with the defaults.
struct SaddleSettings {
  FootprintSettings footprint;
  double radius = 0.40;  // [m]
};

TriangleMesh make_saddle(const SaddleSettings& settings = {});

// Smooth hills and hollows: h = Σ a sin(k (x cos β_i + y sin β_i) + φ_i), k = 2π/λ_i, with kWaves
// waves i and a = amplitude/kWaves. Each wave in turn takes three random numbers u = (next 64 bits
// >> 11)/2^53 from std::mt19937_64(seed): λ_i = feature (1 + u), β_i = π (i + u)/kWaves, φ_i = 2π
// u. A seed gives the same surface on every machine, to rounding. |h| ≤ amplitude, |∇h| ≤
// 2π amplitude/feature, second derivatives ≤ amplitude (2π/feature)². Over 300 random seeds with
// the default sizes, the greatest slope was 24° in the median and 33° at most, and the facet
// deviation came to 8.9 µm.
struct TerrainSettings {
  static constexpr int kWaves = 8;
  FootprintSettings footprint;
  int seed = 1;
  double amplitude = 0.04;  // [m]
  double feature = 0.20;    // shortest wavelength [m]; a cell is at most an eighth of it
};

TriangleMesh make_terrain(const TerrainSettings& settings = {});

// Built-in ruled canvases: cylinder, trough, cone. Vertices lie on the surface to rounding.
// Each function throws InputError naming the setting, its value and what would be valid.

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
};

TriangleMesh make_cone(const ConeSettings& settings = {});

// Built-in rough canvases, for measuring what the pen can follow: a height h(x, y) over a
// rectangle, with a root-mean-square slope s (s = tan of `slope`) and a length λ.
//
// fractal  Σ a_i sin(k_i (x cos β_i + y sin β_i) + φ_i): wavelengths from λ to kLongest, a_i ∝
//          λ_i^0.8 as on a fractal of dimension 2.2, scaled to √(Σ a_i² k_i²/2) = s
// facets   flat triangles over a square grid of side λ; heights at its corners are normally
//          distributed, scaled to s over the surface
// ridges   a zigzag along x of wavelength λ, slopes ±s
// ripple   the top of a cylinder along x, of radius kRippleRadius, with a sine of wavelength λ
//          along it
// step     0 for x < 0, `rise` for x > 0; the wall is kWall wide
// hole     level, with a round hole of diameter λ in the middle
// lip      level; a second sheet `rise` above it, over x > 0, shadows it
//
// Random numbers come from std::mt19937_64(seed), so that a seed gives the same surface on every
// machine, to rounding. Cells are at most λ/4 wide, so that the mesh shows the shape.

enum class RoughForm { fractal, facets, ridges, ripple, step, hole, lip };

struct RoughSettings {
  static constexpr double kLongest = 0.15, kRippleRadius = 0.2, kWall = 2e-4;  // [m]
  FootprintSettings footprint{.centre = {0.60, 0.0, 0.05}, .width = 0.30, .height = 0.30};
  RoughForm form = RoughForm::fractal;
  int seed = 1;
  double slope_deg = 10.0;    // root mean square
  double wavelength = 0.015;  // λ [m]
  double height = 0.010;      // of a step or lip [m]
};

// Throws InputError naming the setting, its value and what would be valid.
TriangleMesh make_rough(const RoughSettings& settings = {});

}  // namespace impedraw
