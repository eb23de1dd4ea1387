// Description of the built-in canvases' settings (built_in.h).
// See control/describe_control.h.
#pragma once

#include "impedraw/canvas/built_in.h"
#include "impedraw/common/range.h"

namespace impedraw {

inline constexpr Range kHeadingRange{-360.0, 360.0};  // [deg]

// Straight into the shape's own group: canvas.wave.centre. A scenario moves and turns the whole
// canvas instead.
template <class F>
void describe_footprint(F& f, FootprintSettings& s) {
  f.constant("centre", s.centre, {-10.0, 10.0}, "m");
  f.constant("width", s.width, {0.01, 10.0}, "m");
  f.constant("height", s.height, {0.01, 10.0}, "m");
  f.constant("edge", s.edge, {2e-4, 0.1}, "m");
}

template <class F>
void describe(F& f, CapSettings& s) {
  f.field("radius", s.radius, {0.01, 10.0}, "m", "Radius of the sphere.");
  f.field("centre", s.centre, {-10.0, 10.0}, "m", "Centre of the sphere.");
  f.field("opening_radius", s.opening_radius, {0.005, 10.0}, "m",
          "Radius of the circle at which the cap ends: radius × sin(slope there).");
  f.constant("edge", s.edge, {2e-4, 0.2}, "m");
}

template <class F>
void describe(F& f, PlaneSettings& s) {
  f.field("centre", s.centre, {-10.0, 10.0}, "m", "Centre of the rectangle.");
  f.field("normal", s.normal, {-1.0, 1.0}, "", "Normal of the side that is drawn on.");
  f.field("width", s.width, {0.01, 10.0}, "m", "Size along x.");
  f.field("height", s.height, {0.01, 10.0}, "m", "Size at right angles to that.");
  f.field("edge", s.edge, {2e-4, 1.0}, "m", "Side of a mesh cell.");
}

template <class F>
void describe(F& f, WaveSettings& s) {
  describe_footprint(f, s.footprint);
  f.field("heading", s.footprint.heading_deg, kHeadingRange, "deg",
          "Direction of the surface's x axis, counter-clockwise as seen from above.");
  f.field("amplitude", s.amplitude, {1e-4, 1.0}, "m",
          "Amplitude of the wave: height = amplitude × sin(2π x/wavelength).");
  f.field("wavelength", s.wavelength, {0.005, 10.0}, "m", "Wavelength along its x axis.");
}

template <class F>
void describe(F& f, SaddleSettings& s) {
  describe_footprint(f, s.footprint);
  f.constant("heading", s.footprint.heading_deg, kHeadingRange, "deg");
  f.field("radius", s.radius, {0.01, 100.0}, "m",
          "Radius of curvature at the centre: height = (x² - y²)/(2 radius).");
}

template <class F>
void describe(F& f, CylinderSettings& s) {
  f.field("middle", s.middle, {-10.0, 10.0}, "m",
          "Middle of the top line of a cylinder, or of the bottom line of a trough.");
  f.field("heading", s.heading_deg, kHeadingRange, "deg",
          "Direction of the level axis, counter-clockwise from x as seen from above.");
  f.field("radius", s.radius, {0.01, 10.0}, "m", "Radius of the cylinder.");
  f.field("length", s.length, {0.01, 10.0}, "m", "Length along the axis.");
  f.field("width", s.width, {0.01, 10.0}, "m",
          "Width as seen from above: 2 radius × sin(slope at its sides).");
  f.constant("edge", s.edge, {2e-4, 0.1}, "m");
}

template <class F>
void describe(F& f, ConeSettings& s) {
  f.constant("apex", s.apex, {-10.0, 10.0}, "m");
  f.field("slope", s.slope_deg, {0.1, 80.0}, "deg",
          "Slope of its side; the half-angle is 90° minus the slope.");
  f.field("base_radius", s.base_radius, {0.005, 10.0}, "m",
          "Radius of the circle at which the cone ends.");
  f.constant("edge", s.edge, {2e-4, 0.1}, "m");
}

template <class F>
void describe(F& f, TerrainSettings& s) {
  describe_footprint(f, s.footprint);
  f.constant("heading", s.footprint.heading_deg, kHeadingRange, "deg");
  f.field("seed", s.seed, {0, 1e9}, "", "Seed of the terrain.");
  f.field("amplitude", s.amplitude, {1e-4, 1.0}, "m",
          "Bound on the heights, above and below zero.");
  f.field("feature", s.feature, {0.005, 10.0}, "m",
          "Shortest wavelength of the hills; the longest is twice that.");
}

template <class F>
void describe(F& f, RoughSettings& s) {
  describe_footprint(f, s.footprint);
  f.constant("heading", s.footprint.heading_deg, kHeadingRange, "deg");
  f.choice(
      "form", s.form, {"fractal", "facets", "ridges", "ripple", "step", "hole", "lip"},
      "Hills at every scale down to the wavelength; flat facets of that size; a zigzag; a "
      "cylinder with waves along it; a step; a hole of that diameter; or a sheet above half of "
      "another.");
  f.field("seed", s.seed, {0, 1e9}, "", "Seed of a fractal or of facets.");
  f.field("slope", s.slope_deg, {0.0, 60.0}, "deg", "Root-mean-square slope.");
  f.field("wavelength", s.wavelength, {0.001, 0.15}, "m",
          "Shortest wavelength, side of a facet, or diameter of the hole.");
  f.field("rise", s.height, {0.0, 0.2}, "m", "Height of the step, or of the upper sheet.");
}

}  // namespace impedraw
