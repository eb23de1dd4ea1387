// The results of the force benchmark, as data (force.json) and as a page.
#pragma once

#include <string>
#include <vector>

#include "impedraw/judge/force_case.h"
#include "impedraw/judge/force_trial.h"

namespace impedraw {

struct JudgedRun {
  int seed = 1;
  ForceMetrics metrics;  // absent where it ended early
  ForceRun run;
};

// One metric over the runs of a case. Absent where one of them lacks it.
struct ForceSummary {
  std::optional<double> mean, worst;
  int lacking = 0;  // runs without it
};

struct JudgedController {
  ForceController controller;
  std::vector<JudgedRun> runs;

  ForceSummary summary(int metric) const;
};

struct JudgedCase {
  ForceCase what;
  std::vector<JudgedController> controllers;
};

struct ForceResults {
  std::string arm;        // the arm's name
  std::string driver;     // who moves it: sim, iiwa-lcm, franka
  bool simulated = true;  // an arm on a wall clock is not
  std::string again;      // the command that makes them
  int runs = 5;           // of each case, as asked for
  double seconds = 0;     // wall time
  std::string ended;      // why not all was run; empty: it was
  std::vector<JudgedCase> cases;
  std::vector<std::string> left_out;  // cases that this arm's workpiece does not allow
};

// A case in which this program's controller is behind a peer, by the mean over the runs.
struct ForceBehind {
  std::string name;  // of the case
  int metric;
  ForceController peer;
  std::optional<double> ours, theirs;
};
std::vector<ForceBehind> behind(const ForceResults& results);

std::string force_json(const ForceResults& results);
std::string force_page(const ForceResults& results);
// The table of docs/force.md.
std::string force_markdown(const ForceResults& results);

// "0.21 s", "12 %"; "–" for none.
std::string shown_metric(int metric, const std::optional<double>& value);

}  // namespace impedraw
