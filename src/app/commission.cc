#include "impedraw/app/commands.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <numbers>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include "impedraw/common/errors.h"
#include "impedraw/common/exit_code.h"
#include "impedraw/experiment/input_files.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/run/identify_joints.h"
#include "impedraw/run/real_time.h"
#include "impedraw/run/simulated_arm.h"
#include "impedraw/sensing/touches.h"
#include "impedraw/terminal/say.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kAtRest = 0.01;      // joint speed while a touch is noted [rad/s]
constexpr double kTouchTime = 0.5;    // over which its posture is averaged [s]
constexpr double kLeastRotor = 0.01;  // that is told from none [kg m²]
constexpr double kPenOff = 5e-4;      // of the tip that is commissioned from the URDF's [m]

fs::path file_in(const fs::path& folder) { return folder / "commissioning.json"; }

Json read_file(const fs::path& folder) {
  std::ifstream in(file_in(folder));
  if (!in) return Json::object();
  Json json = Json::parse(in, nullptr, false);
  if (!json.is_object())
    throw InputError(fmt::format("{}: is not what ./impedraw arm latency writes; move it away",
                                 file_in(folder).string()));
  return json;
}

// Throws unless the step before has left its result.
// `given`: the option that names the folder, in front of the message.
void require_step(const Json& json, const fs::path& folder, const char* before,
                  const std::string& given = {}) {
  if (json.contains(before)) return;
  const std::string file = file_in(folder).string();
  throw InputError(fmt::format(
      "{} has no '{}'; run ./impedraw arm {} --into {} first",
      given.empty() ? file + ":" : fmt::format("{} {}: {}", given, folder.string(), file), before,
      before, folder.string()));
}

void write_step(const fs::path& folder, Json json, const char* step, Json result) {
  fs::create_directories(folder);
  json[step] = std::move(result);
  write_whole(file_in(folder), json.dump(2) + "\n");
}

// Rotors are what commissioning finds: that they are unknown does not keep it from beginning. Nor
// does a canvas that nobody has seen yet, since nothing is drawn.
DrawOptions unchecked(DrawOptions options) {
  options.assignments.push_back("control.check_rotors=false");
  options.assignments.push_back("canvas.true_model=true");
  return options;
}

// The arm of the options: the simulated one over its canvas, or another.
struct CommissionedArm {
  Prepared experiment;
  std::unique_ptr<Driver> driver;

  explicit CommissionedArm(DrawOptions options)
      : experiment(prepare(resolve(unchecked(std::move(options))))) {
    const DriverMaker make = driver_maker(experiment);
    if (make)
      driver = make(experiment.belief.start_q, nullptr);
    else
      driver =
          std::make_unique<SimulatedArm>(experiment, experiment.belief.start_q, Disturbances());
  }
};

// The rotor that the model should have: as it has, where what was found is nothing to speak of.
double rotor_with(double modelled, const JointFriction& found) {
  const double least = std::max(kLeastRotor, 2.0 * found.inertia_error);
  if (std::abs(found.inertia) < least) return modelled;
  return std::max(0.0, modelled + found.inertia);
}

std::vector<double> numbers(const JointVector& x) { return {x.begin(), x.end()}; }

// Tells arms, and pens, from each other: names of the joints, and the tip with all of them at 0.
Json identity_of(ArmModel model) {
  const Pose X_WE = model.tip_pose(JointVector::Zero(model.joints()));
  const Eigen::Vector3d z = X_WE.R.col(2);
  return {{"joints", model.joint_names()},
          {"p_WE_at_zero_m", {X_WE.p.x(), X_WE.p.y(), X_WE.p.z()}},
          {"pen_axis_at_zero", {z.x(), z.y(), z.z()}}};
}

}  // namespace

int commission_latency(const DrawOptions& options, const fs::path& folder) {
  Json json = read_file(folder);
  CommissionedArm arm(options);
  const RealTime real_time(!arm.driver->info().waits && arm.experiment.scenario.arm.real_time);
  const LoopDelay found = identify_delay(arm.experiment.belief.arm, *arm.driver);
  json["arm"] = identity_of(arm.experiment.belief.arm);
  write_step(folder, std::move(json), "latency",
             {{"delay_s", found.delay}, {"explained", found.explained}});
  say(stdout,
      "delay     {:.4f} s from a state to its torque; explains {:.1f} % of the last joint's "
      "acceleration\n\nAs a setting of a scenario:\n{}: {:.4f}\n",
      found.delay, 1e2 * found.explained,
      arm.experiment.scenario.arm.driver == ArmDriver::sim ? "control.torque_delay" : "arm.delay",
      found.delay);
  return kFinished;
}

int commission_camera_latency(const DrawOptions& options, const fs::path& folder, double seconds) {
  Json json = read_file(folder);
  CommissionedArm arm(options);
  const Scenario& scenario = arm.experiment.scenario;
  const PerceptionSettings& perception = scenario.perception;
  if (!perception.frames.enabled)
    throw InputError(
        "perception.frames.enabled is false: no camera keeps capturing; name a scenario as "
        "scenarios/moving-sway.yaml");
  if (perception.fiducials.points.size() < 3)
    throw InputError(fmt::format(
        "perception.fiducials.points has {} points; the cameras' latency is found by 3 and more",
        perception.fiducials.points.size()));
  const CanvasMotion& motion = arm.experiment.truth.world->canvas_motion();
  if (!motion.moves())
    throw InputError(
        "canvas.motion: the canvas stands; a known motion tells the cameras' latency, as "
        "canvas.motion.sway or canvas.motion.file");
  const Eigen::Vector3d centre = centre_of(perception.fiducials);
  const CameraLatency found = find_camera_latency(
      watch_marks(arm.experiment.belief.arm, *arm.driver, perception.fiducials, seconds),
      [&](double time) { return motion.at(time).X_WK * centre; });
  write_step(folder, std::move(json), "camera-latency",
             {{"stamp_error_s", found.stamp_error},
              {"stamp_error_deviation_s", found.stamp_error_deviation},
              {"latency_s", found.latency},
              {"latency_deviation_s", found.latency_deviation},
              {"jitter_s", found.jitter}});
  say(stdout,
      "frames    {} with three marks and more, {:.2f} mm of noise per axis\n"
      "stamps    {:.2f} ± {:.2f} ms later than the exposures\n"
      "latency   {:.2f} ± {:.2f} ms from an exposure to its frame, one frame varies by {:.2f} ms\n"
      "\nAs a setting of a scenario:\nperception.frames.stamp_error: {:.5f}\n",
      found.frames, 1e3 * found.noise, 1e3 * found.stamp_error, 1e3 * found.stamp_error_deviation,
      1e3 * found.latency, 1e3 * found.latency_deviation, 1e3 * found.jitter, found.stamp_error);
  return kFinished;
}

int commission_friction(const DrawOptions& options, const fs::path& folder) {
  Json json = read_file(folder);
  require_step(json, folder, "latency");
  CommissionedArm arm(options);
  const RealTime real_time(!arm.driver->info().waits && arm.experiment.scenario.arm.real_time);
  const std::vector<JointFriction> found = identify_friction(
      arm.experiment.belief.arm, *arm.driver, json["latency"].at("delay_s").get<double>());
  const ArmModel& model = arm.experiment.belief.arm;
  Json joints = Json::array();
  say(stdout,
      "joint      friction [Nm]  viscous [Nm s/rad]  residual [Nm]  inertia lacking [kg m²]\n");
  for (std::size_t j = 0; j < found.size(); ++j) {
    const std::string& name = model.joint_names()[j];
    joints.push_back({{"joint", name},
                      {"coulomb_Nm", found[j].coulomb},
                      {"viscous_Nms", found[j].viscous},
                      {"residual_Nm", found[j].residual},
                      {"inertia_lacking_kgm2", found[j].inertia},
                      {"inertia_error_kgm2", found[j].inertia_error},
                      {"rotor_inertia_kgm2", rotor_with(model.rotor_inertia()[j], found[j])}});
    say(stdout, "{:10} {:13.3f}  {:18.3f}  {:13.3f}  {:14.3f} ± {:.3f}\n", name, found[j].coulomb,
        found[j].viscous, found[j].residual, found[j].inertia, found[j].inertia_error);
  }
  write_step(folder, std::move(json), "friction", std::move(joints));
  return kFinished;
}

int commission_touch(const DrawOptions& options, const fs::path& folder, const std::string& mark) {
  Json json = read_file(folder);
  require_step(json, folder, "friction");
  double x = 0.0, y = 0.0, z = 0.0;
  char more = 0;
  const bool pen = mark == "pen";
  if (!pen && std::sscanf(mark.c_str(), "%lf,%lf%c", &x, &y, &more) != 2 &&
      std::sscanf(mark.c_str(), "%lf,%lf,%lf%c", &x, &y, &z, &more) != 3)
    throw InputError(fmt::format(
        "--mark: '{}' is no mark; valid are pen, and X,Y or X,Y,Z of a mark in m", mark));
  if (!pen) require_step(json, folder, "pen-length");
  const auto [q, model] = posture_at_rest(options, kTouchTime, kAtRest);
  const Pose X_WE = model->tip_pose(q);
  Json touch = {{"q", numbers(q)},
                {"p_WE", {X_WE.p.x(), X_WE.p.y(), X_WE.p.z()}},
                {"R_WE", std::vector<double>(X_WE.R.data(), X_WE.R.data() + 9)}};
  if (!pen) touch["mark"] = {x, y, z};
  Json touches = json.value(pen ? "pen touches" : "page touches", Json::array());
  touches.push_back(std::move(touch));
  const std::size_t count = touches.size();
  write_step(folder, std::move(json), pen ? "pen touches" : "page touches", std::move(touches));
  say(stdout, "touch {}: the tip of the model is at ({:.4f}, {:.4f}, {:.4f}) m\n", count,
      X_WE.p.x(), X_WE.p.y(), X_WE.p.z());
  return kFinished;
}

namespace {

Pose pose_of(const Json& touch) {
  Pose X;
  for (Eigen::Index i = 0; i < 3; ++i)
    X.p[i] = touch.at("p_WE").at(static_cast<std::size_t>(i)).get<double>();
  for (Eigen::Index i = 0; i < 9; ++i)
    X.R.data()[i] = touch.at("R_WE").at(static_cast<std::size_t>(i)).get<double>();
  return X;
}

std::string touch_first(const fs::path& folder, const char* mark) {
  return fmt::format("{}: no such touches; ./impedraw arm touch --mark {} --into {} notes them",
                     file_in(folder).string(), mark, folder.string());
}

}  // namespace

int commission_pen_length(const fs::path& folder) {
  Json json = read_file(folder);
  if (!json.contains("pen touches")) throw InputError(touch_first(folder, "pen"));
  std::vector<Pose> touches;
  for (const Json& touch : json["pen touches"]) touches.push_back(pose_of(touch));
  const PenLength found = identify_pen_length(touches);
  write_step(
      folder, std::move(json), "pen-length",
      {{"longer_m", found.longer}, {"error_m", found.error}, {"residual_m", found.residual}});
  say(stdout,
      "pen       {:.2f} ± {:.2f} mm longer than modelled, from {} touches of one point (residual "
      "{:.2f} mm)\n          give it to ./impedraw arm make-urdf --tool-length, or to the URDF's "
      "tip frame\n",
      1e3 * found.longer, 1e3 * found.error, touches.size(), 1e3 * found.residual);
  return kFinished;
}

int commission_register(const fs::path& folder) {
  Json json = read_file(folder);
  require_step(json, folder, "pen-length");
  if (!json.contains("page touches")) throw InputError(touch_first(folder, "X,Y"));
  const double longer = json["pen-length"].at("longer_m").get<double>();
  std::vector<Eigen::Vector3d> p_P, p_W;
  for (const Json& touch : json["page touches"]) {
    const Pose X = pose_of(touch);
    const auto mark = touch.at("mark").get<std::array<double, 3>>();
    p_P.emplace_back(mark[0], mark[1], mark[2]);
    p_W.push_back(X.p + longer * X.R.col(2));
  }
  const Registration found = register_page(p_P, p_W);
  const Eigen::Matrix3d& R = found.X_WP.R;
  const double degree = 180.0 / std::numbers::pi;
  const double roll = degree * std::atan2(R(2, 1), R(2, 2)),
               pitch = degree * std::atan2(-R(2, 0), std::hypot(R(2, 1), R(2, 2))),
               yaw = degree * std::atan2(R(1, 0), R(0, 0));
  const Eigen::Vector3d& p = found.X_WP.p;
  write_step(folder, std::move(json), "register",
             {{"p_WP_m", {p.x(), p.y(), p.z()}},
              {"roll_pitch_yaw_deg", {roll, pitch, yaw}},
              {"residual_m", found.residual}});
  say(stdout,
      "page      its origin is at ({:.4f}, {:.4f}, {:.4f}) m, roll, pitch, yaw ({:.2f}, {:.2f}, "
      "{:.2f}) degrees; residual {:.2f} mm over {} marks\n",
      p.x(), p.y(), p.z(), roll, pitch, yaw, 1e3 * found.residual, p_P.size());
  return kFinished;
}

DrawOptions with_commissioning(DrawOptions options, const fs::path& folder) try {
  if (folder.empty()) return options;
  const std::string file = file_in(folder).string();
  const Json json = read_file(folder);
  require_step(json, folder, "latency", "--commissioned");
  const Scenario scenario = resolve(options);
  ArmModel model = model_of(scenario.arm);
  const auto& arm = json.at("arm");
  if (arm.at("joints") != Json(model.joint_names()))
    throw InputError(fmt::format("--commissioned {}: is of another arm, with the joints {}", file,
                                 arm.at("joints").dump()));
  const auto vector = [](const Json& x) {
    const auto v = x.get<std::array<double, 3>>();
    return Eigen::Vector3d(v[0], v[1], v[2]);
  };
  // The tip may have moved since, by what the pen was found to be longer.
  const double longer =
      json.contains("pen-length") ? json["pen-length"].at("longer_m").get<double>() : 0.0;
  const Eigen::Vector3d p = vector(arm.at("p_WE_at_zero_m")),
                        true_p = p + longer * vector(arm.at("pen_axis_at_zero"));
  const double off = (model.tip_pose(JointVector::Zero(model.joints())).p - true_p).norm();
  if (off > kPenOff)
    throw InputError(fmt::format(
        "--commissioned {}: the pen's tip is {:.1f} mm from where the URDF has it{}", file,
        1e3 * off,
        longer != 0.0 ? fmt::format("; it was found {:.1f} mm longer than it was then: make the "
                                    "URDF with it, ./impedraw arm make-urdf --tool-length",
                                    1e3 * longer)
                      : "; valid is the URDF that was commissioned"));

  std::vector<std::string> found;
  found.push_back(fmt::format(
      "{}={}", scenario.arm.driver == ArmDriver::sim ? "control.torque_delay" : "arm.delay",
      json["latency"].at("delay_s").get<double>()));
  if (json.contains("friction") && json["friction"].front().contains("rotor_inertia_kgm2")) {
    std::vector<double> rotors;
    double change = 0.0, error = 0.0;
    for (const Json& joint : json["friction"]) {
      rotors.push_back(joint.at("rotor_inertia_kgm2").get<double>());
      const double has = model.rotor_inertia()[static_cast<Eigen::Index>(rotors.size()) - 1];
      change = std::max(change, std::abs(rotors.back() - has));
      error = std::max(error, joint.at("inertia_error_kgm2").get<double>());
    }
    if (change > 0.0) {
      found.push_back(fmt::format("arm.rotor_inertia=[{:.4g}]", fmt::join(rotors, ", ")));
      say(stderr, "commissioned  rotors to ± {:.2g} kg m²\n", error);
    }
  }
  if (json.contains("register") && scenario.canvas.kind == CanvasKind::mesh) {
    const Json& page = json["register"];
    const auto list = [](const Json& x) {
      const auto v = x.get<std::array<double, 3>>();
      return fmt::format("[{}, {}, {}]", v[0], v[1], v[2]);
    };
    found.push_back("canvas.mesh.position=" + list(page.at("p_WP_m")));
    found.push_back("canvas.mesh.rotation=" + list(page.at("roll_pitch_yaw_deg")));
  }
  if (json.contains("camera-latency") && scenario.perception.frames.enabled)
    found.push_back(fmt::format("perception.frames.stamp_error={}",
                                json["camera-latency"].at("stamp_error_s").get<double>()));
  for (const std::string& assignment : found) say(stderr, "commissioned  {}\n", assignment);
  options.assignments.insert(options.assignments.begin(), found.begin(), found.end());
  return options;
} catch (const Json::exception& error) {
  throw InputError(
      fmt::format("--commissioned {}: is damaged: {}", file_in(folder).string(), error.what()));
}

}  // namespace impedraw
