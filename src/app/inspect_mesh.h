// Describes the contents of a mesh file.
#pragma once

#include <filesystem>

#include <nlohmann/json_fwd.hpp>

#include "impedraw/canvas/mesh_file.h"

namespace impedraw {

// triangles: as in the file, polygons cut. Of the merged and repaired surface
// (canvas/mesh_check.h), in the file's own pose with z up: bbox_m [x0, y0, z0, x1, y1, z1],
// area_m2, closed, components, slope_max_deg (largest angle of a facet's normal to +z, 0 to 180),
// warnings [line], faults [{kind, count, first, repaired, message}]. InputError as load_mesh.
nlohmann::ordered_json describe_mesh(const std::filesystem::path& file, const MeshReading& reading);

}  // namespace impedraw
