#include "app/robustness_run.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <list>
#include <stdexcept>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "app/experiment.h"
#include "app/run.h"
#include "app/wall_time.h"
#include "common/errors.h"
#include "report/metrics.h"
#include "report/run_data.h"

namespace impedraw {

namespace {

namespace fs = std::filesystem;

double steepest_slope_deg(const Experiment& e) {
  double least = 1.0;
  for (const Eigen::Vector3d& p_W : e.target.points) least = std::min(least, e.canvas->closest(p_W).n_W.z());
  return std::acos(std::clamp(least, -1.0, 1.0)) * 180.0 / M_PI;
}

double value_of(const nlohmann::ordered_json& metrics, const char* name) {
  const auto& value = metrics.at(name);
  return value.is_number() ? value.get<double>() : std::nan("");
}

std::string failure(const RunOutcome& outcome, const nlohmann::ordered_json& metrics, double speed) {
  const double missed = value_of(metrics, "strokes_missed"), contact = value_of(metrics, "contact_fraction");
  const double astray = value_of(metrics, "ink_outside");
  const double reached = value_of(metrics, "speed_mean") / (1e3 * speed);
  if (outcome.end != RunEnd::finished) return "stopped: " + outcome.cause;
  if (!(missed == 0.0)) return fmt::format("missed: {:.0f} strokes without ink", missed);
  if (!(contact >= kLeastContact)) return fmt::format("contact: ink in {:.1f} % of the pen-down samples", 100.0 * contact);
  if (!(astray <= kMostAstray)) return fmt::format("astray: {:.1f} % of the ink's length over 1 mm from its target", 100.0 * astray);
  if (!(reached >= kLeastSpeed)) return fmt::format("slow: {:.1f} % of the speed asked for", 100.0 * reached);
  return {};
}

// The tree's own files by their names in it: a table is to be the same wherever it was made.
std::string within_tree(std::string text) {
  const std::string root = std::string(IMPEDRAW_ROOT) + "/";
  for (std::size_t at = text.find(root); at != std::string::npos; at = text.find(root)) text.erase(at, root.size());
  return text;
}

struct Child {
  const Cell* cell;
  pid_t pid;
  int from;  // its result, as JSON
  fs::path log;
  Clock::time_point start;
  std::string text;
};

// A child's whole life: what libraries print does not disturb the progress line, and it does not outlive its parent.
[[noreturn]] void live(const Cell& cell, const fs::path& log, int to, pid_t parent) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(1);
  const int nowhere = open("/dev/null", O_WRONLY);
  dup2(nowhere, STDOUT_FILENO);
  dup2(nowhere, STDERR_FILENO);
  const CellResult result = run_cell(cell, log);
  const nlohmann::json whole = {{"cause", result.cause}, {"metrics", result.metrics}, {"slope", result.slope}};
  const std::string text = whole.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  for (std::size_t sent = 0; sent < text.size();) {
    const ssize_t n = write(to, text.data() + sent, text.size() - sent);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) _exit(1);
    sent += static_cast<std::size_t>(n);
  }
  _exit(0);  // no atexit: what the parent has open is the parent's to flush
}

// The children that run; those that still do when it goes are killed.
class Children {
 public:
  ~Children() {
    for (Child& child : running_) kill_and_wait(child);
  }

  void start(const Cell& cell, const fs::path& log) {
    std::array<int, 2> ends;
    if (pipe2(ends.data(), O_CLOEXEC) != 0) throw std::runtime_error(fmt::format("no pipe can be made: {}", std::strerror(errno)));
    const pid_t parent = getpid(), pid = fork();
    if (pid == 0) live(cell, log, ends[1], parent);
    close(ends[1]);
    if (pid < 0) {
      close(ends[0]);
      throw std::runtime_error(fmt::format("no process can be started: {}", std::strerror(errno)));
    }
    running_.push_back({&cell, pid, ends[0], log, Clock::now(), {}});
  }

  int count() const { return static_cast<int>(running_.size()); }

  // Waits a while for results; hands over each child that has ended or that is over its time.
  void wait(double time_limit, const std::function<void(const Cell&, const CellResult&)>& finished) {
    std::vector<pollfd> ends;
    for (const Child& child : running_) ends.push_back({child.from, POLLIN, 0});
    if (poll(ends.data(), ends.size(), 200) < 0 && errno != EINTR) throw std::runtime_error("poll: " + std::string(std::strerror(errno)));
    std::size_t i = 0;
    for (auto child = running_.begin(); child != running_.end(); ++i) {
      const bool heard = ends[i].revents != 0, late = seconds_since(child->start) > time_limit;
      if ((heard && !read_some(*child)) || late) {
        const CellResult result = end(*child, late, time_limit);
        const Cell& cell = *child->cell;
        child = running_.erase(child);
        finished(cell, result);
      } else {
        ++child;
      }
    }
  }

 private:
  static bool read_some(Child& child) {
    std::array<char, 4096> block;
    const ssize_t n = read(child.from, block.data(), block.size());
    if (n > 0) child.text.append(block.data(), static_cast<std::size_t>(n));
    return n > 0 || (n < 0 && errno == EINTR);
  }

  static int kill_and_wait(Child& child) {
    kill(child.pid, SIGKILL);
    return await(child);
  }

  static int await(Child& child) {
    int status = 0;
    while (waitpid(child.pid, &status, 0) < 0 && errno == EINTR) {
    }
    close(child.from);
    std::error_code ignored;
    fs::remove(child.log, ignored);
    return status;
  }

  static CellResult end(Child& child, bool late, double time_limit) {
    CellResult result;
    result.wall_time = seconds_since(child.start);
    const int status = late ? kill_and_wait(child) : await(child);
    const nlohmann::json whole = nlohmann::json::parse(child.text, nullptr, false);
    if (late) {
      result.cause = fmt::format("timeout: took longer than {:.0f} s", time_limit);
    } else if (!whole.is_object()) {
      result.cause = WIFSIGNALED(status) ? fmt::format("crashed: signal {}", WTERMSIG(status)) : "crashed: no result";
    } else {
      result.cause = whole.at("cause").get<std::string>();
      result.metrics = whole.at("metrics");
      result.slope = whole.at("slope").get<std::string>();
    }
    return result;
  }

  std::list<Child> running_;
};

}  // namespace

CellResult run_cell(const Cell& cell, const fs::path& log) {
  CellResult result;
  const auto start = Clock::now();
  try {
    Places places;
    const Scenario scenario = cell_scenario(cell, &places);
    Experiment experiment = prepare(scenario, places);
    result.slope = fmt::format("{:.1f}", steepest_slope_deg(experiment));
    const RunOutcome outcome = run(experiment, log, seconds_since(start));
    const nlohmann::ordered_json metrics = compute_metrics(read_run(log));
    result.cause = failure(outcome, metrics, experiment.scenario.path.draw_speed);
    result.metrics = metrics;
  } catch (const InputError& error) {
    result.cause = "refused: " + within_tree(error.what());
  } catch (const std::exception& error) {
    result.cause = "error: " + within_tree(error.what());
  }
  std::error_code ignored;
  fs::remove(log, ignored);
  result.wall_time = seconds_since(start);
  return result;
}

bool run_cells(const std::vector<Cell>& cells, const CellRunSettings& settings, const CellRunHooks& hooks) {
  Children children;
  std::size_t next = 0;
  while (next < cells.size() || children.count() > 0) {
    if (hooks.interrupted && hooks.interrupted()) return false;
    while (next < cells.size() && children.count() < settings.jobs) {
      children.start(cells[next], settings.scratch / fmt::format(".cell-{}-{}.h5", getpid(), next));
      ++next;
    }
    children.wait(settings.time_limit, hooks.finished);
    if (hooks.waiting) hooks.waiting();
  }
  return true;
}

}  // namespace impedraw
