#include "impedraw/app/commands.h"

#include <cmath>
#include <cstdlib>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/canvas/mesh_file.h"
#include "impedraw/common/errors.h"
#include "impedraw/experiment/cover.h"
#include "impedraw/experiment/marked_areas.h"
#include "impedraw/experiment/place_surface.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/live/page_server.h"
#include "impedraw/page/page.h"
#include "impedraw/settings/settings_text.h"
#include "impedraw/settings/yaml_write.h"
#include "impedraw/terminal/interrupt.h"
#include "impedraw/terminal/progress.h"
#include "impedraw/terminal/say.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* kTroubles[] = {"none", "missing", "steep", "edge", "avoided", "out of reach"};
constexpr std::size_t kMostPoints = 60000;  // of the cloud on the page
constexpr double kFarthest = 5.0;           // from the middle of the drawing plane [m]

// Rounded to 0.01 mm, so that the page's data stay small.
void add(const Eigen::Vector3d& p, Json* numbers) {
  for (const double x : p) numbers->push_back(std::round(1e5 * x) / 1e5);
}

Json data_of(const PlaceBench& bench) {
  const PlaceSearch& search = bench.search();
  Json data;
  Json& cells = data["cells"];
  cells = {{"columns", search.columns()}, {"rows", search.rows()},       {"side", search.side()},
           {"x", search.box().min().x()}, {"y", search.box().min().y()}, {"heights", Json::array()},
           {"troubles", Json::array()},   {"words", kTroubles}};
  for (int j = 0; j < search.rows(); ++j)
    for (int i = 0; i < search.columns(); ++i) {
      const float z = search.heights()[static_cast<std::size_t>(j) * search.columns() + i];
      const Eigen::Vector2d p =
          search.box().min() + search.side() * Eigen::Vector2d(i + 0.5, j + 0.5);
      cells["heights"].push_back(std::isnan(z) ? Json() : Json(std::round(1e5 * z) / 1e5));
      cells["troubles"].push_back(static_cast<int>(search.trouble(p)));
    }
  const Pose& X_WP = bench.X_WP();
  data["X_WP"] = Json::array();
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) data["X_WP"].push_back(X_WP.R(r, c));
    data["X_WP"].push_back(X_WP.p[r]);
  }
  Json points = Json::array(), triangles = Json::array(), cloud = Json::array();
  if (const TriangleMesh* mesh = bench.known_mesh()) {
    for (const Eigen::Vector3d& p : mesh->vertices) add(p, &points);
    for (const Eigen::Vector3i& t : mesh->triangles)
      for (const int v : t) triangles.push_back(v);
  }
  const std::vector<Eigen::Vector3d> seen = bench.cloud();
  const std::size_t stride = 1 + seen.size() / kMostPoints;
  for (std::size_t i = 0; i < seen.size(); i += stride) add(seen[i], &cloud);
  data["mesh"] = {{"points", points}, {"triangles", triangles}};
  data["cloud"] = cloud;
  Json strokes = Json::array();
  for (const auto& stroke : bench.strokes()) {
    Json line = Json::array();
    for (const Eigen::Vector2d& p : stroke)
      for (const double x : p) line.push_back(std::round(1e6 * x) / 1e6);
    strokes.push_back(line);
  }
  data["strokes"] = strokes;
  const PlaceFound given = bench.given();
  data["given"] = {{"x", given.middle.x()}, {"y", given.middle.y()}, {"turn", 0.0}, {"size", 1.0}};
  data["name"] = bench.scenario().name;
  return data;
}

PlaceFound placement_in(const Json& question) {
  const auto number = [&](const char* key, double least, double most) {
    const auto found = question.find(key);
    if (found == question.end() || !found->is_number() ||
        !(found->get<double>() >= least && found->get<double>() <= most))
      throw InputError(fmt::format("'{}' must be a number from {:g} to {:g}", key, least, most));
    return found->get<double>();
  };
  PlaceFound place;
  place.middle = {number("x", -kFarthest, kFarthest), number("y", -kFarthest, kFarthest)};
  place.turn_deg = number("turn", -360.0, 360.0);
  place.size = number("size", 0.01, 100.0);
  return place;
}

// "areas": [[x, y, x, y, …], …].
std::vector<std::vector<Eigen::Vector2d>> areas_in(const Json& question) {
  const auto wrong = [] {
    return InputError("'areas' must be a list of outlines: lists of x and y by turns [m]");
  };
  const Json& areas = question.at("areas");
  if (!areas.is_array()) throw wrong();
  std::vector<std::vector<Eigen::Vector2d>> outlines;
  for (const Json& area : areas) {
    if (!area.is_array() || area.size() % 2 != 0) throw wrong();
    std::vector<Eigen::Vector2d>& outline = outlines.emplace_back(area.size() / 2);
    for (std::size_t k = 0; k < area.size(); ++k) {
      if (!area[k].is_number()) throw wrong();
      outline[k / 2][k % 2] = area[k].get<double>();
      if (!(std::abs(outline[k / 2][k % 2]) <= kFarthest)) throw wrong();
    }
  }
  return outlines;
}

Json checked(const PlaceBench& bench, const PlaceFound& place) {
  const PlaceBench::QuickCheck found = bench.check(place);
  Json lost = Json::object();
  for (const auto& [trouble, length] : found.lost)
    lost[kTroubles[static_cast<int>(trouble)]] = 1e3 * length;
  return {{"share", found.share},           {"length_mm", 1e3 * found.length},
          {"time_s", found.time},           {"width_mm", found.size_mm.x()},
          {"height_mm", found.size_mm.y()}, {"lost_mm", lost}};
}

// Opens the system's browser, if there is one.
void open_browser(const std::string& address) {
  const std::string command = fmt::format("xdg-open '{}' >/dev/null 2>&1 &", address);
  if (std::system(command.c_str()) != 0) return;  // the address is printed, too
}

}  // namespace

int place_by_hand(DrawOptions options, const PlaceOptions& place) {
  if (is_mesh_file(options.scenario)) {
    options.assignments.insert(
        options.assignments.begin(),
        {"canvas.kind=mesh",
         "canvas.mesh.file=" + yaml_string(fs::absolute(options.scenario).string())});
    options.scenario.clear();
  }
  Places places;
  const Scenario scenario = resolve(options, &places);
  const auto bench = [&] {
    ProgressLine line;
    line.update("looking at the surface", 0.0);
    return std::make_unique<PlaceBench>(scenario, places);
  }();
  PageServer server(place.port);
  bool ended = false;
  PageServerContent content;
  content.page = place_page_html();
  content.data = data_of(*bench).dump();
  content.answer = [&](const std::string& name, const std::string& text) -> std::string {
    if (name == "end") {
      ended = true;
      return "{}";
    }
    const Json question = Json::parse(text, nullptr, false);
    if (!question.is_object()) throw InputError("a question is a JSON object");
    if (name == "check") return checked(*bench, placement_in(question)).dump();
    if (name == "plan") return Json{{"share", bench->share_of_plan(placement_in(question))}}.dump();
    if (name != "save")
      throw InputError(fmt::format("'{}' is no question; valid are check, plan, save, end", name));
    const auto free_for = [&](const fs::path& target) {
      std::error_code none;
      if (fs::exists(target, none) && !question.value("overwrite", false))
        throw InputError(fmt::format("{} is there; 'overwrite' replaces it", target.string()));
      return target;
    };
    const fs::path target = free_for(place.save);
    const bool marked = question.contains("areas");
    Scenario placed;
    if (marked) {
      const MarkedAreas areas = marked_areas(areas_in(question));
      placed = with_cover_defaults(bench->scenario(), places);
      placed.cover.region =
          fs::absolute(free_for(fs::path(target).replace_extension(".areas.svg")));
      placed.drawing.placement = areas.placement;
      write_whole(placed.cover.region, areas.svg);
    } else {
      placed = bench->scenario_at(placement_in(question));
    }
    write_whole(target, settings_yaml(placed));
    const std::string file = fs::absolute(target).lexically_normal().string();
    say(stdout, "saved    {}\n         ./impedraw {} {}\n", file, marked ? "cover" : "draw",
        target.string());
    return Json{{"file", file}}.dump();
  };
  const Interrupt interrupt;
  say(stdout, "page     {}\n         ctrl-C ends it; Save writes {}\n", server.address(),
      place.save.string());
  std::fflush(stdout);
  if (!place.headless) open_browser(server.address());
  server.run(content, [&] { return ended || interrupt.requested(); });
  return kFinished;
}

}  // namespace impedraw
