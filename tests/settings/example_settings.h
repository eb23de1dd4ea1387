// A scenario in miniature that uses everything a description can: the worked example of
// src/settings/schema.h.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/settings/schema.h"

namespace impedraw::example {

enum class Sensor { none, truth };

struct Push {
  double force = 5;
  Sensor sensor = Sensor::none;
  std::optional<double> stop_at;
};

struct Camera {
  Eigen::Vector3d position{0.5, 0, 0.9};
  int width = 640;
  bool noisy = false;
};

struct Plane {
  double height = 0.1;
};

struct Scenario {
  std::uint64_t seed = 1;
  std::string text = "M";
  std::filesystem::path svg;
  Eigen::VectorXd home = Eigen::VectorXd::Zero(7);
  std::vector<double> speeds;
  Push push;
  std::vector<Camera> cameras{Camera{}};
  std::optional<Plane> plane;
};

inline void describe(Fields& f, Push& s) {
  f.field("force", s.force, Range{0, 50}, "N", "normal force asked for").formerly("strength");
  f.choice("sensor", s.sensor, {"none", "true"}, "where the wrench comes from")
      .formerly("real", "true");
  f.field("stop_at", s.stop_at, Range::at_least(0), "s",
          "when to stop; absent: at the end of the drawing");
}

inline void describe(Fields& f, Camera& s) {
  f.field("position", s.position, Range{-10, 10}, "m", "p_WC");
  f.field("width", s.width, Range{1, 4096}, "px", "columns");
  f.field("noisy", s.noisy, "whether depth is noisy").formerly("grainy");
}

inline void describe(Fields& f, Plane& s) {
  f.field("height", s.height, Range::any(), "m", "above the table");
}

inline void describe(Fields& f, Scenario& s) {
  f.field("seed", s.seed, Range::at_least(0), "", "of all random numbers");
  f.field("text", s.text, "what to write");
  f.field("svg", s.svg, "artwork");
  f.field("home", s.home, Range{-3, 3}, "rad", "posture of the null space");
  f.field("speeds", s.speeds, Range::positive(), "m/s", "to try");
  f.field("push", s.push, "the push along the normal");
  f.field("cameras", s.cameras, "depth cameras");
  f.field("plane", s.plane, "what a blind pen believes in");
}

}  // namespace impedraw::example
