// The program's commands. Each returns the exit code.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "impedraw/arm/arm_notes.h"
#include "impedraw/canvas/mesh_file.h"
#include "impedraw/common/exit_code.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/experiment/prepare.h"
#include "impedraw/live/live_view.h"
#include "impedraw/run/draw_into.h"

namespace impedraw {

// With --place auto, moves canvas and drawing to where the arm reaches them best; with --place
// surface, the drawing alone to where it can be drawn. Prints the placement.
Scenario placed(const DrawOptions& options, const Scenario& scenario, const Places& places);

// `table`: prints all metrics, not only how it went.
int draw(const DrawOptions& options, const LiveOptions& live = {}, bool table = false);
// The pre-flight alone, with a picture; kMissed where something cannot be drawn. `suggest`: also
// settings to try.
int plan(const DrawOptions& options, bool as_json, bool suggest);
int preview(const DrawOptions& options);  // a flat picture of the artwork; nothing is checked
int compare(const DrawOptions& options, bool table);  // with and without perception, side by side
// Finished runs, by their folders: leaves compare.html and its picture in `out`.
int compare_finished(const std::vector<std::filesystem::path>& runs,
                     const std::filesystem::path& out);
// Metrics, pictures and report of a run again, from its log.
int report(const std::filesystem::path& folder, bool table);
int calibrate_tool(const DrawOptions& options,
                   int poses);  // mass and centre of mass of the tool, on the simulated arm
// Every setting: for a terminal, as docs/settings.md, or as docs/scenario.schema.json.
enum class SettingsForm { users, all, markdown, json_schema };
int print_settings(SettingsForm form);

// The command `cover`: treats an area with a pad.

// Leaves the results of a drawing (its strokes are cover.csv), cover.json and cover.png;
// metrics.json has the area's metrics, too. Returns the exit code. Throws InputError before
// anything moves.
int cover(const DrawOptions& options, const std::filesystem::path& region, bool table);

// Commissioning an arm, step by step (docs/commissioning.md). Each step leaves what it found in
// commissioning.json of a folder, and refuses to begin without the steps before it:
//
//   latency → friction → touch (often) → pen-length → register
//   camera-latency, at any time
//
// All but touch, pen-length and register move the arm, in the air, by little. `draw --commissioned`
// takes the results.

// All return kFinished, and throw where a result is implausible; then nothing is written.
int commission_latency(const DrawOptions& options, const std::filesystem::path& folder);
int commission_friction(const DrawOptions& options, const std::filesystem::path& folder);
// The cameras' latency and the error of their time stamps, while the canvas moves as the scenario's
// canvas.motion says: a device that is known to. Needs no step before it.
int commission_camera_latency(const DrawOptions& options, const std::filesystem::path& folder,
                              double seconds);
// Notes the tip's pose at rest, led there by hand or brought by another program. `mark`: "pen" for
// a touch of the one point of pen-length, or "X,Y" or "X,Y,Z", where a mark of the page or of the
// mesh is [m].
int commission_touch(const DrawOptions& options, const std::filesystem::path& folder,
                     const std::string& mark);
int commission_pen_length(const std::filesystem::path& folder);
int commission_register(const std::filesystem::path& folder);

// The options with what was found as settings before those of the command line: the loop's delay,
// and, for a mesh, the pose of the page. Says what it takes. Throws InputError for a folder of
// another arm, one without a delay, and a pen of another length than the URDF's.
DrawOptions with_commissioning(DrawOptions options, const std::filesystem::path& folder);

// ./impedraw judge-force: the force benchmark (docs/force.md).

struct JudgeForceOptions {
  // sim, iiwa-lcm or franka: who moves the arm. Or the simulated arm itself: iiwa, an arm of
  // models/arms, or a URDF file.
  std::string arm = "sim";
  std::vector<std::string> controllers;  // empty: all
  std::vector<std::string> cases;        // empty: all
  int runs = 5;
  std::filesystem::path sensor;  // readings under the workpiece (SensorFile); empty: the arm's own
  std::filesystem::path rig;     // file of a rig's orders (force_rig.h); empty: there is no rig
};

// Leaves force.json and force.html in options.out, by default runs/judge-force. Ctrl-C keeps what
// was run. Returns the exit code.
int judge_force(DrawOptions options, const JudgeForceOptions& judged);

// ./impedraw place: a page on 127.0.0.1 that shows the object, on which the drawing is dragged,
// turned and scaled, and tells at once what of it can be drawn. Saving writes a scenario.
//
// Questions of the page, and of anybody without one (--headless), each with a placement
// {"x", "y": of the drawing's middle in the drawing plane [m], "turn": from the given one [deg],
// "size": times the given one}:
//   check   what of it can be drawn, quickly:
//           {"share", "length_mm", "time_s", "width_mm", "height_mm", "lost_mm": {trouble: mm}}
//   plan    the same share, by the whole pre-flight, which takes seconds: {"share"}
//   save    writes the scenario: {"file"}; "overwrite": true replaces a file that is there. In
//           place of a placement, "areas" [[x, y, x, y, …], …] are outlines in the drawing plane
//           [m] of what `cover` is to treat
//   end     ends the command

struct PlaceOptions {
  std::filesystem::path save = "placed.yaml";
  int port = 0;           // 0: a free one
  bool headless = false;  // no browser is opened
};

// options.scenario may name a mesh in place of a scenario. Returns at ctrl-C or `end`.
int place_by_hand(DrawOptions options, const PlaceOptions& place);

// Describes the contents of a file without drawing it.
//
// Artwork (.svg, .txt, .strokes, .csv): strokes, length_mm, bbox_mm [x0, y0, x1, y1] of their
// centrelines on the page, y down (null without strokes), layers [{name, strokes}] in the
// document's order, warnings. One-point strokes are dots and have no length.
//
// Cloud (.pcd, .xyz, .ply without faces): points, invalid (those that are skipped), bbox_m,
// normals, colours, viewpoints_m.

// Throws InputError like read_artwork(). An empty drawing is a warning, not an error.
nlohmann::ordered_json describe_artwork(const std::filesystem::path& file);

// Prints what an artwork, a cloud or, by its name's ending, a mesh holds (app/commands.h), as
// JSON or as lines to be read. Returns the exit code.
int inspect(const std::filesystem::path& file, bool json, const MeshReading& reading = {});

// Describes the contents of a mesh file.

// triangles: as in the file, polygons cut. Of the merged and repaired surface
// (canvas/mesh_check.h), in the file's own pose with z up: bbox_m [x0, y0, z0, x1, y1, z1],
// area_m2, closed, components, slope_max_deg (largest angle of a facet's normal to +z, 0 to 180),
// warnings [line], faults [{kind, count, first, repaired, message}]. InputError as load_mesh.
nlohmann::ordered_json describe_mesh(const std::filesystem::path& file, const MeshReading& reading);

// Arms that are not simulated here: making a driver, and the commands `arm check` and `arm hold`.

// Makes the scenario's driver; empty for the simulated arm. Refers to the experiment.
DriverMaker driver_maker(const Experiment& experiment);

// Throws InputError where the loop would be paused (redrawing, live view, pace) and the arm does
// not wait.
void require_steady_loop(const Scenario& scenario, const LiveOptions& live);

// Says where contact and ink of the run come from, if not from the simulator.
std::string contact_line(const Experiment& experiment);

// Exit code 0 if the arm could be used, kMissed if its statuses come too irregularly.
int check_arm(const DrawOptions& options, double seconds);
int hold_arm(const DrawOptions& options, double seconds);

struct RestingArm {
  JointVector q;  // mean [rad]
  std::unique_ptr<ArmModel> model;
};

// The posture in which an arm that is not simulated here rests for `seconds`; sends nothing. Throws
// std::runtime_error if a joint is faster than `at_rest` [rad/s].
RestingArm posture_at_rest(const DrawOptions& options, double seconds, double at_rest);

// Writes the description of an arm with a pen on its flange, once it is known to be an arm: of one
// of models/arms, or of a vendor's file (plain_urdf.h), on the link `flange` if it is given.
int make_urdf(const std::string& arm, const std::string& flange, const PenOnFlange& pen,
              const std::filesystem::path& out);

}  // namespace impedraw
