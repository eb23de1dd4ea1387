#include "impedraw/experiment/canvas_settings.h"

#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/canvas/describe_built_in.h"
#include "impedraw/canvas/mesh_check.h"
#include "impedraw/common/rotations.h"
#include "impedraw/simulation/describe_world.h"

namespace impedraw {
namespace {

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
