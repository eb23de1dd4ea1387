#include "impedraw/terminal/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

namespace impedraw {
namespace {

constexpr auto pause = std::chrono::milliseconds(100);

int columns_of(std::FILE* out) {
  winsize size{};
  return ioctl(fileno(out), TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace

std::string clock_text(double seconds) {
  const auto whole = static_cast<long>(std::lround(std::clamp(seconds, 0.0, 359999.0)));
  const long hours = whole / 3600, minutes = whole / 60 % 60;
  if (hours > 0) return fmt::format("{}:{:02}:{:02}", hours, minutes, whole % 60);
  return fmt::format("{}:{:02}", minutes, whole % 60);
}

std::string progress_line(const Progress& progress, double wall_time, int columns) {
  const double share = std::clamp(progress.share, 0.0, 1.0);
  const bool known = share >= 0.01 && wall_time >= 0.25;
  const std::string left = known ? clock_text(wall_time * (1 - share) / share) : "-:--";
  const std::string factor =
      wall_time > 0 ? fmt::format("{:.0f}x real time",
                                  (progress.simulated_time - progress.first_time) / wall_time)
                    : "";
  // Rounded down: 100 % only when it is done.
  const std::string metres =
      progress.length > 0 ? fmt::format("  {:.2f}/{:.2f} m", progress.drawn, progress.length) : "";
  std::string line =
      fmt::format("{} {:6.1f} s  stroke {}/{}{}  {:3.0f} %  {} left  {}",
                  progress.again ? "again  " : "drawing", progress.simulated_time, progress.stroke,
                  progress.strokes, metres, std::floor(100 * share), left, factor);
  if (progress.waits_for)
    line = fmt::format("waiting {:6.1f} s  for {}, for {:.0f} s", progress.simulated_time,
                       progress.waits_for, progress.waited);
  if (line.size() > static_cast<std::size_t>(std::max(columns, 0)))
    line.resize(static_cast<std::size_t>(std::max(columns, 0)));
  return line;
}

std::string step_line(const std::string& what, double share, double wall_time) {
  share = std::clamp(share, 0.0, 1.0);
  const bool known = share >= 0.01 && wall_time >= 0.25;
  return fmt::format("{}  {:3.0f} %  {} left", what, std::floor(100 * share),
                     known ? clock_text(wall_time * (1 - share) / share) : "-:--");
}

ProgressLine::ProgressLine(std::FILE* out, std::optional<bool> shown, Clock::time_point start)
    : out_(out), shown_(shown.value_or(isatty(fileno(out)) == 1)), start_(start), next_(start) {}

ProgressLine::~ProgressLine() { wipe(); }

void ProgressLine::draw(const Progress& progress, Clock::time_point now) {
  // One column less than available: a full line would wrap on some terminals.
  if (due(now))
    put(progress_line(progress, std::chrono::duration<double>(now - start_).count(),
                      columns_of(out_) - 1));
}

void ProgressLine::draw(const std::string& what, double share, Clock::time_point now) {
  if (due(now)) put(step_line(what, share, std::chrono::duration<double>(now - start_).count()));
}

bool ProgressLine::due(Clock::time_point now) {
  if (!shown_ || now < next_) return false;
  next_ = now + pause;
  return true;
}

void ProgressLine::put(const std::string& line) {
  std::fputs(("\r" + line + "\x1b[K").c_str(), out_);
  std::fflush(out_);
  on_screen_ = true;
}

void ProgressLine::wipe() {
  if (!on_screen_) return;
  std::fputs("\r\x1b[K", out_);
  std::fflush(out_);
  on_screen_ = false;
}

}  // namespace impedraw
