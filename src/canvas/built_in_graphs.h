// Built-in canvases given by a height over a rectangle: wave, saddle, terrain. Normals point up.
//
// Law         p_W = centre + x e_x + y e_y + h(x, y) e_z,  |x| ≤ width/2, |y| ≤ height/2
//             e_x = (cos heading, sin heading, 0), e_y = (−sin heading, cos heading, 0), e_z up
// Vertices    on the law to rounding, in a grid along e_x and e_y. Between them the triangles
//             deviate vertically from the surface by at most c = edge²/4 times its greatest
//             second derivative; less where it bends in one direction only.
//
// Each function throws InputError naming the setting, its value and what would be valid.
#pragma once

#include <Eigen/Core>

#include "impedraw/canvas/triangle_mesh.h"
#include "impedraw/common/range.h"

namespace impedraw {

// The rectangle below the surface.
struct FootprintSettings {
  Eigen::Vector3d centre = {0.60, 0.0, 0.10};  // of the rectangle, at height h = 0, p_WC [m]
  double heading_deg = 0.0;                    // of e_x about W's z [deg]
  double width = 0.36;                         // along e_x [m]
  double height = 0.36;                        // along e_y [m]
  double edge = 0.0015;                        // longest side of a cell, seen from above [m]

  struct Limits {
    static constexpr Limit centre = {"centre", "m", {-10.0, 10.0}};
    static constexpr Limit heading = {"heading", "deg", {-360.0, 360.0}};
    static constexpr Limit width = {"width", "m", {0.01, 10.0}};
    static constexpr Limit height = {"height", "m", {0.01, 10.0}};
    static constexpr Limit edge = {"edge", "m", {2e-4, 0.1}};
  };
};

// h = amplitude sin(2π x/wavelength). With the defaults the greatest slope, 2π
// amplitude/wavelength, is 25°; the smallest radius of curvature, 1/(amplitude (2π/wavelength)²),
// is 68 mm; and the facets deviate by at most edge²/8 of the curvature, 4.2 µm.
struct WaveSettings {
  FootprintSettings footprint;
  double amplitude = 0.015;  // [m]
  double wavelength = 0.20;  // [m], at least 8 edges

  struct Limits {
    static constexpr Limit amplitude = {"amplitude", "m", {1e-4, 1.0}};
    static constexpr Limit wavelength = {"wavelength", "m", {0.005, 10.0}};
  };
};

TriangleMesh make_wave(const WaveSettings& settings = {});

// h = (x² − y²)/(2 radius): rises along e_x and falls along e_y, with that radius of curvature at
// the centre. Facets deviate by at most edge²/(8 radius): 0.7 µm with the defaults.
struct SaddleSettings {
  FootprintSettings footprint;
  double radius = 0.40;  // [m]

  struct Limits {
    static constexpr Limit radius = {"radius", "m", {0.01, 100.0}};
  };
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
  double feature = 0.20;    // shortest wavelength [m], at least 8 edges

  struct Limits {
    static constexpr Limit seed = {"seed", "", {0, 1e9}};
    static constexpr Limit amplitude = {"amplitude", "m", {1e-4, 1.0}};
    static constexpr Limit feature = {"feature", "m", {0.005, 10.0}};
  };
};

TriangleMesh make_terrain(const TerrainSettings& settings = {});

}  // namespace impedraw
