#include "app/robustness_record.h"

#include <algorithm>
#include <fstream>
#include <set>
#include <sstream>

#include <fmt/format.h>

#include "report/metrics.h"

namespace impedraw {

namespace {

std::string joined_to(const std::string& head, const std::string& name) { return head.empty() ? name : head + "." + name; }

void flatten(const std::string& name, const Setting& setting, std::map<std::string, std::string>* flat) {
  if (const auto* group = std::get_if<Group>(&setting.value)) {
    for (const Setting& field : group->fields) flatten(joined_to(name, field.name), field, flat);
  } else if (const auto* list = std::get_if<List>(&setting.value)) {
    (*flat)[name] = fmt::format("{} entries", list->size());
    for (std::size_t i = 0; i < list->size(); ++i) flatten(joined_to(name, std::to_string(i)), list->element(i), flat);
  } else if (const auto* optional = std::get_if<Optional>(&setting.value)) {
    if (optional->engaged()) flatten(name, optional->value(), flat);
    else (*flat)[name] = "null";
  } else if (const auto* numbers = std::get_if<Numbers>(&setting.value)) {
    std::vector<std::string> words;
    for (int i = 0; i < numbers->size; ++i) words.push_back(number_text(numbers->data[i]));
    (*flat)[name] = fmt::format("[{}]", joined(words));
  } else {
    (*flat)[name] = std::get<Scalar>(setting.value).text();
  }
}

std::string field_text(std::string text) {
  std::replace(text.begin(), text.end(), '\n', ' ');
  std::replace(text.begin(), text.end(), '\r', ' ');
  if (text.find_first_of(",\"[") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"') fields.back() += line[++i];
    else if (c == '"') quoted = !quoted;
    else if (c == ',' && !quoted) fields.emplace_back();
    else fields.back() += c;
  }
  return fields;
}

}  // namespace

std::map<std::string, std::string> flat_settings(Scenario scenario) {
  std::map<std::string, std::string> flat;
  const Group group = described(scenario);
  for (const Setting& field : group.fields) flatten(field.name, field, &flat);
  return flat;
}

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

  names_ = {"cell", "group", "base", "set", "failed", "cause", "speed", "slope", "push", "realistic"};
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
                   {"push", number_text(scenario.control.push_force)},
                   {"realistic", cell.realistic ? "1" : "0"}};
  for (const std::string& assignment : cell.assignments) record["set"] += (record["set"].empty() ? "" : "; ") + assignment;
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
    const auto value = result.metrics.is_object() ? result.metrics.find(m.name) : result.metrics.end();
    if (value != result.metrics.end() && value->is_number()) record[m.name] = fmt::format("{:.6g}", value->get<double>());
  }
  return record;
}

bool RecordColumns::same_settings(const Record& line, const Cell& cell) const {
  const auto at = [](const Record& r, const std::string& name) {
    const auto it = r.find(name);
    return it == r.end() ? std::string() : it->second;
  };
  const Record wanted = settings(cell);
  for (const char* name : {"cell", "group", "base", "set", "realistic"})
    if (at(line, name) != at(wanted, name)) return false;
  return std::all_of(varied_.begin(), varied_.end(), [&](const std::string& name) { return at(line, name) == at(wanted, name); });
}

std::string RecordColumns::line(const Record& record) const {
  std::vector<std::string> fields;
  for (const std::string& name : names_) {
    const auto it = record.find(name);
    fields.push_back(it == record.end() ? "" : it->second);
  }
  return csv_line(fields);
}

std::string csv_line(const std::vector<std::string>& fields) {
  std::string line;
  for (std::size_t i = 0; i < fields.size(); ++i) line += (i == 0 ? "" : ",") + field_text(fields[i]);
  return line + "\n";
}

std::vector<Record> read_csv(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::vector<Record> records;
  std::vector<std::string> names;
  for (std::string line; std::getline(in, line) && !in.eof();) {  // at the end of the file: a line that was cut off
    const std::vector<std::string> fields = fields_of(line);
    if (names.empty()) {
      names = fields;
    } else if (fields.size() == names.size()) {
      Record record;
      for (std::size_t i = 0; i < names.size(); ++i) record[names[i]] = fields[i];
      records.push_back(record);
    }
  }
  return records;
}

}  // namespace impedraw
