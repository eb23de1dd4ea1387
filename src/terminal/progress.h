// A progress line, redrawn in place.
//
//   drawing   12.4 s  stroke 2/5  0.31/0.46 m   63 %  0:07 left  41x real time
#pragma once

#include <chrono>
#include <cstdio>
#include <optional>
#include <string>

namespace impedraw {

struct Progress {
  double simulated_time = 0;  // [s]
  int stroke = 0;             // the one being drawn, from 1; 0 before the first
  int strokes = 0;
  double share = 0;  // of the whole run, 0 to 1
  // pen-down length so far and in total [m]; not shown if length is 0
  double drawn = 0, length = 0;
  bool again = false;     // redrawing the parts without ink
  double first_time = 0;  // simulated by an earlier run that this one continues [s]
  // Cause of a wait, and the time for which the pen has waited [s]; null: none.
  const char* waits_for = nullptr;
  double waited = 0;
};

// While it waits:  waiting   12.4 s  for the canvas to rest, for 3 s
//
// The line after `wall_time` seconds. The time left is extrapolated from the share done; it is
// "-:--" until a hundredth is done and a quarter of a second has passed. The line is cut at
// `columns`.
std::string progress_line(const Progress& progress, double wall_time, int columns = 80);

// The line for work before the drawing: "placing the canvas   43 %  0:02 left".
std::string step_line(const std::string& what, double share, double wall_time);

// "0:07", "12:34", "1:02:03"
std::string clock_text(double seconds);

// Draws at most ten lines per second, and nothing if `out` is not a terminal. Construct it when the
// run starts; the destructor wipes the line.
class ProgressLine {
 public:
  using Clock = std::chrono::steady_clock;

  // `shown`: whether to draw; by default only if `out` is a terminal.
  explicit ProgressLine(std::FILE* out = stderr, std::optional<bool> shown = std::nullopt,
                        Clock::time_point start = Clock::now());
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  // Cheap enough for every step: reads the clock, and does nothing if nothing is shown.
  void update(const Progress& progress) {
    if (shown_) draw(progress, Clock::now());
  }
  void update(const std::string& what, double share) {  // for work before the drawing
    if (shown_) draw(what, share, Clock::now());
  }
  void draw(const Progress& progress, Clock::time_point now);
  void draw(const std::string& what, double share, Clock::time_point now);
  void wipe();  // before anything else is printed

 private:
  bool due(Clock::time_point now);
  void put(const std::string& line);

  std::FILE* out_;
  bool shown_;
  bool on_screen_ = false;
  Clock::time_point start_;
  Clock::time_point next_;
};

}  // namespace impedraw
