// Commissioning an arm, step by step (docs/commissioning.md). Each step leaves what it found in
// commissioning.json of a folder, and refuses to begin without the steps before it:
//
//   latency → friction → touch (often) → pen-length → register
//
// All but touch, pen-length and register move the arm, in the air, by little.
#pragma once

#include <filesystem>
#include <string>

#include "impedraw/experiment/draw_options.h"

namespace impedraw {

// All return kFinished, and throw where a result is implausible; then nothing is written.
int commission_latency(const DrawOptions& options, const std::filesystem::path& folder);
int commission_friction(const DrawOptions& options, const std::filesystem::path& folder);
// Notes the tip's pose at rest, led there by hand or brought by another program. `mark`: "pen" for
// a touch of the one point of pen-length, or "X,Y", where a mark of the page is [m].
int commission_touch(const DrawOptions& options, const std::filesystem::path& folder,
                     const std::string& mark);
int commission_pen_length(const std::filesystem::path& folder);
int commission_register(const std::filesystem::path& folder);

}  // namespace impedraw
