#include "impedraw/page/plan_page.h"

#include <nlohmann/json.hpp>

#include "impedraw/page/page_json.h"

namespace impedraw {
namespace {

using Json = nlohmann::json;

Json findings_json(PackedColumns& columns, const std::vector<PageFinding>& findings) {
  Json out = Json::array();
  for (const PageFinding& f : findings)
    out.push_back({{"stroke", f.stroke},
                   {"from_mm", f.from_mm},
                   {"to_mm", f.to_mm},
                   {"problem", f.problem},
                   {"text", f.text},
                   {"world_m", vector_json(f.p_W)},
                   {"line", points_json(columns, f.line_W, 2e-5)},
                   {"q", numbers_json(f.q)}});
  return out;
}

Json target_of(PackedColumns& columns, const RunLogHeader& header) {
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

PagePayload make_payload(const PlanPage& plan, const PageContext& context) {
  PackedColumns columns;
  const PageMesh mesh = canvas_mesh(plan.canvas_vertices, plan.canvas_triangles);
  Json out = begun_page(columns, "plan", plan.title, plan, context, mesh);
  out["definitions"] = Json::array();
  out["metrics"] = out["limits"] = out["strokes"] = Json::object();
  out["plan"] = Json::parse(plan.numbers);
  out["scenario"] = plan.scenario;
  out["closed"] = out["complete"] = true;
  out["duration"] = plan.time.empty() ? 0.0 : plan.time.back();
  out["spans"] = Json::array();
  for (const Eigen::Vector3d& span : plan.spans)
    out["spans"].push_back({static_cast<int>(span[0]), span[1], span[2]});
  out["maps"] = Json::array();
  for (const PageMap& map : plan.maps)
    out["maps"].push_back(series_json(
        map.name, map.label, map.unit,
        {{"values",
          columns.add(
              mesh.vertices.size(), [&](std::size_t i) { return map.value(mesh.vertices[i]); },
              map.quantum)}}));
  out["findings"] = findings_json(columns, plan.findings);
  out["target"] = {{"points", points_json(columns, {}, 1.0)},
                   {"covered", columns.add(std::vector<double>{}, 1.0)},
                   {"begins", columns.add(std::vector<double>{}, 1.0)},
                   {"strokes", Json::array()}};

  Json& ink = out["ink"];
  ink["points"] = points_json(columns, plan.ink_W, 1e-5);
  ink["time"] = columns.add(plan.ink_time, 1e-3);
  ink["begins"] = columns.add(plan.ink_begins, 1.0);
  ink["stroke"] = columns.add(plan.ink_strokes, 1.0);
  ink["pass"] = columns.add(std::vector<double>(plan.ink_strokes.size(), 1.0), 1.0);
  ink["colours"] = Json::array();
  for (const PageSeries& s : plan.colours)
    ink["colours"].push_back(
        series_json(s.name, s.label, s.unit, {{"values", columns.add(s.values, s.quantum)}}));

  Json& scene = out["scene"];
  const std::size_t rows = plan.time.size();
  const std::vector<Eigen::Vector3d> no_force(
      rows, Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  scene["time"] = columns.add(plan.time, 1e-3);
  scene["joints"] = Json::array();
  for (std::size_t j = 0; j < plan.joint_names.size(); ++j)
    scene["joints"].push_back(columns.add(
        rows, [&](std::size_t i) { return plan.q[i][static_cast<Eigen::Index>(j)]; }, 1e-5));
  scene["tip"] = points_json(columns, plan.tip_W, 1e-5);
  scene["pen_axis"] = points_json(columns, plan.pen_axis_W, 1e-4);
  scene["force"] = points_json(columns, no_force, 1.0);
  scene["normal"] = points_json(columns, plan.normal_W, 1e-3);
  scene["mode"] = columns.add(plan.phase, 1.0);
  scene["stroke"] = columns.add(plan.stroke, 1.0);

  Json& plots = out["step_plots"];
  plots["time"] = scene["time"];
  plots["rows_per_point"] = 1.0;
  plots["series"] = Json::array();
  for (const PageSeries& s : plan.series)
    plots["series"].push_back(
        series_json(s.name, s.label, s.unit, {{"low", columns.add(s.values, s.quantum)}}));
  plots["series"].push_back(series_json("mode", "phase", "", {{"low", scene["mode"]}}));
  for (std::size_t j = 0; j < plan.joint_names.size(); ++j)
    plots["series"].push_back(series_json("position_" + std::to_string(j), "position", "rad",
                                          {{"low", scene["joints"][j]}}));
  out["joint_plots"] = out["torque_plots"] = no_plots(columns);
  out["step_times"] = nullptr;
  out["pictures"] = pictures_json(columns, plan.pictures);
  return {out.dump(-1, ' ', false, Json::error_handler_t::replace), columns.bytes()};
}

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
  PackedColumns columns;
  Json out = begun_page(columns, "live", page.title, header, context,
                        canvas_mesh(header.canvas_vertices, header.canvas_triangles));
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
