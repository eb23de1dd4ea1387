// The tool at the arm's end, and how an area is covered with it.
#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "impedraw/simulation/world_settings.h"

namespace impedraw {

enum class ToolKind { pen, pad, engraver, blade, roller };
enum class Swivel { spot, lifted };  // of a tool that is led, at corners

struct ToolSettings {
  ToolKind kind = ToolKind::pen;
  std::optional<double> radius;                     // of the face; absent: see settings.md [m]
  double foam_stiffness = PadSettings().stiffness;  // [N/m³]
  double depth = 0.3e-3;                            // of an engraver's groove [m]
  double half_angle_deg = 45.0;                     // of its cone
  int passes = 1;                                   // to that depth, after a shallow one
  double hardness = 1.0;                            // of the true material, over the believed one
  double yaw_deg = 0.0;                             // of what is led, from the line
  double trail = 0.0;                               // of its face behind the arm's axis [m]
  Swivel swivel = Swivel::spot;
};

// Its heading is led along the lines (led_heading.h).
inline bool is_led(const ToolSettings& tool) {
  return tool.kind == ToolKind::blade || tool.kind == ToolKind::roller;
}

// The pad of these settings, which lies level with E under `force` [N]; nothing for another tool.
std::optional<PadSettings> pad_of(const ToolSettings& tool, double friction, double force);

// The cutter of these settings in the believed material; nothing for another tool.
std::optional<CutterSettings> cutter_of(const ToolSettings& tool);

// Depths of an engraver's passes, the shallow one that finds the surface first [m].
std::vector<double> depths_of(const ToolSettings& tool);

struct CoverSettings {
  std::filesystem::path
      region;                   // an SVG whose filled areas are covered; empty: all that is reached
  double overlap = 0.82;        // of neighbouring lines, as a share of the footprint's width
  double direction_deg = 90.0;  // of the lines, from the drawing plane's x axis
  double margin = 1e-3;         // that the footprint keeps from edges [m]
  int passes = 1;
};

}  // namespace impedraw
