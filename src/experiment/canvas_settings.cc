#include "impedraw/experiment/canvas_settings.h"

#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/canvas/mesh_check.h"
#include "impedraw/common/roll_pitch_yaw.h"

namespace impedraw {
namespace {

// Straight into the shape's own group: canvas.wave.centre.
void describe_footprint(Fields& f, FootprintSettings& s) {
  using Limits = FootprintSettings::Limits;
  f.field(Limits::centre, s.centre,
          "Centre of the rectangle that the surface stands on; z is where its height is 0.");
  f.field(Limits::heading, s.heading_deg,
          "Direction of the surface's x axis, counter-clockwise as seen from above.");
  f.field(Limits::width, s.width, "Size along its x axis.");
  f.field(Limits::height, s.height, "Size along its y axis.");
  f.field(Limits::edge, s.edge, "Longest side of a mesh cell, as seen from above.");
}

TriangleMesh make_mesh(const MeshSettings& s, std::vector<std::string>* repaired) {
  if (s.file.empty())
    throw InputError(fmt::format("canvas.mesh.file is empty, must be {}", kMeshFiles));
  MeshReading reading;
  reading.unit = metres(s.unit);
  reading.y_up = s.up == MeshSettings::Up::y;
  reading.recentre = s.recentre;
  CheckedMesh checked = load_mesh(s.file, reading);
  for (const MeshFault& fault : checked.faults) {
    if (fault.kind == "too_large" || fault.kind == "too_small") {
      throw InputError(fmt::format("{}: {}; canvas.mesh.unit may be m, mm, cm or in",
                                   s.file.string(), fault.message));
    }
  }
  require_drawable(checked, s.file.string());
  if (repaired) {
    for (const std::string& warning : checked.warnings)
      repaired->push_back(s.file.string() + ": " + warning);
    for (const MeshFault& fault : checked.faults)
      repaired->push_back(s.file.string() + ": " + fault.message);
  }
  const Eigen::Quaterniond R_WF = rotation_from_roll_pitch_yaw(s.rotation_deg);
  for (Eigen::Vector3d& p : checked.mesh.vertices) p = R_WF * p + s.position;
  if (s.side == MeshSettings::Side::inward) {
    for (Eigen::Vector3i& t : checked.mesh.triangles) std::swap(t[1], t[2]);
  }
  return std::move(checked.mesh);
}

}  // namespace

std::optional<double> metres(LengthUnit unit) {
  constexpr double kMetres[] = {0.0, 1.0, 1e-3, 1e-2, 0.0254};
  return unit == LengthUnit::file ? std::nullopt
                                  : std::optional(kMetres[static_cast<std::size_t>(unit)]);
}

void describe(Fields& f, CapSettings& s) {
  using Limits = CapSettings::Limits;
  f.field(Limits::radius, s.radius, "Radius of the sphere.");
  f.field(Limits::centre, s.centre, "Centre of the sphere.");
  f.field(Limits::opening_radius, s.opening_radius,
          "Radius of the circle at which the cap ends: radius × sin(slope there).");
  f.field(Limits::edge, s.edge, "Edge length of a mesh triangle.");
}

void describe(Fields& f, PlaneSettings& s) {
  using Limits = PlaneSettings::Limits;
  f.field(Limits::centre, s.centre, "Centre of the rectangle.");
  f.field(Limits::normal, s.normal, "Normal of the side that is drawn on.");
  f.field(Limits::width, s.width, "Size along x.");
  f.field(Limits::height, s.height, "Size at right angles to that.");
  f.field(Limits::edge, s.edge, "Side of a mesh cell.");
}

void describe(Fields& f, WaveSettings& s) {
  using Limits = WaveSettings::Limits;
  describe_footprint(f, s.footprint);
  f.field(Limits::amplitude, s.amplitude,
          "Amplitude of the wave: height = amplitude × sin(2π x/wavelength).");
  f.field(Limits::wavelength, s.wavelength, "Wavelength along its x axis.");
}

void describe(Fields& f, SaddleSettings& s) {
  describe_footprint(f, s.footprint);
  f.field(SaddleSettings::Limits::radius, s.radius,
          "Radius of curvature at the centre: height = (x² - y²)/(2 radius).");
}

void describe(Fields& f, CylinderSettings& s) {
  using Limits = CylinderSettings::Limits;
  f.field(Limits::middle, s.middle,
          "Middle of the top line of a cylinder, or of the bottom line of a trough.");
  f.field(Limits::heading, s.heading_deg,
          "Direction of the level axis, counter-clockwise from x as seen from above.");
  f.field(Limits::radius, s.radius, "Radius of the cylinder.");
  f.field(Limits::length, s.length, "Length along the axis.");
  f.field(Limits::width, s.width, "Width as seen from above: 2 radius × sin(slope at its sides).");
  f.field(Limits::edge, s.edge, "Longest side of a mesh cell.");
}

void describe(Fields& f, ConeSettings& s) {
  using Limits = ConeSettings::Limits;
  f.field(Limits::apex, s.apex, "Apex of the cone.");
  f.field(Limits::slope, s.slope_deg, "Slope of its side; the half-angle is 90° minus the slope.");
  f.field(Limits::base_radius, s.base_radius, "Radius of the circle at which the cone ends.");
  f.field(Limits::edge, s.edge, "Edge length of a mesh triangle.");
}

void describe(Fields& f, TerrainSettings& s) {
  using Limits = TerrainSettings::Limits;
  describe_footprint(f, s.footprint);
  f.field(Limits::seed, s.seed, "Seed of the terrain.");
  f.field(Limits::amplitude, s.amplitude, "Bound on the heights, above and below zero.");
  f.field(Limits::feature, s.feature,
          "Shortest wavelength of the hills; the longest is twice that.");
}

void describe(Fields& f, RoughSettings& s) {
  using Limits = RoughSettings::Limits;
  describe_footprint(f, s.footprint);
  f.choice(
      "form", s.form, {"fractal", "facets", "ridges", "ripple", "step", "hole", "lip"},
      "Hills at every scale down to the wavelength; flat facets of that size; a zigzag; a "
      "cylinder with waves along it; a step; a hole of that diameter; or a sheet above half of "
      "another.");
  f.field(Limits::seed, s.seed, "Seed of a fractal or of facets.");
  f.field(Limits::slope, s.slope_deg, "Root-mean-square slope.");
  f.field(Limits::wavelength, s.wavelength,
          "Shortest wavelength, side of a facet, or diameter of the hole.");
  f.field(Limits::height, s.height, "Height of the step, or of the upper sheet.");
}

void describe(Fields& f, MeshSettings& s) {
  f.field("file", s.file, fmt::format("Mesh file: {}.", kMeshFiles)).for_users();
  f.choice("unit", s.unit, {"file", "m", "mm", "cm", "in"},
           "Unit of the numbers in the file; file: what it says (.glb, .gltf, .3mf, .dae), else m.")
      .for_users();
  f.choice("up", s.up, {"z", "y"},
           "Axis that points up in the file; .glb, .gltf, .3mf and .dae say it themselves.");
  f.field("recentre", s.recentre,
          "Moves the middle of its extent in x and y, and its lowest point, to the file's origin.");
  f.field("position", s.position, {-10.0, 10.0}, "m", "Position of the file's origin.");
  f.field("rotation", s.rotation_deg, {-360.0, 360.0}, "deg",
          "Roll, pitch and yaw: rotations about the world's x, then y, then z axis.");
  f.choice(
      "side", s.side, {"outward", "inward"},
      "Side that is drawn on; outward: the front of its triangles, and the outside of a closed "
      "mesh.");
}

void describe(Fields& f, CanvasMotionSettings& s) {
  using Limits = CanvasMotionSettings::Limits;
  f.field(Limits::centre, s.centre, "Point that the canvas turns and rolls about.");
  f.field(Limits::start, s.start, "Time at which it starts to move.");
  f.field(Limits::stop, s.stop, "Time at which it starts to stop; null: it never stops.");
  f.field(Limits::ramp, s.ramp, "Time that it takes to reach its full motion, and to stop.");
  f.field(Limits::speed, s.velocity, "Constant velocity, as on a conveyor.");
  f.field(Limits::turn_axis, s.turn_axis, "Axis of a turntable.");
  f.field(Limits::turn_speed, s.turn_speed, "Angular speed of the turntable.");
  f.field(Limits::sway, s.sway, "Amplitude of a sinusoidal translation, heave or sway.");
  f.field(Limits::sway_frequency, s.sway_frequency, "Its frequency.");
  f.field(Limits::roll_axis, s.roll_axis, "Axis of a sinusoidal rotation.");
  f.field(Limits::roll, s.roll, "Its amplitude.");
  f.field(Limits::roll_frequency, s.roll_frequency, "Its frequency.");
  f.field(Limits::jolts, s.jolts, "Root-mean-square displacement by random jolts, on each axis.");
  f.field(Limits::jolt_bandwidth, s.jolt_bandwidth,
          "Frequency up to which the spectrum of the jolts is flat.");
  f.field("file", s.file,
          "A recorded motion in place of all of these, CSV: t [s], x, y, z [m], qw, qx, qy, qz of "
          "any frame fixed to the canvas, at least every 0.25 s.");
}

void describe(Fields& f, CanvasSettings& s) {
  f.choice("kind", s.kind,
           {"bowl", "dome", "plane", "wave", "saddle", "cylinder", "trough", "cone", "terrain",
            "rough", "mesh", "seen"},
           "Shape of the canvas. A bowl is a sphere from inside, a dome one from outside; a mesh "
           "comes from a file; seen: as perception's capture or cloud shows it.")
      .for_users();
  f.field("cap", s.cap, "Size of a bowl or dome.");
  f.field("plane", s.plane, "Size of a plane.");
  f.field("wave", s.wave, "Size of a wave.");
  f.field("saddle", s.saddle, "Size of a saddle.");
  f.field("cylinder", s.cylinder,
          "Size of a cylinder, drawn on from outside, or a trough, from inside.");
  f.field("cone", s.cone, "Size of a cone, apex up, drawn on from outside.");
  f.field("terrain", s.terrain, "Size of a terrain of random hills and hollows.");
  f.field("rough", s.rough, "Shape of a rough canvas: what the pen can follow is measured on it.");
  f.field("mesh", s.mesh, "Mesh from a file.");
  f.field("move", s.move, {-10.0, 10.0}, "m",
          "Translation of the whole canvas, after its rotation.")
      .for_users();
  f.field("turn", s.turn_deg, {-360.0, 360.0}, "deg",
          "Rotation of the whole canvas about the world's z axis.");
  f.field("true_model", s.true_model,
          "What stands before a driven arm is this canvas, so that simulated cameras may see it.");
  f.field("motion", s.motion, "Motion of the canvas during the run; none by default.");
}

namespace {

TriangleMesh made_mesh(const CanvasSettings& s, std::vector<std::string>* repaired) {
  switch (s.kind) {
    case CanvasKind::bowl:
      break;
    case CanvasKind::seen:
      throw InputError("canvas.kind seen has no mesh of its own");
    case CanvasKind::dome:
      return make_dome(s.cap);
    case CanvasKind::plane:
      return make_plane(s.plane);
    case CanvasKind::wave:
      return make_wave(s.wave);
    case CanvasKind::saddle:
      return make_saddle(s.saddle);
    case CanvasKind::cylinder:
      return make_cylinder(s.cylinder);
    case CanvasKind::trough:
      return make_trough(s.cylinder);
    case CanvasKind::cone:
      return make_cone(s.cone);
    case CanvasKind::terrain:
      return make_terrain(s.terrain);
    case CanvasKind::rough:
      return make_rough(s.rough);
    case CanvasKind::mesh:
      return make_mesh(s.mesh, repaired);
  }
  return make_bowl(s.cap);
}

}  // namespace

TriangleMesh make_mesh(const CanvasSettings& s, std::vector<std::string>* repaired) {
  TriangleMesh mesh = made_mesh(s, repaired);
  if (s.turn_deg == 0.0 && s.move.isZero()) return mesh;
  const Eigen::Matrix3d R =
      Eigen::AngleAxisd(s.turn_deg * std::numbers::pi / 180.0, Eigen::Vector3d::UnitZ())
          .toRotationMatrix();
  for (Eigen::Vector3d& p : mesh.vertices) p = R * p + s.move;
  return mesh;
}

}  // namespace impedraw
