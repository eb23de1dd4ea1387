#include "impedraw/app/command_line.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include "impedraw/app/arm.h"
#include "impedraw/app/commands.h"
#include "impedraw/app/commission.h"
#include "impedraw/app/cover.h"
#include "impedraw/app/inspect.h"
#include "impedraw/app/judge_force.h"
#include "impedraw/app/place.h"
#include "impedraw/common/errors.h"
#include "impedraw/report/film.h"
#include "impedraw/settings/settings_text.h"
#include "impedraw/terminal/called.h"
#include "impedraw/terminal/interrupt.h"
#include "impedraw/terminal/say.h"

namespace impedraw {

namespace {

void add_set(CLI::App* command, DrawOptions* options, const char* help) {
  command->add_option("--set", options->assignments, help)->take_all()->allow_extra_args(false);
}

void add_scenario_options(CLI::App* command, DrawOptions* options) {
  command->add_option("scenario", options->scenario,
                      "YAML file (default: the sine in the standard bowl)");
  command->add_option("--shape", options->shape, "built-in drawing: sine, M, sine10, circle");
  command
      ->add_option("--svg", options->svg,
                   "your own drawing: .svg, or strokes as .txt, .strokes or .csv")
      ->excludes("--shape");
  command->add_option("--text", options->text, "text to write in single strokes; \\n ends a line")
      ->excludes("--shape")
      ->excludes("--svg");
  command->add_option("--layer", options->layer,
                      "draw these layers alone, by number or name, as in 2,black");
  command->add_flag(
      "--keep-order", options->keep_order,
      "keep the order of the file's strokes (default: ordered for short ways in the air)");
  command->add_option("--out", options->out,
                      "folder for the run, created if missing (default: runs/NAME)");
  add_set(command, options, "override a setting, as in --set path.draw_speed=0.1; may be repeated");
}

// Some libraries' messages are longer.
std::string one_line(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

// Names and texts from here end up in JSON and HTML, which hold UTF-8 alone.
void require_utf8(int argc, char** argv) {
  for (int i = 1; i < argc; ++i)
    if (!is_utf8(argv[i]))
      throw InputError(fmt::format("argument '{}' is not valid UTF-8", printable(argv[i])));
  std::error_code error;
  const std::string folder = std::filesystem::current_path(error).string();
  if (!error && !is_utf8(folder))
    throw InputError(fmt::format("the name of the working directory, {}, is not valid UTF-8",
                                 printable(folder)));
}

// What the buffer still holds may find a full disk.
int flushed(int code) {
  errno = 0;
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return code;
  say(stderr, "impedraw: cannot write to the standard output: {}\n",
      errno != 0 ? std::strerror(errno) : "an earlier write failed");
  return kStopped;
}

int fail(const std::string& what, int code) {
  std::fflush(stdout);
  say(stderr, "impedraw: {}\n", one_line(what));
  return code;
}

// What the arguments say, and the exit code of the command that they name.
struct Call {
  DrawOptions options;
  LiveOptions live;
  PlaceOptions by_hand;
  FilmOptions filmed;
  JudgeForceOptions judged;
  PenOnFlange pen;
  SettingsForm form = SettingsForm::users;
  std::filesystem::path commissioned, region, folder, inspected, arm_file;
  std::filesystem::path commissioning = "commissioning";
  std::vector<std::filesystem::path> compared;
  std::string unit, bare_arm, flange, mark;
  bool table = false, plan_json = false, plan_suggest = false, as_json = false;
  int poses = 8;
  double arm_seconds = 2.0, watch_seconds = 20.0;
  int code = 0;
};

const std::map<std::string, LengthUnit> kUnits{
    {"m", LengthUnit::m}, {"mm", LengthUnit::mm}, {"cm", LengthUnit::cm}, {"in", LengthUnit::in}};

void add_metrics(CLI::App* command, Call& call) {
  command->add_flag("--metrics", call.table, "print all metrics (default: how it went)");
}

CLI::App* add_draw(CLI::App& app, Call& call) {
  CLI::App* command = app.add_subcommand(
      "draw", "draw artwork on a canvas; writes the drawing, its metrics and a report");
  add_scenario_options(command, &call.options);
  command->add_flag("--no-perception", call.options.no_perception,
                    "stiffness control without perception, with the set-point beneath the surface");
  command->add_flag(
      "--skip-unreachable", call.options.skip_unreachable,
      "draw what passes the pre-flight and list the rest (default: draw all or nothing)");
  command->add_flag("--resume", call.options.resume,
                    "continue an interrupted run: keep what it drew, draw what has no ink");
  command
      ->add_option("--arm", call.options.arm,
                   "who moves the arm: sim, iiwa-lcm or franka (default: as the scenario says)")
      ->check(CLI::IsMember({"sim", "iiwa-lcm", "franka"}));
  CLI::Option* show = command->add_flag(
      "--live", call.live.show, "show the run in a browser while it goes on; prints the address");
  command
      ->add_option("--port", call.live.port, "port of 127.0.0.1 for --live (default: a free one)")
      ->check(CLI::Range(1, 65535))
      ->needs(show);
  command
      ->add_option("--pace", call.live.pace,
                   "seconds of the run that a second shows (default: as fast as it goes)")
      ->check(CLI::Range(0.01, 1000.0));
  add_metrics(command, call);
  command->footer(
      "Examples:\n  ./impedraw draw\n  ./impedraw draw scenarios/bowl-m-natural.yaml\n  ./impedraw "
      "draw --svg flower.svg --set "
      "drawing.placement.fit_radius=0.12\n"
      "  ./impedraw draw --shape M --no-perception --out /tmp/m-blind\n"
      "  ./impedraw draw --svg flower.svg --resume      # after ctrl-C: continues the run\n"
      "  ./impedraw draw --text Hi --live --pace 1      # watch it in real time");
  command->callback([&call] {
    call.code = draw(with_commissioning(call.options, call.commissioned), call.live, call.table);
  });
  return command;
}

CLI::App* add_cover(CLI::App& app, Call& call) {
  CLI::App* command = app.add_subcommand(
      "cover", "treat an area with a pad: lines that cover it, drawn with an even force");
  command->add_option("scenario", call.options.scenario,
                      "YAML file (default: a dome, with realistic sensing: cover-dome.yaml)");
  command->add_option("--region", call.region,
                      "SVG whose filled areas are covered (default: all that is reached)");
  command->add_option("--out", call.options.out,
                      "folder for the run, created if missing (default: runs/NAME)");
  add_set(command, &call.options,
          "override a setting, as in --set tool.radius=0.01; may be repeated");
  command->add_flag("--resume", call.options.resume,
                    "continue an interrupted run, named again with its settings and --out");
  add_metrics(command, call);
  command->footer(
      "Examples:\n  ./impedraw cover\n  ./impedraw cover scenarios/reach-saddle.yaml\n"
      "  ./impedraw cover --region window.svg --set drawing.placement.width=120\n"
      "  ./impedraw cover --set cover.passes=2 --set control.normal_force=8");
  command->callback([&call] { call.code = cover(call.options, call.region, call.table); });
  return command;
}

CLI::App* add_plan(CLI::App& app, Call& call) {
  CLI::App* command = app.add_subcommand("plan",
                                         "check which strokes can be drawn, without moving: what "
                                         "fails, where and why, how long it takes; draws a picture "
                                         "and a page");
  add_scenario_options(command, &call.options);
  command->add_flag("--json", call.plan_json, "print JSON");
  command->add_flag(
      "--suggest", call.plan_suggest,
      "propose settings for this surface: voxel, neighbourhood, speed, tilt allowance");
  command->footer(
      "The exit code is 0 if everything can be drawn, else 1.\n"
      "Examples:\n  ./impedraw plan --svg artwork/koi.svg\n  ./impedraw plan --svg flower.svg "
      "--set drawing.placement.fit_radius=0.3\n"
      "  ./impedraw draw --svg flower.svg --set drawing.placement.fit_radius=0.3 "
      "--skip-unreachable");
  command->callback([&call] {
    call.code = plan(with_commissioning(call.options, call.commissioned), call.plan_json,
                     call.plan_suggest);
  });
  return command;
}

// Where the drawing lies, of a command that plans.
void add_placing(CLI::App* command, Call& call) {
  command
      ->add_option("--place", call.options.place,
                   "where canvas and drawing are: fixed, as the scenario says; auto, both "
                   "moved to where the arm reaches best; surface, the drawing moved on the "
                   "canvas to where most of it can be drawn (default: fixed, but auto where "
                   "arm.urdf cannot draw there and the scenario places neither)")
      ->check(CLI::IsMember({"fixed", "auto", "surface"}));
  command->add_option("--near", call.options.surface.near,
                      "with --place surface: near x,y,z (in m), or on the canvas's front (+x), "
                      "back, left (+y), right or top");
  command->add_flag("--shrink", call.options.surface.shrink,
                    "with --place surface: smaller where the whole does not fit");
  command->add_option("--commissioned", call.commissioned,
                      "folder that ./impedraw arm latency … register left: the loop's delay "
                      "and a mesh's pose are taken from it");
}

void add_place(CLI::App& app, Call& call) {
  CLI::App* command = app.add_subcommand(
      "place", "put the drawing on the object by hand, on a page that tells what can be drawn");
  add_scenario_options(command, &call.options);
  command->remove_option(command->get_option("scenario"));
  command->remove_option(command->get_option("--out"));
  command->add_option("canvas", call.options.scenario,
                      "a scenario (YAML), or a mesh (default: the standard bowl)");
  command->add_option("--save", call.by_hand.save, "scenario that Save writes")
      ->capture_default_str();
  command->add_option("--port", call.by_hand.port, "port of 127.0.0.1 (default: a free one)")
      ->check(CLI::Range(1, 65535));
  command->add_flag("--headless", call.by_hand.headless, "open no browser; print the address");
  command->footer(
      "Examples:\n  ./impedraw place --svg artwork/koi.svg helmet.obj\n"
      "  ./impedraw place --text Hello --set perception.source=capture --set "
      "perception.capture=FOLDER\n"
      "  ./impedraw draw placed.yaml\n"
      "With --headless, questions are asked by POST: docs/place.md.");
  command->callback([&call] { call.code = place_by_hand(call.options, call.by_hand); });
}

CLI::App* add_compare(CLI::App& app, Call& call) {
  CLI::App* command = app.add_subcommand(
      "compare",
      "draw the same with and without perception and compare side by side, or compare "
      "finished runs");
  add_scenario_options(command, &call.options);
  command->remove_option(command->get_option("scenario"));
  command->add_option(
      "scenario", call.compared,
      "YAML file (default: the sine in the standard bowl), or the folders of two or "
      "more finished runs");
  add_metrics(command, call);
  command->footer(
      "Examples:\n  ./impedraw compare\n  ./impedraw compare scenarios/bowl-m.yaml --out /tmp/m\n"
      "  ./impedraw compare --svg flower.svg\n  ./impedraw compare runs/slow runs/fast");
  command->callback([&call, command] {
    std::error_code error;
    if (!call.compared.empty() &&
        (call.compared.size() > 1 || std::filesystem::is_directory(call.compared[0], error))) {
      for (const CLI::Option* option : command->get_options())
        if (option->count() > 0 && option->get_name() != "scenario" &&
            option->get_name() != "--out")
          throw InputError(fmt::format(
              "compare: {} does not go with finished runs, which are compared as they are",
              option->get_name()));
      call.code = compare_finished(call.compared, call.options.out);
      return;
    }
    if (!call.compared.empty()) call.options.scenario = call.compared[0];
    call.code = compare(call.options, call.table);
  });
  return command;
}

CLI::App* add_report(CLI::App& app, Call& call) {
  CLI::App* command = app.add_subcommand(
      "report", "compute metrics, pictures and report of a run again from its log");
  command->add_option("folder", call.folder, "folder of a run")->required();
  add_metrics(command, call);
  command->footer(
      "Examples:\n  ./impedraw report runs/bowl-sine\n  ./impedraw report /tmp/m-blind");
  command->callback([&call] { call.code = report(call.folder, call.table); });
  return command;
}

CLI::App* add_film(CLI::App& app, Call& call) {
  CLI::App* command =
      app.add_subcommand("film", "render a run as a film or as a picture, without a screen");
  command->add_option("run", call.filmed.run, "folder of a run, of a plan or of a comparison")
      ->required();
  command->add_option("--out", call.filmed.out, "film: .webp or .mp4; one picture: .png")
      ->required();
  command->add_option("--size", call.filmed.size, "width and height [px]")->capture_default_str();
  command->add_option("--fps", call.filmed.fps, "frames a second")
      ->check(CLI::Range(1.0, 120.0))
      ->capture_default_str();
  command
      ->add_option("--speed", call.filmed.speed,
                   "seconds of the run that a second of the film shows")
      ->check(CLI::Range(0.01, 1000.0))
      ->capture_default_str();
  command->add_option("--from", call.filmed.from,
                      "time at which the film begins [s] (default: the start)");
  command->add_option("--to", call.filmed.to,
                      "time at which it ends, or of the picture [s] (default: the end)");
  command
      ->add_option("--view", call.filmed.view,
                   "free, top, front, side, pen (along it), tip (follow it)")
      ->check(CLI::IsMember({"free", "top", "front", "side", "pen", "tip"}))
      ->capture_default_str();
  command->add_option("--colour", call.filmed.colour,
                      "of the ink: nothing, force, error, tilt, speed, pass (default: force)");
  command->add_option("--theme", call.filmed.theme, "light, dark")
      ->check(CLI::IsMember({"light", "dark"}))
      ->capture_default_str();
  command->add_option("--hide", call.filmed.hide,
                      "parts to leave out: arm,cloud,target,ink,normal,force,cameras,grid");
  command->add_flag("--plain", call.filmed.plain, "leave out legend, contact state and clock");
  command->footer(
      "Needs Chromium and ffmpeg of Debian, which ./impedraw film installs.\n"
      "Examples:\n  ./impedraw film runs/bowl-sine --out sine.webp --speed 2\n"
      "  ./impedraw film runs/koi --out koi.mp4 --view tip --from 12 --to 20 --size 1920x1080\n"
      "  ./impedraw film runs/koi --out koi.png --view top --colour error");
  command->callback([&call] { call.code = film(call.filmed); });
  return command;
}

CLI::App* add_preview(CLI::App& app, Call& call) {
  CLI::App* command = app.add_subcommand(
      "preview",
      "a flat picture of a drawing, at once: pens, widths, order, what is hidden, size, time");
  add_scenario_options(command, &call.options);
  for (const char* const other : {"scenario", "--svg", "--out"})
    command->remove_option(command->get_option(other));
  command->add_option("artwork", call.options.svg,
                      "artwork: .svg, or strokes as .txt, .strokes or .csv");
  command->add_option("--scenario", call.options.scenario,
                      "YAML file, whose pens and placement count");
  command->add_option("--out", call.options.out,
                      "picture to write, .png (default: NAME-preview.png)");
  command->footer(
      "Examples:\n  ./impedraw preview artwork/koi.svg\n  ./impedraw preview map.svg --layer "
      "2,black\n  ./impedraw preview signature.csv --set pen.width_per_newton=0.2");
  command->callback([&call] { call.code = preview(call.options); });
  return command;
}

CLI::App* add_inspect(CLI::App& app, Call& call) {
  CLI::App* command = app.add_subcommand("inspect",
                                         "describe an artwork, mesh or cloud file: strokes, "
                                         "length, layers; triangles, faults; points");
  command
      ->add_option("file", call.inspected,
                   std::string("artwork: .svg, or strokes as .txt, .strokes or .csv; a mesh: ") +
                       kMeshFiles + "; a cloud: .ply, .pcd or .xyz")
      ->required();
  command->add_flag("--json", call.as_json, "print JSON");
  command
      ->add_option("--unit", call.unit,
                   "unit of a mesh's coordinates: m, mm, cm, in (default: what it says, or m)")
      ->check(CLI::IsMember({"m", "mm", "cm", "in"}));
  command->footer(
      "Examples:\n  ./impedraw inspect artwork/koi.svg\n  ./impedraw inspect --json flower.svg\n"
      "  ./impedraw inspect vase.stl --unit mm");
  command->callback([&call] {
    MeshReading reading;
    if (!call.unit.empty()) reading.unit = metres(kUnits.at(call.unit));
    call.code = inspect(call.inspected, call.as_json, reading);
  });
  return command;
}

CLI::App* add_judge(CLI::App& app, Call& call) {
  CLI::App* command = app.add_subcommand(
      "judge-force",
      "judge how well an arm controls force: the same cases for this program's controller and two "
      "peers' laws; writes force.json and a page");
  command->add_option("scenario", call.options.scenario,
                      "YAML file: the arm, its sensors and the controller's settings (default: "
                      "force-benchmark)");
  command
      ->add_option("--arm", call.judged.arm,
                   "who moves the arm: sim, iiwa-lcm or franka; or the simulated arm: iiwa, fr3, "
                   "gen3, iiwa7, panda, ur5e or a URDF file")
      ->capture_default_str();
  command
      ->add_option("--controllers", call.judged.controllers,
                   "of ours, crisp, impedance, with commas between (default: all)")
      ->delimiter(',');
  command
      ->add_option("--cases", call.judged.cases,
                   "cases by name, with commas between, as in contact-30,steps (default: all)")
      ->delimiter(',');
  command->add_option("--runs", call.judged.runs, "seeded runs of each case")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  command->add_option(
      "--sensor", call.judged.sensor,
      "CSV file that a sensor under the workpiece leaves after the runs, for an arm "
      "that measures no wrench: time,force (docs/force.md)");
  command->add_option("--out", call.options.out, "folder (default: runs/judge-force)");
  add_set(command, &call.options,
          "override a setting, as in --set control.wrench=ground_truth; may be repeated");
  command->footer(
      "Examples:\n  ./impedraw judge-force\n  ./impedraw judge-force --cases steps,sweep "
      "--controllers ours --runs 1 --out /tmp/force\n"
      "  ./impedraw judge-force --arm ur5e --out /tmp/ur5e\n"
      "  ./impedraw judge-force my-arm.yaml --arm iiwa-lcm      # a driver of one's own");
  command->callback([&call] { call.code = judge_force(call.options, call.judged); });
  return command;
}

CLI::App* add_calibrate(CLI::App& app, Call& call) {
  CLI::App* command = app.add_subcommand(
      "calibrate-tool",
      "identify mass and centre of mass of the tool on the simulated wrench sensor");
  command->add_option(
      "scenario", call.options.scenario,
      "YAML file whose control.wrench is sensor or realistic (default: bowl-sine-realistic)");
  command->add_option("--poses", call.poses, "number of orientations in which the tool is held")
      ->check(CLI::Range(3, 100));
  add_set(command, &call.options,
          "override a setting, as in --set wrench_sensor.noise_force=0.2; may be repeated");
  command->footer(
      "Examples:\n  ./impedraw calibrate-tool\n  ./impedraw calibrate-tool "
      "scenarios/bowl-m-sensor.yaml --poses 12\n"
      "  ./impedraw calibrate-tool --set world.errors.mass_scale=1.2");
  command->callback([&call] { call.code = calibrate_tool(call.options, call.poses); });
  return command;
}

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

void add_settings(CLI::App& app, Call& call) {
  CLI::App* settings = app.add_subcommand(
      "settings", "list the settings of a scenario: default, limits, unit, meaning");
  CLI::Option* all = settings->add_flag(
      "--all", [&call](auto) { call.form = SettingsForm::all; },
      "print every setting, those of experts on the arm, too");
  CLI::Option* markdown =
      settings
          ->add_flag(
              "--markdown", [&call](auto) { call.form = SettingsForm::markdown; },
              "print every setting as Markdown, as in docs/settings.md")
          ->excludes(all);
  settings
      ->add_flag(
          "--json-schema", [&call](auto) { call.form = SettingsForm::json_schema; },
          "print a JSON Schema of scenario files, as in docs/scenario.schema.json")
      ->excludes(markdown)
      ->excludes(all);
  settings->footer(
      "Examples:\n  ./impedraw settings\n  ./impedraw settings --all | grep control\n"
      "  ./impedraw settings --markdown > docs/settings.md\n"
      "  ./impedraw settings --json-schema > docs/scenario.schema.json");
  settings->callback([&call] { call.code = print_settings(call.form); });
}

void add_bench(CLI::App& app, int argc, char** argv) {
  CLI::App* bench = app.add_subcommand("bench",
                                       "measure speed as ratios to floors of the same run; exit "
                                       "code 1 if a limit is missed");
  bench->prefix_command();
  bench->footer("Examples:\n  ./impedraw bench\n  ./impedraw bench --benchmark_filter=normal");
  bench->callback([argc, argv] {
    const std::filesystem::path program =
        std::filesystem::canonical("/proc/self/exe").parent_path() / "../../bench/impedraw_bench";
    std::vector<char*> arguments{const_cast<char*>("impedraw bench")};
    for (int i = 2; i < argc; ++i) arguments.push_back(argv[i]);
    arguments.push_back(nullptr);
    execv(program.c_str(), arguments.data());
    throw InputError(
        "the benchmark is not built: call it as ./impedraw bench, or build the target "
        "impedraw_bench");
  });
}

int run_program(int argc, char** argv) {
  CLI::App app(
      "impedraw: a pen on a simulated robot arm draws on unknown curved surfaces, held there by "
      "operational-space impedance control.");
  app.name("./impedraw");
  app.set_version_flag("--version", "impedraw " IMPEDRAW_VERSION, "print the version");
  app.require_subcommand(1);
  app.footer(
      "Each command has its own help with examples: ./impedraw draw --help\n"
      "Beside them, ./impedraw runs many drawings (sweep, robustness, reach), measures the figures "
      "of the documentation (figures), builds it (docs) and the Python package (wheel), and says "
      "what is installed (doctor).");
  app.failure_message(CLI::FailureMessage::simple);
  Call call;
  CLI::App *const draw = add_draw(app, call), *const cover = add_cover(app, call),
                  *const plan = add_plan(app, call);
  for (CLI::App* command : {draw, plan}) add_placing(command, call);
  add_place(app, call);
  CLI::App* const compare = add_compare(app, call);
  for (CLI::App* command : {draw, compare, cover})
    command->add_flag("--overwrite", call.options.overwrite,
                      "replace the results of a run in the folder of --out");
  const std::vector<CLI::App*> checked = {draw,
                                          cover,
                                          plan,
                                          compare,
                                          add_report(app, call),
                                          add_film(app, call),
                                          add_preview(app, call),
                                          add_inspect(app, call),
                                          add_judge(app, call),
                                          add_calibrate(app, call)};
  add_arm(app, call);
  add_settings(app, call);
  add_bench(app, argc, argv);
  for (CLI::App* command : checked)
    for (CLI::Option* option : command->get_options())
      if (option->get_items_expected_max() > 0)
        option->check(
            [](const std::string& text) {
              return text.empty() ? std::string("a value is missing") : std::string();
            },
            "", "");

  require_utf8(argc, argv);
  if (argc < 2) {
    say(stderr, "{}", app.help());
    return kBadInput;
  }
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands(nullptr))
    commands.push_back(command->get_name());
  const std::string first = argv[1];
  const bool known = std::find(commands.begin(), commands.end(), first) != commands.end();
  if (!known && !first.starts_with('-')) throw InputError("command " + not_among(first, commands));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // help or the version was asked for
      std::ostringstream text;
      app.exit(error, text);
      say(stdout, "{}", text.str());
      return kFinished;
    }
    return fail(fmt::format("{}; see ./impedraw {}--help", one_line(error.what()),
                            known ? first + " " : ""),
                kBadInput);
  }
  return call.code;
}

}  // namespace

int command_line(int argc, char** argv) {
  // A file opened under the number of a closed stream would receive what is printed.
  for (int stream = 0; stream < 3; ++stream)
    if (fcntl(stream, F_GETFD) < 0) open("/dev/null", O_RDWR);
  std::signal(SIGXFSZ, SIG_IGN);  // a file beyond its limit is an error like a full disk
  std::signal(SIGCHLD, SIG_DFL);  // ignored, it would hide how a child process ended
  try {
    return flushed(run_program(argc, argv));
  } catch (const Interrupted& error) {
    return fail(error.what(), error.exit_code());
  } catch (const InputError& error) {
    return fail(error.what(), kBadInput);
  } catch (const std::filesystem::filesystem_error& error) {
    if (error.code() != std::errc::filename_too_long) return fail(error.what(), kStopped);
    return fail(
        fmt::format("{}: the name is too long; a file system takes names of up to 255 bytes",
                    shown(error.path1().string())),
        kBadInput);
  } catch (const std::exception& error) {
    return fail(error.what(), kStopped);
  }
}

}  // namespace impedraw
