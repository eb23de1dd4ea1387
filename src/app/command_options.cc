#include "impedraw/app/command_options.h"

#include <unistd.h>

#include <fmt/format.h>
#include <CLI/CLI.hpp>

namespace impedraw {

void add_set(CLI::App* command, DrawOptions* options, const char* help) {
  command->add_option("--set", options->assignments, help)->take_all()->allow_extra_args(false);
}

namespace {

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
      "  ./impedraw draw --image portrait.jpg           # by lines that show its tone\n"
      "  ./impedraw draw --svg signature.svg --trace    # along the middle of its shapes\n"
      "  ./impedraw draw --text Hi --live --pace 1      # watch it in real time");
  command->callback([&call] {
    call.code = draw(with_commissioning(call.options, call.commissioned), call.live, call.table);
  });
  return command;
}

CLI::App* add_cover(CLI::App& app, Call& call) {
  CLI::App* command = app.add_subcommand(
      "cover",
      "treat an area with a pad: lines that cover it, drawn with an even force; or coat it");
  command->add_option("scenario", call.options.scenario,
                      "YAML file (default: a dome, with realistic sensing: cover-dome.yaml)");
  command->add_option("--region", call.region,
                      "SVG whose filled areas are covered, or mesh.ply#rrggbb: its faces of that "
                      "colour (default: all that is reached)");
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
      "  ./impedraw cover --set cover.passes=2 --set control.normal_force=8\n"
      "  ./impedraw cover --region map.svg --set cover.dose=by_tone   # dark: much, light: little\n"
      "  ./impedraw cover --set tool.kind=nozzle --set tool.stand_off=0.15");
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

// Options that place the drawing, of a command that plans.
void add_placing(CLI::App* command, Call& call) {
  command
      ->add_option(
          "--place", call.options.place,
          "where canvas and drawing are: fixed, as the scenario says; auto, both "
          "moved to where the arm reaches best, or as surface where not all of it can be drawn "
          "there; surface, the drawing moved on the canvas to where most of it can be "
          "drawn (default: fixed, but auto where "
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
      "place",
      "put the drawing on the object by hand, or mark an area for cover, on a page that tells what "
      "can be drawn");
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
      "  ./impedraw cover placed.yaml          # where an area was marked\n"
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
  command->add_option(
      "--rig", call.judged.rig,
      "JSON file that tells a rig before each run what the workpiece under a driven arm is and "
      "does (docs/force.md); without, cases on other workpieces than the bowl are left out");
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

}  // namespace

std::vector<CLI::App*> add_commands(CLI::App& app, Call& call, int argc, char** argv) {
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
  return checked;
}

}  // namespace impedraw
