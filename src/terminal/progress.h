// The line that tells how far a run is, redrawn in place.
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
  double share = 0;              // of the whole way, 0 to 1
  double drawn = 0, length = 0;  // pen-down length so far and in all [m]; no length: left out
  bool again = false;            // what got no ink is being drawn again
};

// The line after `wall_time` seconds of running. Time left goes by the share done so far; it is
// "-:--" until a hundredth and a quarter of a second have passed. Longer than `columns` it loses
// its end.
std::string progress_line(const Progress& progress, double wall_time, int columns = 80);

// Of work before the drawing: "placing the canvas   43 %  0:02 left".
std::string step_line(const std::string& what, double share, double wall_time);

// "0:07", "12:34", "1:02:03"
std::string clock_text(double seconds);

// Draws at most ten lines a second, and nothing at all where `out` is no terminal. Made when the
// run starts; its end wipes the line.
class ProgressLine {
 public:
  using Clock = std::chrono::steady_clock;

  // `shown`: whether to draw; by default when `out` is a terminal.
  explicit ProgressLine(std::FILE* out = stderr, std::optional<bool> shown = std::nullopt,
                        Clock::time_point start = Clock::now());
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  // May be called at every step: it costs a look at the clock, and nothing where nothing is shown.
  void update(const Progress& progress) {
    if (shown_) draw(progress, Clock::now());
  }
  void update(const std::string& what, double share) {  // of work before the drawing
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
