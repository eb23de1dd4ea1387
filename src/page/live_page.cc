#include "impedraw/page/live_page.h"

#include <nlohmann/json.hpp>

#include "impedraw/page/page_json.h"

namespace impedraw {

namespace {

nlohmann::json no_series(PackedColumns& columns) {
  return {{"time", columns.add(std::vector<double>{}, 1.0)},
          {"rows_per_point", 1.0},
          {"terms", nlohmann::json::array()},
          {"series", nlohmann::json::array()}};
}

nlohmann::json target_of(PackedColumns& columns, const RunLogHeader& header) {
  std::vector<double> begins;
  std::vector<int> strokes;
  for (std::size_t i = 0; i < header.target_stroke.size(); ++i) {
    if (i > 0 && header.target_stroke[i] == header.target_stroke[i - 1]) continue;
    begins.push_back(static_cast<double>(i));
    strokes.push_back(header.target_stroke[i]);
  }
  return {{"points", points_json(columns, header.target_points, 1e-6)},
          {"covered", columns.add(std::vector<double>(header.target_points.size(), 1.0), 1.0)},
          {"begins", columns.add(begins, 1.0)},
          {"strokes", strokes}};
}

}  // namespace

std::vector<std::string> live_columns(const RunLogHeader& header) {
  std::vector<std::string> names = {"time", "wall"};
  const std::size_t n = header.joint_names.size();
  const auto each_joint = [&](const std::string& name) {
    for (std::size_t j = 0; j < n; ++j) names.push_back(name + "_" + std::to_string(j));
  };
  for (const char* name : {"position", "velocity", "torque"}) each_joint(name);
  for (const char* name : {"tip", "pen_axis", "contact_force", "normal", "contact_point"})
    for (const char* axis : {"_x", "_y", "_z"}) names.push_back(std::string(name) + axis);
  for (const char* name : {"force", "push", "tilt", "normal_error", "torque", "surface_distance",
                           "mode", "stroke", "time_scale", "step_time", "share"})
    names.emplace_back(name);
  for (const std::string& term : header.torque_terms) each_joint(term);
  if (header.moving_canvas)
    for (const char* name : {"x", "y", "z", "qw", "qx", "qy", "qz"})
      names.push_back(std::string("canvas_pose_") + name);
  return names;
}

PagePayload make_payload(const LivePage& page, const RunLogHeader& header,
                         const PageContext& context) {
  using Json = nlohmann::json;
  PackedColumns columns;
  Json out;
  out["format"] = 1;
  out["kind"] = "live";
  out["name"] = out["title"] = page.title;
  out["live"] = {
      {"columns", live_columns(header)}, {"duration", page.duration}, {"strokes", page.strokes}};
  out["attributes"] = Json::object();
  for (const auto& [key, value] : header.attributes)
    if (key != "settings" && key != "promise" && value.size() < 200) out["attributes"][key] = value;
  out["definitions"] = Json::array();
  out["metrics"] = out["limits"] = out["strokes"] = Json::object();
  out["scenario"] = page.scenario;
  out["closed"] = out["complete"] = true;
  out["duration"] = 0.0;
  out["joints"] = {{"names", header.joint_names},
                   {"lower", numbers_json(header.joint_lower)},
                   {"upper", numbers_json(header.joint_upper)},
                   {"speed", numbers_json(header.joint_speed_limit)},
                   {"torque", numbers_json(header.torque_limit)}};
  out["modes"] = header.mode_names;
  add_context(columns, context, header.joint_names, &out);
  out["spans"] = Json::array();
  out["canvas"] = mesh_json(columns, header.canvas_vertices, header.canvas_triangles);
  out["cloud"] = cloud_json(columns, header.cloud_points, header.cloud_colour);
  out["target"] = target_of(columns, header);
  const Json none = columns.add(std::vector<double>{}, 1.0), nowhere = {none, none, none};
  out["ink"] = {{"points", nowhere}, {"time", none},   {"force", none},
                {"error", none},     {"tilt", none},   {"speed", none},
                {"begins", none},    {"stroke", none}, {"pass", none}};
  out["scene"] = {
      {"time", none},     {"joints", std::vector<Json>(header.joint_names.size(), none)},
      {"tip", nowhere},   {"pen_axis", nowhere},
      {"force", nowhere}, {"normal", nowhere},
      {"mode", none},     {"stroke", none}};
  out["step_plots"] = out["joint_plots"] = no_series(columns);
  out["torque_plots"] = no_series(columns);
  out["torque_plots"]["terms"] = header.torque_terms;
  out["step_times"] = nullptr;
  out["pictures"] = Json::array();
  return {out.dump(-1, ' ', false, Json::error_handler_t::replace), columns.bytes()};
}

std::string data_of_page(const std::string& html) {
  const std::string_view mark = "id=\"data\">";
  const std::size_t begin = html.find(mark);
  if (begin == std::string::npos) return {};
  const std::size_t from = begin + mark.size(), end = html.find('<', from);
  return end == std::string::npos ? std::string() : html.substr(from, end - from);
}

}  // namespace impedraw
