#include <CLI/CLI.hpp>

#include "impedraw/app/command_options.h"

namespace impedraw {
namespace {

void add_check_and_hold(CLI::App* arm, Call& call) {
  CLI::App* arm_check = arm->add_subcommand(
      "check", "connect and receive: rate, jitter and posture; sends nothing, moves nothing");
  arm_check->callback([&call] { call.code = check_arm(call.options, call.arm_seconds); });
  CLI::App* arm_hold = arm->add_subcommand(
      "hold", "command zero torque, so that the arm carries itself; ctrl-C ends it");
  arm_hold->callback([&call] { call.code = hold_arm(call.options, call.arm_seconds); });
  for (CLI::App* command : {arm_check, arm_hold}) {
    command->add_option("scenario", call.options.scenario,
                        "YAML file that names the arm (default: the standard bowl's)");
    command->add_option("--arm", call.options.arm, "which arm: iiwa-lcm (default) or franka")
        ->check(CLI::IsMember({"iiwa-lcm", "franka"}));
    command->add_option("--seconds", call.arm_seconds, "how long")
        ->check(CLI::Range(0.1, 86400.0))
        ->capture_default_str();
    add_set(command, &call.options,
            "override a setting, as in --set arm.url=tcpq://127.0.0.1:7702");
  }
}

void add_make_urdf(CLI::App* arm, Call& call) {
  CLI::App* arm_urdf = arm->add_subcommand(
      "make-urdf",
      "write an arm's description with a pen on its flange, and what it lacks filled in");
  arm_urdf
      ->add_option("--arm", call.bare_arm,
                   "fr3, gen3, iiwa14, iiwa7, panda or ur5e; or a vendor's URDF file")
      ->required();
  arm_urdf->add_option("--flange", call.flange,
                       "the link that carries the pen, z out of it (default: the one that is clear "
                       "by its name, along the last joint's axis)");
  arm_urdf
      ->add_option("--tool-length", call.pen.length,
                   "from the flange to the pen's tip, in m, along the "
                   "flange's axis")
      ->check(CLI::Range(0.02, 1.0))
      ->capture_default_str();
  arm_urdf->add_option("--tool-mass", call.pen.mass, "of the whole tool, in kg")
      ->check(CLI::Range(1e-3, 20.0))
      ->capture_default_str();
  arm_urdf->add_option("--out", call.arm_file, "the file (default: ARM_pen.urdf)");
  arm_urdf->callback(
      [&call] { call.code = make_urdf(call.bare_arm, call.flange, call.pen, call.arm_file); });
}

void add_commissioning(CLI::App* arm, Call& call) {
  CLI::App* latency = arm->add_subcommand(
      "latency", "measure the loop's delay by small torques on the last joint, in the air");
  latency->callback([&call] { call.code = commission_latency(call.options, call.commissioning); });
  CLI::App* friction = arm->add_subcommand(
      "friction", "measure each joint's friction by slow sweeps of 0.2 rad, in the air");
  friction->callback(
      [&call] { call.code = commission_friction(call.options, call.commissioning); });
  CLI::App* camera_latency = arm->add_subcommand(
      "camera-latency",
      "measure the cameras' latency while the canvas moves as canvas.motion says; moves nothing");
  camera_latency->add_option("--seconds", call.watch_seconds, "how long")
      ->check(CLI::Range(1.0, 3600.0))
      ->capture_default_str();
  camera_latency->callback([&call] {
    call.code = commission_camera_latency(call.options, call.commissioning, call.watch_seconds);
  });
  CLI::App* touch =
      arm->add_subcommand("touch", "note where the tip rests: led there by hand; moves nothing");
  touch
      ->add_option(
          "--mark", call.mark,
          "pen: the one point of pen-length, touched at several tilts; X,Y or X,Y,Z: a mark of the "
          "page, in m")
      ->required();
  touch->callback(
      [&call] { call.code = commission_touch(call.options, call.commissioning, call.mark); });
  CLI::App* pen_length =
      arm->add_subcommand("pen-length", "the pen's length, from touches of one point");
  pen_length->callback([&call] { call.code = commission_pen_length(call.commissioning); });
  CLI::App* page = arm->add_subcommand("register", "where the page is, from touches of its marks");
  page->callback([&call] { call.code = commission_register(call.commissioning); });
  for (CLI::App* command : {latency, friction, camera_latency, touch, pen_length, page})
    command
        ->add_option("--into", call.commissioning,
                     "folder of commissioning.json, which each step reads and adds to")
        ->capture_default_str();
  for (CLI::App* command : {latency, friction, camera_latency, touch}) {
    command->add_option("scenario", call.options.scenario,
                        "YAML file that names the arm (default: the standard bowl's)");
    command
        ->add_option("--arm", call.options.arm,
                     command == touch ? "which arm: iiwa-lcm (default) or franka"
                                      : "which arm: sim, iiwa-lcm or franka (default: as the "
                                        "scenario says)")
        ->check(CLI::IsMember(command == touch
                                  ? std::vector<std::string>{"iiwa-lcm", "franka"}
                                  : std::vector<std::string>{"sim", "iiwa-lcm", "franka"}));
    add_set(command, &call.options, "override a setting");
  }
}

}  // namespace

void add_arm(CLI::App& app, Call& call) {
  CLI::App* arm =
      app.add_subcommand("arm", "check or hold an arm that is not simulated here (docs/arms.md)");
  arm->require_subcommand(1);
  arm->footer(
      "Examples:\n  ./impedraw arm check --arm iiwa-lcm\n  ./impedraw arm hold --seconds 10 "
      "--set arm.url=tcpq://127.0.0.1:7702");
  add_check_and_hold(arm, call);
  add_make_urdf(arm, call);
  add_commissioning(arm, call);
}

}  // namespace impedraw
