// The views of depth cameras, as a folder of files: capture.json and one PNG for each depth image
// (docs/capture.md). Any number of views, each with its own intrinsics and pose.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "impedraw/capture/lens.h"
#include "impedraw/common/pose.h"
#include "impedraw/perception/depth_camera.h"

namespace impedraw {

// Images of a capture, as PNG files.
struct GreyImage {
  int width = 0, height = 0;          // [px]
  std::vector<std::uint16_t> values;  // row by row
};

struct ColourImage {
  int width = 0, height = 0;      // [px]
  std::vector<std::uint8_t> rgb;  // three bytes a pixel, row by row
};

// A 16-bit grey PNG, values as they stand in the file. Throws InputError for any other kind, and
// for a file that is damaged, cut short or larger than 8192 px on a side.
GreyImage read_grey_png(const std::filesystem::path& file);

// A PNG of any kind, as 8-bit RGB.
ColourImage read_colour_png(const std::filesystem::path& file);

struct CapturedView {
  std::string name;  // its depth image's
  Lens lens;
  Pose X_WC;
  std::vector<double> joints;     // of the arm at the exposure [rad]; may be empty
  double sigma_at_1m = 0.0;       // depth noise [m]; 0: not known
  double quantum = 0.0;           // step of the depth values [m]
  std::optional<double> time;     // [s]
  std::filesystem::path file;     // of the depths
  DepthImage depth;               // along z of C [m]; NaN: no measurement
  std::vector<std::uint8_t> rgb;  // three bytes a pixel; may be empty
};

struct Capture {
  std::vector<CapturedView> views;
  // Later views of a capture that is played back, in order of time, without their images.
  std::vector<CapturedView> played;
  std::vector<std::string> notes;  // keys that mean nothing here, one line each

  struct Limits {
    static constexpr int views = 256, played = 100000;
    static constexpr double pixels = 2e8;  // of all views
  };
};

// The pose X_WE of the tip at some joint positions [rad]. Throws InputError for a wrong number.
using TipPose = std::function<Pose(const std::vector<double>&)>;

// Throws InputError, one line that names the view and the value, for a folder that is no capture.
// `tip_pose` places the cameras that are on the tool. played_back: views after time 0 are frames.
Capture read_capture(const std::filesystem::path& folder, const TipPose& tip_pose,
                     bool played_back = false);

// Reads the depths of a view. Throws InputError, as above.
void read_depth(CapturedView* view);

}  // namespace impedraw
