#include "impedraw/study/robustness_record.h"

#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "impedraw/metrics/metrics.h"

namespace impedraw {

RecordColumns::RecordColumns(const std::vector<Cell>& all) {
  std::map<std::string, std::set<std::string>> values;
  std::size_t cells = 0;
  std::map<std::string, std::size_t> times;
  for (const Cell& cell : all) {
    ++cells;
    for (const auto& [name, value] : flat_settings(cell_scenario(cell))) {
      values[name].insert(value);
      ++times[name];
    }
  }
  for (const auto& [name, different] : values)
    if (name != "name" && (different.size() > 1 || times[name] < cells)) varied_.push_back(name);

  names_ = {"cell",  "group", "base",  "set",  "failed",
            "cause", "speed", "slope", "push", "realistic"};
  names_.insert(names_.end(), varied_.begin(), varied_.end());
  for (const MetricDefinition& m : metric_definitions()) names_.push_back(m.name);
  names_.push_back("wall_time");
}

Record RecordColumns::settings(const Cell& cell) const {
  const Scenario scenario = cell_scenario(cell);
  Record record = {{"cell", cell.name},
                   {"group", cell.group},
                   {"base", cell.base},
                   {"speed", fmt::format("{:.6g}", 1e3 * scenario.path.draw_speed)},
                   {"push", number_text(scenario.control.normal_force)},
                   {"realistic", cell.realistic ? "1" : "0"}};
  for (const std::string& assignment : cell.assignments)
    record["set"] += (record["set"].empty() ? "" : "; ") + assignment;
  const auto flat = flat_settings(scenario);
  for (const std::string& name : varied_)
    if (const auto it = flat.find(name); it != flat.end()) record[name] = it->second;
  return record;
}

Record RecordColumns::record(const Cell& cell, const CellResult& result) const {
  Record record = settings(cell);
  record["failed"] = result.cause.empty() ? "0" : "1";
  record["cause"] = result.cause;
  record["slope"] = result.slope;
  record["wall_time"] = fmt::format("{:.2f}", result.wall_time);
  for (const MetricDefinition& m : metric_definitions()) {
    if (const auto value = result.metrics.find(m.name); value != result.metrics.end())
      record[m.name] = fmt::format("{:.6g}", value->second);
  }
  return record;
}

bool RecordColumns::same_settings(const Record& line, const Cell& cell) const {
  const Record desired = settings(cell);
  for (const char* name : {"cell", "group", "base", "set", "realistic"})
    if (field(line, name) != field(desired, name)) return false;
  return std::all_of(varied_.begin(), varied_.end(), [&](const std::string& name) {
    return field(line, name) == field(desired, name);
  });
}

}  // namespace impedraw
