
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <nlohmann/json.hpp>

#include "impedraw/app/commands.h"
#include "impedraw/canvas/mesh_check.h"
#include "impedraw/capture/capture.h"
#include "impedraw/capture/clean_view.h"
#include "impedraw/capture/cloud_file.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/file_extension.h"
#include "impedraw/common/input_file.h"
#include "impedraw/drawing/artwork_file.h"
#include "impedraw/drawing/dashes.h"
#include "impedraw/drawing/layers.h"
#include "impedraw/drawing/order.h"
#include "impedraw/terminal/say.h"

namespace impedraw {
namespace {

// Lengths are promised to 0.1 %: a chord that turns by a takes a²/24 off its arc.
SvgSettings fine() {
  SvgSettings settings;
  settings.tolerance_mm = 1e-3;
  settings.relative_tolerance = 1e-6;
  settings.turn = 0.05;
  settings.may_be_empty = true;
  return settings;
}

void print_artwork(const std::filesystem::path& file, const nlohmann::ordered_json& found) {
  say(stdout, "{}: {} strokes, {:.1f} mm\n", file.string(), found["strokes"].get<std::size_t>(),
      found["length_mm"].get<double>());
  say(stdout, "  as listed    {} points, {:.1f} mm in the air between strokes\n",
      found["points"].get<std::size_t>(), found["pen_up_mm"].get<double>());
  if (!found["bbox_mm"].is_null()) {
    const auto box = found["bbox_mm"].get<std::vector<double>>();
    say(stdout, "  on the page  x {:.2f} to {:.2f} mm, y {:.2f} to {:.2f} mm\n", box[0], box[2],
        box[1], box[3]);
  }
  for (const auto& layer : found["layers"])
    say(stdout, "  layer        {}: {} strokes\n", layer["name"].get<std::string>(),
        layer["strokes"].get<std::size_t>());
  for (const auto& colour : found["colours"])
    say(stdout, "  colour       {}: {} strokes, {:.1f} mm\n", colour["name"].get<std::string>(),
        colour["strokes"].get<std::size_t>(), colour["length_mm"].get<double>());
  for (const auto& warning : found["warnings"])
    say(stdout, "  warning      {}\n", warning.get<std::string>());
}

void print_mesh(const std::filesystem::path& file, const nlohmann::ordered_json& found) {
  const auto box = found["bbox_m"].get<std::vector<double>>();
  say(stdout, "{}: {} triangles, {:.6g} m²\n", file.string(), found["triangles"].get<std::size_t>(),
      found["area_m2"].get<double>());
  // Four digits of the extent, however far from the origin.
  const double size = std::max({box[3] - box[0], box[4] - box[1], box[5] - box[2], 1e-12});
  double far = 0.0;
  for (const double x : box) far = std::max(far, std::abs(x));
  const int digits = 4 + std::clamp(static_cast<int>(std::ceil(std::log10(far / size))), 0, 13);
  say(stdout,
      "  extent       x {:.{}g} to {:.{}g} m, y {:.{}g} to {:.{}g} m, z {:.{}g} to {:.{}g} m\n",
      box[0], digits, box[3], digits, box[1], digits, box[4], digits, box[2], digits, box[5],
      digits);
  say(stdout, "  surface      {}, components: {}, steepest slope {:.1f}°\n",
      found["closed"].get<bool>() ? "closed" : "open", found["components"].get<int>(),
      found["slope_max_deg"].get<double>());
  for (const auto& warning : found["warnings"])
    say(stdout, "  warning      {}\n", warning.get<std::string>());
  for (const auto& fault : found["faults"])
    say(stdout, "  {}  {}\n", fault["repaired"].get<bool>() ? "repaired     " : "fault      ",
        fault["message"].get<std::string>());
}

void print_cloud(const std::filesystem::path& file, const nlohmann::ordered_json& found) {
  const auto box = found["bbox_m"].get<std::vector<double>>();
  say(stdout, "{}: a cloud of {} points; {} more have no place\n", file.string(),
      found["points"].get<std::size_t>(), found["invalid"].get<std::size_t>());
  say(stdout, "  extent       x {:.4g} to {:.4g} m, y {:.4g} to {:.4g} m, z {:.4g} to {:.4g} m\n",
      box[0], box[3], box[1], box[4], box[2], box[5]);
  say(stdout, "  normals      {}\n  colours      {}\n  viewpoints   {}\n",
      found["normals"].get<bool>() ? "yes" : "none", found["colours"].get<bool>() ? "yes" : "none",
      found["viewpoints_m"].empty() ? "none" : found["viewpoints_m"].dump() + " m");
}

// A camera on the tool is told as it sits there: which arm it was is not known here.
nlohmann::ordered_json describe_capture(const std::filesystem::path& folder) {
  const Capture capture = read_capture(folder, [](const std::vector<double>&) { return Pose(); });
  nlohmann::ordered_json found;
  found["views"] = nlohmann::ordered_json::array();
  for (const CapturedView& view : capture.views) {
    double near = std::numeric_limits<double>::infinity(), far = 0.0;
    std::size_t measured = 0;
    for (const double z : view.depth.depth) {
      if (!std::isfinite(z)) continue;
      near = std::min(near, z), far = std::max(far, z);
      ++measured;
    }
    nlohmann::ordered_json one;
    one["depth"] = view.name;
    one["size_px"] = {view.lens.width, view.lens.height};
    one["measured_px"] = measured;
    one["depth_m"] = nullptr;
    if (measured > 0) one["depth_m"] = {near, far};
    one["noise_at_1m_m"] = noise_at_1m(view);
    one["quantum_m"] = view.quantum;
    one["camera_m"] = {view.X_WC.p.x(), view.X_WC.p.y(), view.X_WC.p.z()};
    one["joints"] = view.joints.size();
    one["colours"] = !view.rgb.empty();
    found["views"].push_back(one);
  }
  found["notes"] = capture.notes;
  return found;
}

void print_capture(const std::filesystem::path& folder, const nlohmann::ordered_json& found) {
  say(stdout, "{}: a capture of {} views\n", folder.string(), found["views"].size());
  for (const auto& view : found["views"]) {
    const auto size = view["size_px"].get<std::vector<int>>();
    const auto at = view["camera_m"].get<std::vector<double>>();
    std::string depths = "no depth";
    if (!view["depth_m"].is_null())
      depths = fmt::format("{:.3f} to {:.3f} m", view["depth_m"][0].get<double>(),
                           view["depth_m"][1].get<double>());
    say(stdout,
        "  {}  {} × {} px, {} of them measured, {}; noise {:.2f} mm at 1 m, steps of {:.3g} mm; "
        "camera at ({:.3f}, {:.3f}, {:.3f}) m{}{}\n",
        view["depth"].get<std::string>(), size[0], size[1], view["measured_px"].get<std::size_t>(),
        depths, 1e3 * view["noise_at_1m_m"].get<double>(), 1e3 * view["quantum_m"].get<double>(),
        at[0], at[1], at[2], view["joints"].get<int>() > 0 ? ", with joints" : "",
        view["colours"].get<bool>() ? ", in colours" : "");
  }
  for (const auto& text : found["notes"]) say(stdout, "  note  {}\n", text.get<std::string>());
}

nlohmann::ordered_json describe_cloud(const std::filesystem::path& file) {
  const CloudFile cloud = read_cloud_file(file);
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : cloud.points) box.extend(p);
  nlohmann::ordered_json found;
  found["points"] = cloud.points.size();
  found["invalid"] = cloud.invalid;
  found["bbox_m"] = {box.min().x(), box.min().y(), box.min().z(),
                     box.max().x(), box.max().y(), box.max().z()};
  found["normals"] = !cloud.normals.empty();
  found["colours"] = !cloud.rgb.empty();
  found["viewpoints_m"] = nlohmann::ordered_json::array();
  for (const Eigen::Vector3d& p : cloud.viewpoints)
    found["viewpoints_m"].push_back({p.x(), p.y(), p.z()});
  return found;
}

}  // namespace

nlohmann::ordered_json describe_artwork(const std::filesystem::path& file) {
  const Artwork artwork = read_artwork(file, fine());
  const Eigen::AlignedBox2d box = bounds_of(artwork.strokes);
  std::vector<std::size_t> strokes(artwork.layers.size(), 0);
  std::map<std::uint32_t, std::vector<Stroke>> colours;
  std::size_t dash_count = 0;
  for (const Stroke& stroke : artwork.strokes) {
    ++strokes.at(stroke.layer);
    colours[stroke.colour].push_back(stroke);
    dash_count += stroke.dash >= 0;
  }
  const StrokeStatistics statistics = stroke_statistics(artwork.strokes);
  nlohmann::ordered_json found;
  found["strokes"] = statistics.strokes;
  found["length_mm"] = statistics.pen_down_mm;
  found["bbox_mm"] = nullptr;
  if (!box.isEmpty())
    found["bbox_mm"] = {box.min().x(), box.min().y(), box.max().x(), box.max().y()};
  found["layers"] = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < artwork.layers.size(); ++i)
    found["layers"].push_back(
        nlohmann::ordered_json{{"name", artwork.layers[i]}, {"strokes", strokes[i]}});
  found["colours"] = nlohmann::ordered_json::array();
  for (const auto& [colour, of_colour] : colours)
    found["colours"].push_back(nlohmann::ordered_json{{"name", colour_name(colour)},
                                                      {"strokes", of_colour.size()},
                                                      {"length_mm", pen_down_length(of_colour)}});
  found["widths_mm"] = nullptr;
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const Stroke& stroke : artwork.strokes) {
    std::vector<double> widths{stroke.width};
    if (!stroke.press.empty()) widths = stroke.by_force ? std::vector<double>{} : stroke.press;
    for (const double width : widths) {
      if (width > 0.0) least = std::min(least, width);
      most = std::max(most, width);
    }
  }
  if (most > 0.0) found["widths_mm"] = {least, most};
  found["warnings"] = artwork.warnings;
  if (dash_count > 0) {
    const StrokeStatistics broken = stroke_statistics(dashed(artwork.strokes, artwork.dashes));
    found["warnings"].push_back(
        fmt::format("{} dashed lines are counted as solid; with their dashes there are {} strokes, "
                    "{:.1f} mm",
                    dash_count, broken.strokes, broken.pen_down_mm));
  }
  found["hidden_mm"] = artwork.hidden_mm;
  found["doubled_mm"] = artwork.doubled_mm;
  found["points"] = statistics.points;
  found["pen_up_mm"] = statistics.pen_up_mm;
  return found;
}

int inspect(const std::filesystem::path& file, bool json, const MeshReading& reading) {
  const bool capture = std::filesystem::exists(file / "capture.json");
  if (!capture && InputFile(file).size() == 0)
    throw InputError(fmt::format("{}: the file is empty", file.string()));
  if (lower_extension(file) == ".yaml")
    throw InputError(fmt::format(
        "{0}: is no artwork and no mesh; ./impedraw plan {0} checks a scenario", file.string()));
  const bool cloud = !capture && is_cloud_file(file);
  // Or of an unknown kind, which read_mesh() refuses.
  const bool mesh = !capture && !cloud && !is_artwork_file(file);
  nlohmann::ordered_json found;
  try {
    found = capture ? describe_capture(file)
            : cloud ? describe_cloud(file)
            : mesh  ? describe_mesh(file, reading)
                    : describe_artwork(file);
  } catch (const InputError& error) {
    if (!mesh || is_mesh_file(file)) throw;
    throw InputError(
        fmt::format("{}; artwork is .svg, .txt, .strokes or .csv, a "
                    "cloud .ply, .pcd or .xyz",
                    error.what()));
  }
  if (json)
    say(stdout, "{}\n",
        found.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  else if (capture)
    print_capture(file, found);
  else if (cloud)
    print_cloud(file, found);
  else if (mesh)
    print_mesh(file, found);
  else
    print_artwork(file, found);
  return kFinished;
}

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
