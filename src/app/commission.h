// Commissioning an arm, step by step (docs/commissioning.md). Each step leaves what it found in
// commissioning.json of a folder, and refuses to begin without the steps before it:
//
//   latency → friction → touch (often) → pen-length → register
//   camera-latency, at any time
//
// All but touch, pen-length and register move the arm, in the air, by little. `draw --commissioned`
// takes the results.
#pragma once

#include <filesystem>
#include <string>

#include "impedraw/experiment/draw_options.h"

namespace impedraw {

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

}  // namespace impedraw
