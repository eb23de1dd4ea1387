// The canvas of an experiment: a built-in shape with its dimensions, or a mesh from a file. Only
// the settings of the selected kind are read.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/canvas/built_in.h"
#include "impedraw/settings/schema.h"
#include "impedraw/simulation/world_settings.h"

namespace impedraw {

enum class CanvasKind {
  bowl,
  dome,
  plane,
  wave,
  saddle,
  cylinder,
  trough,
  cone,
  terrain,
  rough,
  mesh,
  seen  // nobody modelled it: the surface is what a capture or a cloud shows
};

enum class LengthUnit { file, m, mm, cm, in };  // file: as the file says, or m
std::optional<double> metres(LengthUnit unit);

// A mesh file in its frame F: p_WP = position + R p_FP, R = Rz(yaw) Ry(pitch) Rx(roll).
struct MeshSettings {
  enum class Side { outward, inward };
  std::filesystem::path file;
  LengthUnit unit = LengthUnit::file;                      // of the file's numbers
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      // p_WF [m]
  Eigen::Vector3d rotation_deg = Eigen::Vector3d::Zero();  // roll, pitch, yaw
  // The side drawn on. outward: as wound; for a closed mesh, away from its inside.
  Side side = Side::outward;
  enum class Up { z, y };
  Up up = Up::z;          // of a file that does not say which axis is up
  bool recentre = false;  // see MeshReading
};

struct CanvasSettings {
  CanvasKind kind = CanvasKind::bowl;
  CapSettings cap;  // bowl and dome
  PlaneSettings plane;
  WaveSettings wave;
  SaddleSettings saddle;
  CylinderSettings cylinder;  // cylinder and trough
  ConeSettings cone;
  TerrainSettings terrain;
  RoughSettings rough;
  MeshSettings mesh;
  // Translation of the canvas, after its rotation: p = move + Rz(turn) p_made [m].
  Eigen::Vector3d move = Eigen::Vector3d::Zero();
  double turn_deg = 0.0;
  // For a driven arm: what stands before it is the canvas as configured, and may be rendered for
  // perception.source simulated.
  bool true_model = false;
  CanvasMotionSettings motion;  // its seed comes from the scenario's
};

void describe(Fields& f, CanvasSettings& s);

// Makes the mesh of the selected kind. Throws InputError, naming the setting, if the settings give
// no valid shape. Repairs to a mesh file and warnings of reading it are appended to `repaired`, if
// given, one line each.
TriangleMesh make_mesh(const CanvasSettings& settings,
                       std::vector<std::string>* repaired = nullptr);

}  // namespace impedraw
