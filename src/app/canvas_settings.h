// The canvas of an experiment: which of the built-in shapes, and the sizes of each. Only those of its kind are read.
#pragma once

#include "app/settings.h"
#include "canvas/built_in.h"
#include "canvas/built_in_graphs.h"
#include "canvas/built_in_ruled.h"

namespace impedraw {

enum class CanvasKind { bowl, dome, plane, wave, saddle, cylinder, trough, cone, terrain };

struct CanvasSettings {
  CanvasKind kind = CanvasKind::bowl;
  CapSettings cap;  // bowl and dome
  PlaneSettings plane;
  WaveSettings wave;
  SaddleSettings saddle;
  CylinderSettings cylinder;  // cylinder and trough
  ConeSettings cone;
  TerrainSettings terrain;
};

void describe(Fields& f, CanvasSettings& s);

// The shape of that kind. Throws InputError, naming the setting, where it is none.
TriangleMesh make_mesh(const CanvasSettings& settings);

}  // namespace impedraw
