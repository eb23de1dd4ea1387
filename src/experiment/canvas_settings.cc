#include "impedraw/experiment/canvas_settings.h"

#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/canvas/mesh_check.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/roll_pitch_yaw.h"

namespace impedraw {

namespace {

constexpr double kPlace = 10.0;  // [m], generous bounds of any coordinate of a canvas's middle
const Range kEdge{2e-4, 0.1};
const Range kLength{0.01, 10.0};
const Range kHeading{-360.0, 360.0};

// Straight into the shape's own group: canvas.wave.centre.
void describe_footprint(Fields& f, FootprintSettings& s) {
  f.field("centre", s.centre, Range{-kPlace, kPlace}, "m",
          "of the rectangle that it stands over; z: where its height is 0");
  f.field("heading", s.heading_deg, kHeading, "deg",
          "of its x, counter-clockwise, seen from above");
  f.field("width", s.width, kLength, "m", "along its x");
  f.field("height", s.height, kLength, "m", "along its y");
  f.field("edge", s.edge, kEdge, "m", "longest side of a cell, seen from above");
}

TriangleMesh make_mesh(const MeshSettings& s, std::vector<std::string>* repaired) {
  if (s.file.empty())
    throw InputError(
        "canvas.mesh.file is empty, must name a .obj, .stl or .ply for canvas.kind mesh");
  CheckedMesh checked = load_mesh(s.file, metres(s.unit));
  for (const MeshFault& fault : checked.faults) {
    if (fault.kind == "too_large" || fault.kind == "too_small") {
      throw InputError(fmt::format("{}: {}; canvas.mesh.unit may be m, mm, cm or in",
                                   s.file.string(), fault.message));
    }
  }
  require_drawable(checked, s.file.string());
  if (repaired) {
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

double metres(LengthUnit unit) {
  switch (unit) {
    case LengthUnit::m:
      break;
    case LengthUnit::mm:
      return 1e-3;
    case LengthUnit::cm:
      return 1e-2;
    case LengthUnit::in:
      return 0.0254;
  }
  return 1.0;
}

void describe(Fields& f, CapSettings& s) {
  f.field("radius", s.radius, Range{0.01, 10.0}, "m", "of the sphere");
  f.field("centre", s.centre, Range{-10.0, 10.0}, "m", "of the sphere");
  f.field("opening_radius", s.opening_radius, Range{0.005, 10.0}, "m",
          "of the circle at which the cap ends: radius × sin(slope there)");
  f.field("edge", s.edge, kEdge, "m", "of a triangle");
}

void describe(Fields& f, PlaneSettings& s) {
  f.field("centre", s.centre, Range{-2.0, 2.0}, "m", "of the rectangle");
  f.field("normal", s.normal, Range{-1.0, 1.0}, "", "of the side drawn on");
  f.field("width", s.width, kLength, "m", "along x");
  f.field("height", s.height, kLength, "m", "across");
  f.field("edge", s.edge, Range{2e-4, 1.0}, "m", "of a cell");
}

void describe(Fields& f, WaveSettings& s) {
  describe_footprint(f, s.footprint);
  f.field("amplitude", s.amplitude, Range{1e-4, 1.0}, "m",
          "height = amplitude × sin(2π x/wavelength)");
  f.field("wavelength", s.wavelength, Range{0.005, 10.0}, "m", "along its x");
}

void describe(Fields& f, SaddleSettings& s) {
  describe_footprint(f, s.footprint);
  f.field("radius", s.radius, Range{0.01, 100.0}, "m",
          "of curvature at the centre: height = (x² - y²)/(2 radius)");
}

void describe(Fields& f, CylinderSettings& s) {
  f.field("middle", s.middle, Range{-kPlace, kPlace}, "m",
          "of its top line (cylinder) or bottom line (trough)");
  f.field("heading", s.heading_deg, kHeading, "deg",
          "of its level axis, counter-clockwise from x, seen from above");
  f.field("radius", s.radius, kLength, "m", "of the cylinder");
  f.field("length", s.length, kLength, "m", "along the axis");
  f.field("width", s.width, kLength, "m",
          "across, seen from above: 2 radius × sin(slope at its sides)");
  f.field("edge", s.edge, kEdge, "m", "longest side of a cell");
}

void describe(Fields& f, ConeSettings& s) {
  f.field("apex", s.apex, Range{-kPlace, kPlace}, "m", "its top");
  f.field("slope", s.slope_deg, Range{0.1, 80.0}, "deg",
          "of its side; the half-angle is 90° less that");
  f.field("base_radius", s.base_radius, Range{0.005, 10.0}, "m", "of the circle at which it ends");
  f.field("edge", s.edge, kEdge, "m", "of a triangle");
}

void describe(Fields& f, TerrainSettings& s) {
  describe_footprint(f, s.footprint);
  f.field("seed", s.seed, Range{0, 1e9}, "", "another seed, another terrain");
  f.field("amplitude", s.amplitude, Range{1e-4, 1.0}, "m", "heights stay within it, up and down");
  f.field("feature", s.feature, Range{0.005, 10.0}, "m",
          "shortest wavelength of its hills; the longest is twice that");
}

void describe(Fields& f, MeshSettings& s) {
  f.field("file", s.file, ".obj, .stl or .ply");
  f.choice("unit", s.unit,
           {{"m", LengthUnit::m},
            {"mm", LengthUnit::mm},
            {"cm", LengthUnit::cm},
            {"in", LengthUnit::in}},
           "of the file's numbers");
  f.field("position", s.position, Range{-kPlace, kPlace}, "m", "of the file's origin");
  f.field("rotation", s.rotation_deg, Range{-360.0, 360.0}, "deg",
          "roll, pitch, yaw: about x, then y, then z, all of them the world's");
  f.choice(
      "side", s.side,
      {{"outward", MeshSettings::Side::outward}, {"inward", MeshSettings::Side::inward}},
      "drawn on; outward: as its triangles are wound, and away from the inside of a closed mesh");
}

void describe(Fields& f, CanvasSettings& s) {
  f.choice("kind", s.kind,
           {{"bowl", CanvasKind::bowl},
            {"dome", CanvasKind::dome},
            {"plane", CanvasKind::plane},
            {"wave", CanvasKind::wave},
            {"saddle", CanvasKind::saddle},
            {"cylinder", CanvasKind::cylinder},
            {"trough", CanvasKind::trough},
            {"cone", CanvasKind::cone},
            {"terrain", CanvasKind::terrain},
            {"mesh", CanvasKind::mesh}},
           "what is drawn on; mesh: from a file; a sphere from inside is a bowl, from outside a "
           "dome, up to a slope of 90°");
  f.field("cap", s.cap, "of a bowl or dome");
  f.field("plane", s.plane, "of a plane");
  f.field("wave", s.wave, "of a wave");
  f.field("saddle", s.saddle, "of a saddle");
  f.field("cylinder", s.cylinder, "of a cylinder, drawn on from outside, or a trough, from inside");
  f.field("cone", s.cone, "of a cone, apex up, drawn on from outside");
  f.field("terrain", s.terrain, "of hills and hollows from a seed");
  f.field("mesh", s.mesh, "of a mesh from a file");
  f.field("move", s.move, Range{-kPlace, kPlace}, "m",
          "of the whole canvas, once it is made and turned");
  f.field("turn", s.turn_deg, Range{-360.0, 360.0}, "deg",
          "of the whole canvas about the world's z");
}

namespace {

TriangleMesh made_mesh(const CanvasSettings& s, std::vector<std::string>* repaired) {
  switch (s.kind) {
    case CanvasKind::bowl:
      break;
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
