#include "impedraw/app/inspect_mesh.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "impedraw/canvas/mesh_check.h"

namespace impedraw {

nlohmann::ordered_json describe_mesh(const std::filesystem::path& file,
                                     const MeshReading& reading) {
  const CheckedMesh checked = load_mesh(file, reading);
  double area = 0.0, slope = 0.0;
  for (const auto& t : checked.mesh.triangles) {
    const Eigen::Vector3d& p = checked.mesh.vertices[t[0]];
    const Eigen::Vector3d twice =
        (checked.mesh.vertices[t[1]] - p).cross(checked.mesh.vertices[t[2]] - p);
    area += 0.5 * twice.norm();
    if (!is_thin(checked, t))
      slope = std::max(slope, std::atan2(twice.head<2>().norm(), twice.z()));
  }
  nlohmann::ordered_json found;
  found["triangles"] = checked.given_triangles;
  const Eigen::Vector3d low = checked.bounds.min(), high = checked.bounds.max();
  found["bbox_m"] = {low.x(), low.y(), low.z(), high.x(), high.y(), high.z()};
  found["area_m2"] = area;
  found["closed"] = checked.closed;
  found["components"] = checked.components;
  found["slope_max_deg"] = slope * 180.0 / std::numbers::pi;
  found["warnings"] = checked.warnings;
  found["faults"] = nlohmann::ordered_json::array();
  for (const MeshFault& fault : checked.faults) {
    found["faults"].push_back(nlohmann::ordered_json{{"kind", fault.kind},
                                                     {"count", fault.count},
                                                     {"first", fault.first},
                                                     {"repaired", fault.repaired},
                                                     {"message", fault.message}});
  }
  return found;
}

}  // namespace impedraw
