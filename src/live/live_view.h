// ./impedraw draw --live: a run's page on 127.0.0.1, fed from the control loop.
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "impedraw/experiment/experiment.h"
#include "impedraw/run/run.h"

namespace impedraw {

class LiveServer;

struct LiveOptions {
  bool show = false;
  int port = 0;       // 0: a free one
  double pace = 0.0;  // seconds of the run a second; 0: as fast as it goes
};

// Gives the loop hooks that never wait for a viewer. A row is handed over each kLiveSpacing of the
// run, or a 30,000th of a longer plan.
inline constexpr double kLiveSpacing = 0.01;  // [s]

class LiveView {
 public:
  explicit LiveView(const LiveOptions& options);
  ~LiveView();
  LiveView(const LiveView&) = delete;
  LiveView& operator=(const LiveView&) = delete;

  std::string address() const;  // empty: nothing is shown
  LiveServer* server() { return server_.get(); }

  // Answers from now on. The experiment is read only here. Throws InputError if the port cannot be
  // had.
  void begin(const Experiment& experiment, const std::string& command);

  // For draw_into(); refer to this.
  RunHooks hooks();

  // Shows the finished report to those who watch.
  void finish(const std::filesystem::path& report);

 private:
  class Feed;
  LiveOptions options_;
  std::unique_ptr<LiveServer> server_;
  std::unique_ptr<Feed> feed_;
  double first_ = -1.0;  // driver time from which the run is paced; < 0: from the next step on [s]
};

}  // namespace impedraw
