// What the pages of runs and of plans have in common: pieces of their JSON. Private to src/page.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "impedraw/log/log.h"
#include "impedraw/page/packed_columns.h"
#include "impedraw/page/page.h"
#include "impedraw/page/page_mesh.h"

namespace impedraw {

nlohmann::json points_json(PackedColumns& columns, const std::vector<Eigen::Vector3d>& points,
                           double quantum);
nlohmann::json vector_json(const Eigen::Vector3d& v);
nlohmann::json numbers_json(const Eigen::VectorXd& v);  // null where not finite

// A mesh of at most about `most` triangles, and a coarse one within `off` of that [m], where it has
// much fewer; `kept`: what became of it.
inline constexpr double kCanvasOff = 8e-5;  // as coarseOff of web/src/scene.ts
nlohmann::json mesh_json(PackedColumns& columns, const std::vector<Eigen::Vector3d>& vertices,
                         const std::vector<Eigen::Vector3i>& triangles, std::size_t most = 16000,
                         double off = kCanvasOff, PageMesh* kept = nullptr);

// `values` with name, label and unit.
nlohmann::json series_json(std::string name, std::string label, std::string unit,
                           nlohmann::json values);

// At most 15,000 points of the cloud.
// `colour`: 0xRRGGBB of each; may be empty.
nlohmann::json cloud_json(PackedColumns& columns, const std::vector<Eigen::Vector3d>& cloud,
                          const std::vector<int>& colour);

// Pictures that exist, with their content.
nlohmann::json pictures_json(PackedColumns& columns, const std::vector<PagePicture>& pictures);

// Plots without a point.
nlohmann::json no_plots(PackedColumns& columns);

// What every page begins with: format, kind, name, title; of the run, attributes, joints, modes,
// canvas, cloud; of the context, version, commit, command, settings, arm, arm_notice, cameras,
// drawing_axis, drawing_up, ink_width_mm. `canvas`: what became of its mesh.
nlohmann::json begun_page(PackedColumns& columns, const char* kind, const std::string& title,
                          const RunDescription& run, const PageContext& context,
                          PageMesh* canvas = nullptr);

// The content of a file; empty if there is none.
std::string text_of_file(const std::filesystem::path& path);

// The commit that the program was built from; empty where it was built without git.
std::string commit();

}  // namespace impedraw
