#include "impedraw/experiment/prepare.h"

#include <algorithm>
#include <cstdio>
#include <set>
#include <utility>

#include <fmt/format.h>

#include "impedraw/common/file_extension.h"
#include "impedraw/experiment/line_forces.h"
#include "impedraw/experiment/plan_notes.h"
#include "impedraw/experiment/tool_fit.h"
#include "impedraw/files/data_folder.h"
#include "impedraw/terminal/say.h"

namespace impedraw {

namespace fs = std::filesystem;

namespace {

// It has copies of what it reads, or keeps it: artwork and belief move on meanwhile.
std::shared_future<Distortion> distortion_beside(const PlacedArtwork& artwork,
                                                 const Belief& belief) {
  return std::async(std::launch::async,
                    [strokes = artwork.strokes, surface = belief.surface] {
                      return distortion_of_projection(strokes, surface);
                    })
      .share();
}

// Once for each former name, whatever number of scenarios a command reads.
void tell_renamed(const Places& places) {
  static std::set<std::string> told;
  for (const auto& [former, note] : places.notes())
    if (told.insert(former).second) say(stderr, "impedraw: {}\n", note);
}

// The name of a scenario is the name of its run's folder, with an ending for some commands.
void check_name(const std::string& name, const SettingErrors& setting_errors) {
  constexpr std::size_t kLongest = 240;  // bytes, of the 255 that a file system takes
  const bool control = std::any_of(name.begin(), name.end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || c == 0x7f;
  });
  if (!name.empty() && name.size() <= kLongest && name.find('/') == std::string::npos &&
      !name.starts_with('.') && !control && is_utf8(name))
    return;
  setting_errors.raise(
      {"name", "drawing.svg"},
      fmt::format("name is '{}'; it names a folder: valid are 1 to {} bytes of UTF-8 without '/', "
                  "control characters or a leading '.'",
                  shown(name), kLongest));
}

// A pen that the law holds back falls behind the plan.
void check_turning(const Scenario& s, const SettingErrors& setting_errors) {
  const double limit = s.control.limits.turn_speed;
  const bool by_touch = !s.perception.enabled && s.blind.height == BlindHeight::touch;
  const auto check = [&](const char* name, double speed) {
    if (speed > limit)
      setting_errors.raise(
          {name, "control.turn_speed_limit"},
          fmt::format("{} is {} rad/s, above control.turn_speed_limit, {} rad/s: valid is the "
                      "limit or less",
                      name, speed, limit));
  };
  check("path.turn_speed", s.path.turn_speed);
  if (by_touch) check("blind.touch.turn_rate", s.blind.touch.turn_rate);
  if (s.path.tilt_speed > limit)
    setting_errors.raise({"control.turn_speed_limit"},
                         fmt::format("control.turn_speed_limit is {} rad/s, below the {} rad/s at "
                                     "which the pen's axis may turn along a stroke",
                                     limit, s.path.tilt_speed));
}

}  // namespace

PreparedPlan prepare_plan(const Scenario& given, const Places& places, Unreachable unreachable,
                          const PrepareProgress& progress, SceneCache* scenes,
                          PlanSummary summary) {
  const SettingErrors setting_errors(places);
  require_own_settings(given.tool, places);
  Scenario scenario = given;
  scenario.drawing.placement = placement_settings(scenario.drawing);
  if (progress) progress("reading and ordering the artwork", 0.0);
  const auto ordering = [&](double share) {
    if (progress) progress("ordering the strokes", 0.05 + 0.15 * share);
  };
  PlacedArtwork artwork;
  const auto load = [&](const SurfaceHeight* surface) {
    artwork = load_artwork(scenario.drawing, setting_errors, ordering, surface);
    give_forces(scenario, setting_errors, &artwork);
  };
  const bool hatched_on_surface = hatches_surface(scenario.drawing);
  if (!hatched_on_surface) load(nullptr);
  if (progress) progress("looking at the canvas", 0.2);
  const Pose X_WP = drawing_frame(scenario.drawing);
  Scene scene = scenes ? scenes->take(scenario, X_WP, setting_errors)
                       : build_scene(scenario, X_WP, setting_errors);
  try {
    if (hatched_on_surface) load(scene.belief.height_unknown() ? nullptr : &scene.belief.surface);
    std::shared_future<Distortion> projected;
    if (summary == PlanSummary::beside) projected = distortion_beside(artwork, scene.belief);
    Plan plan = make_plan(scenario, artwork, scene.belief, unreachable, setting_errors, progress);
    if (auto note = friction_note(scenario, scene.belief.arm, plan.rest_q, X_WP.R.col(2),
                                  scene.truth.world->dry_friction()))
      plan.notes.push_back(*std::move(note));
    for (std::string& note : engraver_notes(scenario)) plan.notes.push_back(std::move(note));
    return {{std::move(scenario), std::move(artwork), std::move(scene.belief), std::move(plan),
             std::move(projected)},
            std::move(scene.truth)};
  } catch (...) {
    if (scenes) scenes->give_back(std::move(scene));
    throw;
  }
}

Prepared prepare(const Scenario& scenario, const Places& places, Unreachable unreachable,
                 const PrepareProgress& progress, SceneCache* scenes, PlanSummary summary) {
  std::vector<KeptInput> inputs = read_input_files(scenario);  // before their content is used
  PreparedPlan plan = prepare_plan(scenario, places, unreachable, progress, scenes, summary);
  try {
    ControlSetup control = control_for(&plan, places);
    Yardstick yardstick = yardstick_of(plan, plan.truth, progress);
    Truth truth = std::move(plan.truth);
    return {{std::move(plan), std::move(inputs), std::move(control), std::move(yardstick)},
            std::move(truth)};
  } catch (...) {
    if (scenes) scenes->give_back(scene_of(std::move(plan)));
    throw;
  }
}

Scenario resolve(const DrawOptions& options, Places* given) {
  Scenario scenario;
  const bool artwork_given = !options.svg.empty() || !options.text.empty();
  const bool named_file = !options.scenario.empty();
  const fs::path file =
      named_file ? options.scenario
      : options.built_in.empty()
          ? data_folder() / "scenarios" / (artwork_given ? "artwork.yaml" : "bowl-sine.yaml")
          : options.built_in;
  if (const std::string kind = lower_extension(file); kind == ".svg" || kind == ".csv")
    throw InputError(
        fmt::format("{0}: is artwork, where a scenario (.yaml) is expected; give it "
                    "as --svg {0}",
                    file.string()));
  scenario.name = file.stem();
  // Artwork from the command line names the run, with the scenario in front where one was given.
  bool named = false;  // by --set, which counts whatever is drawn
  const auto name_after = [&](const std::string& artwork) {
    if (named) return;
    scenario.name = options.scenario.empty() ? artwork : scenario.name + "-" + artwork;
  };
  Places places =
      read_settings(scenario, file, named_file ? options.assignments : std::vector<std::string>());
  // Nobody gave the built-in scenario's settings: their places are dropped.
  if (!named_file) places = read_settings(scenario, {}, options.assignments);
  tell_renamed(places);
  named = places.of("name").starts_with("--set ");
  if (!options.shape.empty()) {
    scenario.drawing.shape = options.shape;
    scenario.drawing.svg.clear();
    scenario.drawing.text.text.clear();
    name_after(options.shape);
    places.put("drawing.shape", fmt::format("--shape {}", options.shape));
  }
  if (!options.svg.empty()) {
    scenario.drawing.svg = fs::absolute(options.svg);
    scenario.drawing.text.text.clear();
    name_after(options.svg.stem().string());
    if (!named) places.put("name", "--svg " + shown(options.svg.string()));
    places.put("drawing.svg", fmt::format("--svg {}", options.svg.string()));
  }
  if (!options.text.empty()) {
    scenario.drawing.text.text = options.text;
    scenario.drawing.svg.clear();
    name_after("text");
    places.put("drawing.text.text", fmt::format("--text {}", shown(options.text)));
  }
  if (!options.arm.empty()) {
    scenario.arm.driver = options.arm == "sim"      ? ArmDriver::sim
                          : options.arm == "franka" ? ArmDriver::franka
                                                    : ArmDriver::iiwa_lcm;
    places.put("arm.driver", fmt::format("--arm {}", options.arm));
  }
  if (!options.layer.empty()) {
    scenario.drawing.layer = options.layer;
    places.put("drawing.layer", "--layer " + shown(options.layer));
  }
  if (options.keep_order) scenario.drawing.keep_order = true;
  if (options.skip_unreachable) scenario.drawing.skip_unreachable = true;
  if (options.no_perception) {
    scenario.perception.enabled = false;
    scenario.name += "-blind";
  }
  if (scenario.drawing.svg.empty() && scenario.drawing.text.text.empty()) {
    const std::string& shape = scenario.drawing.shape;
    const std::vector<std::string> shapes = shape_names();
    if (std::find(shapes.begin(), shapes.end(), shape) == shapes.end())
      throw InputError(fmt::format("{}: drawing.shape {}", places.of("drawing.shape"),
                                   not_among(shape, shapes)));
  }
  const SettingErrors setting_errors(places);
  check_name(scenario.name, setting_errors);
  check_turning(scenario, setting_errors);
  if (given) *given = places;
  return scenario;
}

}  // namespace impedraw
