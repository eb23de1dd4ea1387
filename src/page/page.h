// The page of a run, of a plan (plan_page.h) or of several runs compared: one HTML file that opens
// from the disk, without a network, and shows them in three dimensions. web/ has its program; here
// it gets its data.
//
//   run.h5, metrics, settings ──> JSON + packed columns ──> deflate ──> base64 in the page
//
// The page only draws: all that it shows was computed here or in metrics.
#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "impedraw/arm/arm_shapes.h"
#include "impedraw/log/run_data.h"
#include "impedraw/metrics/ink_match.h"
#include "impedraw/metrics/metrics.h"

namespace impedraw {

struct PageMesh {
  std::vector<Eigen::Vector3d> vertices{};   // some of those given
  std::vector<Eigen::Vector3i> triangles{};  // into `vertices`
  // Fewer triangles on the same vertices: what a renderer without a graphics card draws. Empty
  // where that saves less than a third of them.
  std::vector<Eigen::Vector3i> coarse{};
  std::size_t of = 0;  // triangles given
  double error = 0.0;  // largest distance to the mesh given, as the method estimates it [m]
};

// Leaves at most about `most` triangles, or all if there are fewer: edges are collapsed where that
// changes the surface least (meshoptimizer); borders stay. A mesh that is still too large by then,
// as one of many loose pieces, is merged on a grid. The coarse ones are within about `off` [m].
PageMesh page_mesh(const std::vector<Eigen::Vector3d>& vertices,
                   const std::vector<Eigen::Vector3i>& triangles, std::size_t most, double off);

// The canvas, as a page shows it.
PageMesh canvas_mesh(const std::vector<Eigen::Vector3d>& vertices,
                     const std::vector<Eigen::Vector3i>& triangles);

struct PageSetting {
  std::string name, value, initial, unit, help;
};

struct PageCamera {
  Pose X_WC{};  // z forward, x right, y down
  double fov_y_deg = 60.0;
  int width = 640, height = 480;  // [px]
};

// The true shape of a link of the arm, in its frame L. Drawn in place of the link's `shapes`.
struct PageLinkMesh {
  int link = 0;  // of PageContext::arm
  PageMesh shape{};
};

// Data of a page that the log does not hold. All of it may be missing.
struct PageContext {
  std::vector<DrawnLink> arm{};  // empty: the pen alone is drawn
  std::vector<PageLinkMesh> meshes{};
  std::string meshes_notice{};               // their copyright and licence
  std::shared_ptr<const PageMesh> canvas{};  // canvas_mesh() of the log's; null: made here
  std::vector<PageCamera> cameras{};
  std::vector<PageSetting> settings{};
  std::string command{};                               // that repeats the run
  Eigen::Matrix3d R_WP = Eigen::Matrix3d::Identity();  // drawing frame
  double ink_width = 1.0;                              // [mm]
  std::function<void()> check{};  // called now and then; what it throws ends the work
};

// A file shown on the page: inert, as an image.
struct PagePicture {
  std::string title;
  std::filesystem::path file;  // .svg or .png
};

struct PageRun {
  std::string title;
  std::string name{};                   // among runs compared; empty: the title
  std::filesystem::path log;            // run.h5
  std::filesystem::path scenario_file;  // its text is shown; may be missing
  std::filesystem::path strokes_file;   // strokes.json; may be missing
  // Asked for last, so that they may be drawn meanwhile; those that exist are shown.
  std::function<std::vector<PagePicture>()> pictures;
  std::string limits = "{}";  // JSON: {metric: {min, max}}
};

// The data of the page: a JSON text that refers to `columns`, and these. Throws InputError if the
// log cannot be read.
struct PagePayload {
  std::string json;
  std::string columns;
};
PagePayload make_payload(const PageRun& page, const RunData& run, const InkMatch& drawn,
                         const Metrics& metrics, const PageContext& context);

// The whole HTML file. Each payload: uint32 length of the JSON (little endian), JSON, columns;
// deflated (zlib's format), base64. Several are separated by commas: runs compared. `socket`: the
// one address that the page may connect to, as in ws://127.0.0.1:8080; empty: none.
std::string page_html(const std::string& title, const std::vector<PagePayload>& payloads,
                      const std::string& socket = {});

// The page of ./impedraw place (app/place.h), which asks its server for its data.
std::string place_page_html();

}  // namespace impedraw
