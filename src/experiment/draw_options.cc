#include "impedraw/experiment/draw_options.h"

#include <algorithm>
#include <cstdio>
#include <set>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/file_extension.h"
#include "impedraw/drawing/shapes.h"
#include "impedraw/files/data_folder.h"
#include "impedraw/settings/setting_error.h"
#include "impedraw/terminal/say.h"

namespace impedraw {

namespace fs = std::filesystem;

namespace {

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
  check("path.tilt_speed", s.path.tilt_speed);
  check("path.turn_speed", s.path.turn_speed);
  if (by_touch) check("blind.touch.turn_rate", s.blind.touch.turn_rate);
}

}  // namespace

Scenario resolve(const DrawOptions& options, Places* given) {
  Scenario scenario;
  if (!options.image.empty() && !is_picture_file(options.image))
    throw InputError(
        fmt::format("--image {}: is no picture by its name; valid are .png, .jpg, .jpeg",
                    options.image.string()));
  const fs::path& artwork_file = options.image.empty() ? options.svg : options.image;
  const bool artwork_given = !artwork_file.empty() || !options.text.empty();
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
  // What the built-in scenario gives was given by nobody: its places are dropped.
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
  if (!artwork_file.empty()) {
    const std::string given_as = options.image.empty() ? "--svg" : "--image";
    scenario.drawing.svg = fs::absolute(artwork_file);
    scenario.drawing.text.text.clear();
    name_after(artwork_file.stem().string());
    if (!named) places.put("name", given_as + " " + shown(artwork_file.string()));
    places.put("drawing.svg", fmt::format("{} {}", given_as, artwork_file.string()));
  }
  if (!options.text.empty()) {
    scenario.drawing.text.text = options.text;
    scenario.drawing.svg.clear();
    name_after("text");
    places.put("drawing.text.text", fmt::format("--text {}", shown(options.text)));
  }
  if (options.trace) {
    scenario.drawing.image.style = PictureStyle::trace;
    places.put("drawing.image.style", "--trace");
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
