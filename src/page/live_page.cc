#include "impedraw/page/live_page.h"

#include <nlohmann/json.hpp>

#include "impedraw/page/page_json.h"

namespace impedraw {

namespace {

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
  Json out = begun_page(columns, "live", page.title, header, context);
  out["live"] = {
      {"columns", live_columns(header)}, {"duration", page.duration}, {"strokes", page.strokes}};
  out["definitions"] = Json::array();
  out["metrics"] = out["limits"] = out["strokes"] = Json::object();
  out["scenario"] = page.scenario;
  out["closed"] = out["complete"] = true;
  out["duration"] = 0.0;
  out["spans"] = Json::array();
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
  out["step_plots"] = out["joint_plots"] = no_plots(columns);
  out["torque_plots"] = no_plots(columns);
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
