// Pieces of JSON that the pages of runs and of plans have in common. Private to src/page.
#pragma once

#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <nlohmann/json_fwd.hpp>

#include "impedraw/log/log.h"
#include "impedraw/page/page.h"

namespace impedraw {

// Columns of numbers for a page, small after deflate: quantised, coded as differences, and laid out
// byte plane by byte plane. web/src/columns.ts reads them.
//
// Quantised    k_i = round(v_i / quantum); NaN and inf become gaps
// Differences  of order 0, 1 or 2 of k, whichever is smallest; within a gap k repeats
// Planes       zigzag(d) = 2d (d ≥ 0) or −2d − 1, as 1 to 4 bytes; all first bytes, then all second
// Gaps         lengths of alternating runs, first one of values: uint32, little endian
class PackedColumns {
 public:
  // Appends n values. Returns how to read them: {n, quantum, order, planes, at} and, with gaps,
  // {runs, runs_at}. Errors are at most quantum/2; values beyond ±1e8 quanta are clamped.
  nlohmann::json add(std::size_t n, const std::function<double(std::size_t)>& value,
                     double quantum);
  nlohmann::json add(std::span<const double> values, double quantum);

  // Appends bytes as they are. Returns {at, bytes}.
  nlohmann::json add_bytes(const std::string& bytes);

  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

nlohmann::json points_json(PackedColumns& columns, const std::vector<Eigen::Vector3d>& points,
                           double quantum);
nlohmann::json vector_json(const Eigen::Vector3d& v);
nlohmann::json numbers_json(const Eigen::VectorXd& v);  // null where not finite

nlohmann::json mesh_json(PackedColumns& columns, const PageMesh& mesh);

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

// The beginning of every page: format, kind, name, title; from the run, attributes, joints, modes,
// canvas, cloud; from the context, version, commit, command, settings, arm, arm_notice, cameras,
// drawing_axis, drawing_up, ink_width_mm.
nlohmann::json begun_page(PackedColumns& columns, const char* kind, const std::string& title,
                          const RunDescription& run, const PageContext& context,
                          const PageMesh& canvas);

// The content of a file; empty if there is none.
std::string text_of_file(const std::filesystem::path& path);

// The commit that the program was built from; empty where it was built without git.
std::string commit();

}  // namespace impedraw
