// Reads triangle meshes from files, without merging vertices or repairing faults.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "impedraw/canvas/triangle_mesh.h"

namespace impedraw {

inline constexpr char kMeshFiles[] = ".obj, .stl, .ply, .off, .glb, .gltf, .3mf or .dae";
bool is_mesh_file(const std::filesystem::path& file);  // by extension, ignoring case
// glTF, 3MF and Collada say what one unit is and which axis is up; the other formats do not.
bool says_frame(const std::filesystem::path& file);

// The meaning of a file's numbers.
struct MeshReading {
  std::optional<double> unit;  // length of one [m]; by default as the file says, or 1 m
  bool y_up = false;           // y points up in a file that does not say: it is turned to z
  // The middle of its extent in x and y, and its lowest point, are moved to the origin.
  bool recentre = false;

  MeshReading() = default;
  MeshReading(double metres) : unit(metres) {}
};

// Reads a file of one of kMeshFiles, selected by its extension, with z up. Text may be UTF-8 or
// UTF-16. Faces with more than three corners are triangulated; groups, solids and the meshes of a
// scene are concatenated. Lines, points, normals and materials are ignored, and no other file is
// opened but a glTF's buffers. A name may end in a colour, as part.ply#c01020: of a .ply or .obj
// whose vertices have colours, the faces of that colour alone are read. `warnings`, if given, gets
// a line for each oddity. Throws InputError naming the file and the fault: an unreadable or
// truncated file, a vertex without three finite numbers, a face with fewer than three corners, an
// index out of range, a point cloud, or no triangle at all.
TriangleMesh read_mesh(const std::filesystem::path& file, const MeshReading& reading,
                       std::vector<std::string>* warnings = nullptr);
// `text` is the content of a file named `name`.
TriangleMesh parse_mesh(std::string_view text, const std::string& name, const MeshReading& reading,
                        std::vector<std::string>* warnings = nullptr);

}  // namespace impedraw
