#include "impedraw/study/robustness_cells.h"

#include <cmath>
#include <numbers>
#include <utility>

#include <fmt/format.h>

namespace impedraw {

namespace {

constexpr const char* kSine = "scenarios/bowl-sine.yaml";
constexpr const char* kSensor = "scenarios/bowl-sine-sensor.yaml";
constexpr const char* kRealistic = "scenarios/bowl-sine-realistic.yaml";
constexpr const char* kReal = "scenarios/bowl-sine-real.yaml";
constexpr const char* kNoisyVelocity = "scenarios/bowl-sine-velocity-noise.yaml";

const char* state(bool realistic) { return realistic ? "realistic" : "nominal"; }

void add_matrix(std::vector<Cell>& cells) {
  for (const bool realistic : {false, true})
    for (const int push : {1, 5, 20})
      for (const int speed : {10, 50, 100, 200})
        for (const int slope : {0, 15, 30, 45, 60}) {
          Cell cell;
          cell.name =
              fmt::format("matrix-{}-{}mm_s-{}deg-{}N", state(realistic), speed, slope, push);
          cell.group = "matrix";
          cell.base = fmt::format("scenarios/robustness-{}.yaml", state(realistic));
          // Sideways, where the arm reaches every slope; towards or away from its foot the wrist
          // ends before 60°.
          const double angle = slope * std::numbers::pi / 180.0;
          cell.assignments = {fmt::format("path.draw_speed={}", speed / 1000.0),
                              fmt::format("control.normal_force={}", push),
                              fmt::format("canvas.plane.normal=[0, {:.9f}, {:.9f}]",
                                          std::sin(angle), std::cos(angle))};
          cell.table = fmt::format("Speed, slope and normal force: {}", state(realistic));
          cell.row = fmt::format("{} N, {} mm/s", push, speed);
          cell.column = fmt::format("{}°", slope);
          cell.realistic = realistic;
          cells.push_back(cell);
        }
}

struct ModelError {
  const char* base;
  const char* setting;
  std::vector<double> values;
  const char* with = "";  // another, in each
};

const char* const kErrorColumns[] = {"first value", "second", "third"};

void add_errors(const std::vector<ModelError>& errors, const std::string& group,
                const std::string& table, bool realistic, std::vector<Cell>& cells) {
  for (const ModelError& error : errors) {
    const std::string setting = error.setting;
    for (std::size_t i = 0; i < error.values.size(); ++i) {
      const std::string value = fmt::format("{}", error.values[i]);
      const std::string name =
          setting.starts_with("world.") ? setting.substr(setting.rfind('.') + 1) : setting;
      const std::string tip = setting.starts_with("world.tip.")            ? "tip_"
                              : setting.starts_with("world.joint_sensor.") ? "joint_sensor_"
                                                                           : "";
      Cell cell{fmt::format("{}-{}{}-{}", group, tip, name, value),
                group,
                error.base,
                {setting + "=" + value},
                table,
                fmt::format("`{}`", setting),
                kErrorColumns[i],
                value,
                realistic};
      if (*error.with) {
        cell.assignments.emplace_back(error.with);
        cell.row += fmt::format(", `{}`", error.with);
        cell.name += "-untold";
      }
      cells.push_back(cell);
    }
  }
}

void add_errors(std::vector<Cell>& cells) {
  const std::string table = "Each model error alone";
  cells.push_back({"error-none", "error", kSine, {}, table, "none", kErrorColumns[0], "", false});
  cells.push_back({"error-none-sensor",
                   "error",
                   kSensor,
                   {},
                   table,
                   "none, wrench from a sensor",
                   kErrorColumns[0],
                   "",
                   false});
  add_errors({{kSine, "world.errors.mass_scale", {0.8, 1.1, 1.2}},
              {kSine, "world.errors.centre_shift", {-0.01, 0.005, 0.01}},
              {kSine, "world.joint_friction", {0.5, 1.0, 1.5}},
              {kSine, "world.errors.viscous_friction", {0.5, 2.0, 5.0}},
              {kSine, "world.errors.rotor_inertia", {0.02, 0.1, 0.3}},
              {kSine, "world.errors.torque_ripple", {0.1, 0.3, 1.0}},
              {kSine, "world.errors.torque_quantum", {0.05, 0.2, 0.5}},
              {kSine, "world.errors.loop_delay", {0.001, 0.002, 0.003}},
              {kSine, "world.errors.pen_longer", {0.0005, 0.001, 0.002}},
              {kSine, "world.tip.friction", {0.1, 0.45, 0.6}},
              {kSine, "world.tip.stiffness", {1e3, 1e5, 1e6}},
              {kSine, "perception.noise.sigma_at_1m", {0.0005, 0.001, 0.003}},
              {kSensor, "wrench_sensor.noise_force", {0.05, 0.2, 0.5}},
              {kSensor, "wrench_sensor.drift_force", {1.0, 5.0, 20.0}},
              {kSensor, "wrench_sensor.delay", {0.001, 0.002, 0.004}}},
             "error", table, false, cells);
}

// What the controller cannot know, or is not told, under the tuning for real arms. The scenario's
// other errors stay as they are.
void add_tuned_errors(std::vector<Cell>& cells) {
  const std::string table = "Each error under the tuning of bowl-sine-real";
  cells.push_back(
      {"tuned-as-it-is", "tuned", kReal, {}, table, "as it is", kErrorColumns[0], "", true});
  add_errors(
      {{kReal, "perception.errors.shift", {0.0005, 0.002, 0.004}},
       {kReal, "perception.errors.turn", {0.1, 0.4, 0.8}},
       {kReal, "perception.errors.depth_scale", {0.001, 0.003, 0.01}},
       {kReal, "world.errors.pen_longer", {0.0002, 0.001, 0.002}},
       {kReal, "world.tip.stiffness", {5e3, 1e4, 4e4}},
       {kReal, "world.tip.friction", {0.2, 0.5, 0.6}},
       {kReal, "world.errors.loop_delay", {0.002, 0.003, 0.004}},
       {kReal, "world.joint_sensor.quantum", {3e-6, 3e-5, 1e-4}},
       {kReal, "world.joint_sensor.position_noise", {3e-6, 1e-5, 3e-5}},
       {kReal,
        "world.joint_sensor.delay",
        {0.001, 0.002, 0.004},
        "control.joint_sensing.sensor_delay=0"},
       {kSensor, "wrench_sensor.delay", {0.001, 0.002, 0.003}, "control.sensing.sensor_delay=0"},
       {kNoisyVelocity, "world.joint_sensor.velocity_noise", {1e-3, 5e-3, 2e-2}}},
      "tuned", table, true, cells);
}

void add_canvases(std::vector<Cell>& cells) {
  const std::string circle = "drawing.shape=circle";
  const auto cap = [](const char* kind, double radius,
                      double centre_z) -> std::vector<std::string> {
    return {fmt::format("canvas.kind={}", kind), fmt::format("canvas.cap.radius={}", radius),
            fmt::format("canvas.cap.centre=[0.6, 0, {}]", centre_z)};
  };
  const std::pair<const char*, std::vector<std::string>> canvases[] = {
      {"bowl of 0.20 m", cap("bowl", 0.20, 0.30)},
      {"bowl of 0.30 m", {}},
      {"bowl of 0.45 m", cap("bowl", 0.45, 0.55)},
      {"dome of 0.20 m", cap("dome", 0.20, 0.05)},
      {"dome of 0.30 m", cap("dome", 0.30, -0.10)},
      {"dome of 0.45 m", cap("dome", 0.45, -0.25)},
      // A circle beside the top, from 2° of slope to 60°.
      {"sphere outside to 60 deg",
       {"canvas.kind=dome", "canvas.cap.radius=0.145", "canvas.cap.centre=[0.6, 0, 0.155]",
        "canvas.cap.opening_radius=0.144", circle, "drawing.placement.centre=[0.6, 0.065]"}},
      {"plane at 30 deg",
       {"canvas.kind=plane", "canvas.plane.centre=[0.6, 0, 0.2]",
        "canvas.plane.normal=[0, 0.5, 0.866025404]", "canvas.plane.height=0.44"}},
      {"wave", {"canvas.kind=wave", "canvas.wave.heading=90"}},
      {"wave, twice as high",
       {"canvas.kind=wave", "canvas.wave.heading=90", "canvas.wave.amplitude=0.03"}},
      {"saddle", {"canvas.kind=saddle"}},
      {"cylinder of 0.30 m", {"canvas.kind=cylinder", "canvas.cylinder.middle=[0.6, 0, 0.2]"}},
      {"trough of 0.30 m", {"canvas.kind=trough"}},
      {"trough of 0.12 m",
       {"canvas.kind=trough", "canvas.cylinder.radius=0.12", "canvas.cylinder.width=0.19",
        "drawing.placement.scale=0.48"}},
      {"cone, around it", {"canvas.kind=cone", circle}},
      {"cone, over its apex", {"canvas.kind=cone"}},
      {"terrain", {"canvas.kind=terrain"}},
  };
  for (const auto& [label, assignments] : canvases)
    for (const bool realistic : {false, true}) {
      std::string name;
      for (const char* c = label; *c; ++c)
        if (*c != ',') name += *c == ' ' ? '_' : *c;
      Cell cell{fmt::format("canvas-{}-{}", name, state(realistic)),
                "canvas",
                realistic ? kRealistic : kSine,
                assignments,
                "Canvases, at 50 mm/s and 5 N",
                label,
                state(realistic),
                "",
                realistic};
      cell.assignments.insert(cell.assignments.end(),
                              {"path.draw_speed=0.05", "control.normal_force=5"});
      cells.push_back(cell);
    }
}

void add_switches(std::vector<Cell>& cells) {
  struct Switch {
    const char *name, *off, *on;
    std::vector<const char*> under;  // a setting on the standard sine; empty: nothing is wrong
    const char* with = "";           // another, in both
  };
  const Switch switches[] = {
      {"observer",
       "control.observer.enabled=false",
       "control.observer.enabled=true",
       {"realistic", "world.errors.mass_scale=1.2", "world.errors.centre_shift=0.01",
        "world.joint_friction=1", "world.errors.viscous_friction=5"}},
      {"tip friction rejected",
       "control.friction=0",
       "control.friction=0.3",
       {"", "realistic", "world.tip.friction=0.45"}},
      {"force integral",
       "control.force_integral.enabled=false",
       "control.force_integral.enabled=true",
       {"realistic"}},
      {"force integral, observer off",
       "control.force_integral.enabled=false",
       "control.force_integral.enabled=true",
       {"world.errors.mass_scale=1.02", "world.errors.centre_shift=0.003",
        "world.joint_friction=0.2"},
       "control.observer.enabled=false"}};
  for (const Switch& s : switches)
    for (const std::string under : s.under)
      for (const bool on : {false, true}) {
        const bool realistic = under == "realistic", none = under.empty();
        std::string short_name = under.substr(under.rfind('.') == std::string::npos ||
                                                      under.find('=') == std::string::npos
                                                  ? 0
                                                  : under.rfind('.', under.find('=')) + 1);
        if (none) short_name = "nominal";
        std::string name = fmt::format("switch-{}-{}-{}", s.name, short_name, on ? "on" : "off");
        std::erase(name, ',');
        for (char& c : name)
          if (c == ' ') c = '_';
        Cell cell{name,
                  "switch",
                  realistic ? kRealistic : kSine,
                  {},
                  "Effect of each switch",
                  fmt::format("{}: {}", s.name, short_name),
                  on ? "on" : "off",
                  "",
                  realistic};
        if (!realistic && !none) cell.assignments.push_back(under);
        if (*s.with) cell.assignments.push_back(s.with);
        cell.assignments.push_back(on ? s.on : s.off);
        cells.push_back(cell);
      }
}

}  // namespace

std::vector<Cell> robustness_cells() {
  std::vector<Cell> cells;
  add_matrix(cells);
  add_errors(cells);
  add_tuned_errors(cells);
  add_canvases(cells);
  add_switches(cells);
  // What the law does at once is judged, and also where the pre-flight would have refused it.
  for (Cell& cell : cells)
    cell.assignments.insert(cell.assignments.end(),
                            {"drawing.redraw=false", "preflight.arm=false"});
  return cells;
}

}  // namespace impedraw
