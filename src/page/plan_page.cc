#include "impedraw/page/plan_page.h"

#include <nlohmann/json.hpp>

#include "impedraw/page/page_json.h"

namespace impedraw {

namespace {

nlohmann::json findings_json(PackedColumns& columns, const std::vector<PageFinding>& findings) {
  nlohmann::json out = nlohmann::json::array();
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

}  // namespace

PagePayload make_payload(const PlanPage& plan, const PageContext& context) {
  using Json = nlohmann::json;
  PackedColumns columns;
  PageMesh mesh;
  Json out = begun_page(columns, "plan", plan.title, plan, context, &mesh);
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

}  // namespace impedraw
