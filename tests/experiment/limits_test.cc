// Every bound of every number in a scenario: the library takes what the schema allows, and the
// schema refuses what lies just beyond. Where settings bound one another, the others are set so
// that they leave room.
#include <cmath>
#include <fstream>
#include <map>
#include <regex>
#include <sstream>

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/control/contact_mode.h"
#include "impedraw/control/impedance_settings.h"
#include "impedraw/control/momentum_observer.h"
#include "impedraw/experiment/scenario.h"
#include "impedraw/sensing/touch_surface.h"
#include "impedraw/settings/settings_doc.h"
#include "impedraw/settings/yaml_read.h"
#include "impedraw/settings/yaml_write.h"
#include "impedraw/simulation/joint_sensor.h"
#include "impedraw/simulation/world.h"
#include "impedraw/simulation/wrench_sensor.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

const fs::path kRoot = IMPEDRAW_SOURCE;

struct Bounded {
  std::string name;  // as --set takes it
  Range range;
  bool whole = false;
};

void collect(std::vector<Bounded>& all, const std::string& name, const Setting& setting,
             const Range& range) {
  if (const auto* group = std::get_if<Group>(&setting.value)) {
    for (const Setting& field : group->fields)
      collect(all, name.empty() ? field.name : name + "." + field.name, field, field.range);
  } else if (const auto* optional = std::get_if<Optional>(&setting.value)) {
    optional->engage(true);
    collect(all, name, optional->value(), range);
    optional->engage(false);
  } else if (const auto* list = std::get_if<List>(&setting.value)) {
    const auto [owner, element] = list->sample();
    collect(all, name + ".0", element, element.range);
  } else if (std::holds_alternative<Numbers>(setting.value)) {
    all.push_back({name + ".0", range});
  } else if (const std::string type = std::get<Scalar>(setting.value).type;
             type == "number" || type == "whole number") {
    all.push_back({name, range, type == "whole number"});
  }
}

std::vector<Bounded> all_bounded() {
  Scenario scenario;
  std::vector<Bounded> all;
  collect(all, "", Setting{"", "", "", Range::any(), described(scenario)}, Range::any());
  return all;
}

// What else has to be set for a value at that bound to make sense, by "NAME lowest" or "NAME
// highest", else by the longest beginning of the name.
const std::map<std::string, Words> kCompanions = {
    {"arm.q_0", {"arm.q_0=[0]"}},
    {"arm.rotor_inertia", {"arm.rotor_inertia=[0]"}},
    {"world.errors.rotor_inertia", {"world.errors.rotor_inertia=[0]"}},
    {"world.errors.pens_longer", {"world.errors.pens_longer=[0]"}},
    {"arm.joint_stiffness", {"arm.joint_stiffness=[1000]"}},
    {"world.joint_spring.stiffness",
     {"world.joint_spring.rotor_inertia=[1]", "world.joint_spring.stiffness=[1000]"}},
    {"world.joint_spring.rotor_inertia", {"world.joint_spring.rotor_inertia=[1]"}},
    {"world.joint_spring.damping", {"world.joint_spring.damping=[1]"}},
    {"arm.posture_seed", {"arm.posture_seed=[0]"}},
    {"control.null_stiffness", {"control.null_stiffness=[0]"}},
    {"control.observer.yield_limit", {"control.observer.yield_limit=[0]"}},
    {"perception.viewpoint", {"perception.viewpoint=[0, 0, 0]"}},
    {"pushes", {"pushes=[{}]"}},
    {"pens", {"pens=[{}]"}},
    {"faults", {"faults=[{}]"}},
    {"perception.fiducials", {"perception.fiducials.points=[{}]"}},
    {"drawing.placement.margin", {"drawing.placement.fit_width=2"}},
    {"perception.region_lower", {"perception.region_upper=[10, 10, 10]"}},
    {"perception.region_upper", {"perception.region_lower=[-10, -10, -10]"}},
    {"canvas.cap.radius lowest", {"canvas.cap.opening_radius=0.005"}},
    {"canvas.cap.opening_radius highest", {"canvas.cap.radius=10"}},
    {"canvas.plane.edge lowest", {"canvas.plane.width=0.01", "canvas.plane.height=0.01"}},
    {"canvas.cylinder.radius lowest", {"canvas.cylinder.width=0.01"}},
    {"canvas.cylinder.width highest", {"canvas.cylinder.radius=10"}},
    {"canvas.mesh",
     {"canvas.mesh.unit=mm",
      "canvas.mesh.file=" + (kRoot / "tests/data/flower_tile.obj").string()}},
};

Words companions(const std::string& name, const char* end) {
  if (const auto exact = kCompanions.find(name + " " + end); exact != kCompanions.end())
    return exact->second;
  for (std::string head = name; !head.empty();) {
    if (const auto found = kCompanions.find(head); found != kCompanions.end()) return found->second;
    head.resize(head.rfind('.') == std::string::npos ? 0 : head.rfind('.'));
  }
  return {};
}

Scenario with(const Bounded& b, const char* end, double value) {
  Words assignments = companions(b.name, end);
  // The canvas is of the kind whose sizes are set.
  std::smatch kind;
  if (std::regex_search(
          b.name, kind,
          std::regex("^canvas\\.(cap|plane|wave|saddle|cylinder|cone|terrain|mesh)\\.")))
    assignments.push_back("canvas.kind=" + (kind[1] == "cap" ? "bowl" : kind[1].str()));
  assignments.push_back(
      b.name + "=" +
      (b.whole ? number_text(static_cast<std::int64_t>(value)) : number_text(value)));
  Scenario scenario;
  read_settings(scenario, "", assignments);
  return scenario;
}

Artwork made_artwork() {
  Artwork artwork;
  artwork.name = "square";
  artwork.layers = {"all"};
  artwork.strokes.push_back({{{0, 0}, {10, 0}, {10, 20}, {0, 20}, {0, 0}}, true});
  artwork.page.extend(Eigen::Vector2d(0, 0));
  artwork.page.extend(Eigen::Vector2d(10, 20));
  artwork.areas.push_back({{artwork.strokes[0].points}});
  return artwork;
}

PointCloud made_cloud() {
  PointCloud cloud;
  for (int i = 0; i < 30; ++i)
    for (int j = 0; j < 30; ++j) cloud.points.emplace_back(0.6 + 1e-3 * i, 1e-3 * j, 0.1);
  cloud.camera.assign(cloud.points.size(), 0);
  cloud.eyes = {{0.6, 0.0, 0.9}};
  return cloud;
}

void check_drawing(const DrawingSettings& s) {
  const Artwork artwork = made_artwork();
  PlacementSettings placement = s.placement;
  place(artwork, placement);
  if (!s.text.text.empty()) make_text(s.text);
  TextSettings text = s.text;
  text.text = "A";
  make_text(text);
  hatch_lines(artwork.areas[0], s.hatch, 1.0);
  validate(s.wrap);
}

void check_perception(const PerceptionSettings& s) {
  DepthCamera camera;
  for (const CameraSettings& c : s.cameras) {
    camera = {c.width, c.height, c.fov_y_deg, look_at(c.p_WC, c.target_W)};
    validate(camera);
  }
  camera = {1, 1, 60.0, camera.X_WC};
  const auto nothing = [](const Eigen::Vector3d&, const Eigen::Vector3d&) { return 1.0; };
  const DepthImage image = render_depth(camera, nothing, s.noise);
  CloudSettings cloud;
  cloud.voxel = s.voxel;
  cloud.self_padding = s.self_padding;
  cloud.region = {s.region_lower, s.region_upper};
  fuse({image}, {camera}, cloud);
  SurfaceEstimator(made_cloud(), s.normals);
}

void check_control(const Scenario& s) {
  const ControlSettings& c = s.control;
  ImpedanceSettings settings = c;
  settings.friction.normal_error_deg = c.normal_error_deg.value_or(0.0);
  settings.felt_normal = {c.felt_normal.share.value_or(0.0), c.felt_normal.deviation,
                          c.felt_normal.force_error};
  settings.limits.torque = Eigen::VectorXd::Constant(7, 100.0 * c.torque_share);
  settings.limits.torque_rate = Eigen::VectorXd::Constant(7, c.torque_rate);
  if (!c.null_stiffness.empty())
    settings.null_space.stiffness = Eigen::VectorXd::Constant(7, c.null_stiffness[0]);
  if (!settings.observer.yield_limit.empty())
    settings.observer.yield_limit.assign(7, settings.observer.yield_limit[0]);
  settings.validate_ranges(7);  // stability depends on several settings together
  ContactStates(settings.contact, s.world.dt);
  const WrenchEstimatorSettings estimator =
      estimator_settings(c.sensing, s.wrench_sensor, s.world.dt, s.world.gravity);
  MomentumObserver(settings.observer, 7, s.world.dt, estimator.sensor_delay,
                   c.torque_delay.value_or(0.0));
  WrenchSensor(s.wrench_sensor, s.world.dt, 1);
  WrenchEstimator{estimator};
  JointStateEstimator({s.world.dt, c.joint_sensing.bandwidth,
                       c.joint_sensing.sensor_delay.value_or(0.0), c.torque_delay.value_or(0.0)},
                      7);
}

// All that the library has to say about the part of the scenario that `name` lies in. What nothing
// checks by itself (arm.start, pen, pushes, faults) only goes into a calculation.
void check_by_library(const std::string& name, const Scenario& s) {
  const std::string group = name.substr(0, name.find('.'));
  if (group == "drawing") check_drawing(s.drawing);
  if (group == "canvas") make_mesh(s.canvas);
  if (group == "perception") check_perception(s.perception);
  if (group == "path") validate(s.path);
  if (group == "blind") TouchSurface(s.blind.touch, {});
  if (group == "preflight") validate(s.preflight);
  if (group == "control" || group == "wrench_sensor") check_control(s);
  if (group == "world") {
    World(kRoot / "tests/data/slider.urdf", nullptr, s.world);
    JointSensor(s.world.joint_sensor, 3, s.world.dt, 1);
  }
}

std::string error_of(const std::function<void()>& f) {
  try {
    f();
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST(Limits, LibraryTakesWhatTheSchemaAllows) {
  int bounds = 0;
  for (const Bounded& b : all_bounded()) {
    const double step = b.whole ? 1.0 : 1e-9;
    for (const auto& [end, bound, open, inward] :
         {std::tuple{"lowest", b.range.lowest, b.range.above, 1.0},
          std::tuple{"highest", b.range.highest, b.range.below, -1.0}}) {
      if (!std::isfinite(bound)) continue;
      ++bounds;
      const double nudge = inward * step * std::max(1.0, b.whole ? 1.0 : std::abs(bound));
      SCOPED_TRACE(fmt::format("{} {} {}", b.name, end, bound));
      EXPECT_EQ(error_of([&, e = end, at = open ? bound + nudge : bound] {
                  check_by_library(b.name, with(b, e, at));
                }),
                "");
      EXPECT_THAT(error_of([&, e = end, at = open ? bound : bound - nudge] { with(b, e, at); }),
                  testing::HasSubstr("allowed is"));
    }
  }
  EXPECT_GT(bounds, 300) << "the description was walked in part only";
}

// What used to be documented and then refused, or refused under another name.
TEST(Limits, LibraryRefusesWhatTheSchemaRefuses) {
  const auto path = [](auto change) {
    return error_of([&] {
      PathSettings s;
      change(s);
      validate(s);
    });
  };
  const auto preflight = [](auto change) {
    return error_of([&] {
      PreflightSettings s;
      change(s);
      validate(s);
    });
  };
  const auto control = [](auto change) {
    return error_of([&] {
      ImpedanceSettings s;
      change(s);
      s.validate_ranges(7);
    });
  };
  const auto world = [](auto change) {
    return error_of([&] {
      WorldSettings s;
      change(s);
      World(kRoot / "tests/data/slider.urdf", nullptr, s);
    });
  };
  const auto sensor = [](auto change) {
    return error_of([&] {
      WrenchSensorSettings s;
      change(s);
      WrenchSensor(s, 1e-3, 1);
    });
  };
  const auto schema = [](const std::string& assignment) {
    return error_of([&] {
      Scenario s;
      read_settings(s, "", {assignment});
    });
  };
  for (const auto& [name, refusal, value] :
       {std::tuple{"path.safe_height", path([](auto& s) { s.safe_height = 0; }), "0"},
        std::tuple{"preflight.roughest", preflight([](auto& s) { s.roughest = 0.02; }), "0.02"},
        std::tuple{"control.stiffness_normal",
                   control([](auto& s) { s.stiffness.linear.normal = -1; }), "-1"},
        std::tuple{"control.approach_speed", control([](auto& s) { s.approach.speed = 0; }), "0"},
        std::tuple{"control.observer.bandwidth",
                   control([](auto& s) { s.observer.bandwidth = 1000; }), "1000"},
        std::tuple{"control.damping_ratio", control([](auto& s) { s.damping_ratio = 0; }), "0"},
        std::tuple{"world.gravity", world([](auto& s) { s.gravity = -1; }), "-1"},
        std::tuple{"world.tip.friction", world([](auto& s) { s.tip.friction = 4; }), "4"},
        std::tuple{"world.errors.mass_scale", world([](auto& s) { s.errors.mass_scale = 0; }), "0"},
        std::tuple{"wrench_sensor.delay", sensor([](auto& s) { s.delay = 0.04; }), "0.04"}}) {
    const std::string assignment = std::string(name) + "=" + value;
    EXPECT_THAT(refusal, testing::StartsWith(std::string(name) + " is " + value));
    EXPECT_EQ(schema(assignment), "--set " + assignment + ": " + refusal);
  }
}

TEST(Migration, PageListsWhatWasRenamed) {
  Scenario scenario;
  Words renamed, listed;
  for (const RenamedSetting& r : renamed_settings(described(scenario)))
    renamed.push_back(fmt::format("| `{}` | `{}` |", r.former, r.now));
  std::ifstream page(kRoot / "docs/migration.md");
  for (std::string line; std::getline(page, line);)
    if (std::regex_match(line, std::regex("\\| `[^`]*` \\| `[^`]*` \\|"))) listed.push_back(line);
  EXPECT_THAT(listed, testing::UnorderedElementsAreArray(renamed));
}

TEST(Migration, ScenariosNameTheSchemaAndUseTheNewNames) {
  int files = 0;
  for (const auto& entry : fs::directory_iterator(kRoot / "scenarios")) {
    if (entry.path().extension() != ".yaml") continue;
    SCOPED_TRACE(entry.path());
    std::ifstream file(entry.path());
    std::string first;
    std::getline(file, first);
    EXPECT_EQ(first, "# yaml-language-server: $schema=../docs/scenario.schema.json");
    Scenario scenario;
    EXPECT_TRUE(read_settings(scenario, entry.path()).notes().empty());
    ++files;
  }
  EXPECT_GT(files, 30);
}

// A run's scenario.yaml from before the renamings is the same scenario.
TEST(Migration, FormerNamesGiveTheSameScenario) {
  Scenario former, now;
  read_settings(
      former, "",
      {"control.push=3", "control.wrench=true", "faults=[{kind: no_cloud, middle: 0.2}]"});
  read_settings(now, "",
                {"control.normal_force=3", "control.wrench=ground_truth",
                 "faults=[{kind: no_cloud, start: 0.2}]"});
  EXPECT_EQ(settings_yaml(former), settings_yaml(now));
  EXPECT_EQ(former.control.normal_force, 3);
}

// A number for all joints, as before rotors had one each, and a list.
TEST(Rotors, AreGivenAsANumberOrAsAList) {
  for (const char* name : {"arm.rotor_inertia", "world.errors.rotor_inertia"}) {
    for (const auto& [text, rotors] : {std::pair<const char*, std::vector<double>>{"0.1", {0.1}},
                                       {"[0.1, 0.2]", {0.1, 0.2}},
                                       {"[]", {}}}) {
      Scenario s, again;
      read_settings(s, "", {std::string(name) + "=" + text});
      EXPECT_EQ(name[0] == 'a' ? s.arm.rotor_inertia : s.world.errors.rotor_inertia, rotors);
      std::istringstream lines(settings_yaml(s));
      Places places;
      read_yaml_text(lines.str(), "again", ".", described(again), places);
      EXPECT_EQ(settings_yaml(again), settings_yaml(s));
    }
    Scenario s;
    EXPECT_THROW(read_settings(s, "", {std::string(name) + "=-0.1"}), InputError);
    EXPECT_THROW(read_settings(s, "", {std::string(name) + "=many"}), InputError);
  }
}

}  // namespace
}  // namespace impedraw
