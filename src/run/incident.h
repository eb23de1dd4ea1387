// incident.html: the last two seconds of a run that was stopped, on one page.
#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "impedraw/experiment/scenario.h"
#include "impedraw/log/log.h"
#include "impedraw/run/cycle.h"
#include "impedraw/run/run.h"

namespace impedraw {

// The last kIncidentTime of rows. add() neither allocates nor throws.
class LastSeconds {
 public:
  LastSeconds(double period, const ArmModel& arm);

  // After each cycle.
  void add(const LogRow& row, const Cycle& cycle) noexcept;
  std::vector<IncidentRow> rows() const;  // oldest first

 private:
  ArmLimits limits_;
  std::vector<IncidentRow> ring_;
  std::size_t count_ = 0;  // added so far
};

// Writes incident.html into the run's folder: why the run was stopped, and plots of outcome.last.
// Throws as write_whole() does.
void write_incident(const std::filesystem::path& folder, const Scenario& scenario,
                    const RunOutcome& outcome);

}  // namespace impedraw
