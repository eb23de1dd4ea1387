// The canvas of an experiment: which of the built-in shapes, and the sizes of each, or a mesh from
// a file. Only those of its kind are read.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "impedraw/canvas/built_in.h"
#include "impedraw/canvas/built_in_graphs.h"
#include "impedraw/canvas/built_in_ruled.h"
#include "impedraw/settings/schema.h"

namespace impedraw {

enum class CanvasKind { bowl, dome, plane, wave, saddle, cylinder, trough, cone, terrain, mesh };

enum class LengthUnit { m, mm, cm, in };
double metres(LengthUnit unit);

// A mesh file in its frame F: p_WP = position + R p_FP, R = Rz(yaw) Ry(pitch) Rx(roll).
struct MeshSettings {
  enum class Side { outward, inward };
  std::filesystem::path file;
  LengthUnit unit = LengthUnit::m;                         // of the file's numbers
  Eigen::Vector3d position = Eigen::Vector3d::Zero();      // p_WF [m]
  Eigen::Vector3d rotation_deg = Eigen::Vector3d::Zero();  // roll, pitch, yaw
  Side side = Side::outward;  // drawn on; outward: as wound, and away from a closed mesh's inside
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
  MeshSettings mesh;
  Eigen::Vector3d move = Eigen::Vector3d::
      Zero();  // all of it, after it has been turned: p = move + Rz(turn) p_made [m]
  double turn_deg = 0.0;
};

void describe(Fields& f, CanvasSettings& s);

// The shape of that kind. Throws InputError, naming the setting, where it is none. What had to be
// repaired in a mesh file is added to `repaired`, one line each, if that is given.
TriangleMesh make_mesh(const CanvasSettings& settings,
                       std::vector<std::string>* repaired = nullptr);

}  // namespace impedraw
