// Describes the contents of a file without drawing it.
//
// Artwork (.svg, .txt, .strokes, .csv): strokes, length_mm, bbox_mm [x0, y0, x1, y1] of their
// centrelines on the page, y down (null without strokes), layers [{name, strokes}] in the
// document's order, warnings. One-point strokes are dots and have no length.
//
// Cloud (.pcd, .xyz, .ply without faces): points, invalid (those that are skipped), bbox_m,
// normals, colours, viewpoints_m.
#pragma once

#include <filesystem>

#include <nlohmann/json_fwd.hpp>

#include "impedraw/canvas/mesh_file.h"

namespace impedraw {

// Throws InputError like read_artwork(). An empty drawing is a warning, not an error.
nlohmann::ordered_json describe_artwork(const std::filesystem::path& file);

// Prints what an artwork, a cloud or, by its name's ending, a mesh holds (app/inspect.h), as
// JSON or as lines to be read. Returns the exit code.
int inspect(const std::filesystem::path& file, bool json, const MeshReading& reading = {});

// Describes the contents of a mesh file.

// triangles: as in the file, polygons cut. Of the merged and repaired surface
// (canvas/mesh_check.h), in the file's own pose with z up: bbox_m [x0, y0, z0, x1, y1, z1],
// area_m2, closed, components, slope_max_deg (largest angle of a facet's normal to +z, 0 to 180),
// warnings [line], faults [{kind, count, first, repaired, message}]. InputError as load_mesh.
nlohmann::ordered_json describe_mesh(const std::filesystem::path& file, const MeshReading& reading);

}  // namespace impedraw
