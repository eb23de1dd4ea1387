#include "impedraw/study/cell.h"

#include <fmt/format.h>

#include "impedraw/experiment/draw_options.h"

namespace impedraw {

namespace {

std::string joined_to(const std::string& head, const std::string& name) {
  return head.empty() ? name : head + "." + name;
}

void flatten(const std::string& name, const Setting& setting,
             std::map<std::string, std::string>* flat) {
  if (const auto* group = std::get_if<Group>(&setting.value)) {
    for (const Setting& field : group->fields) flatten(joined_to(name, field.name), field, flat);
  } else if (const auto* list = std::get_if<List>(&setting.value)) {
    (*flat)[name] = fmt::format("{} entries", list->size());
    for (std::size_t i = 0; i < list->size(); ++i)
      flatten(joined_to(name, std::to_string(i)), list->element(i), flat);
  } else if (const auto* optional = std::get_if<Optional>(&setting.value)) {
    if (optional->engaged())
      flatten(name, optional->value(), flat);
    else
      (*flat)[name] = "null";
  } else if (const auto* numbers = std::get_if<Numbers>(&setting.value)) {
    std::vector<std::string> words;
    for (int i = 0; i < numbers->size; ++i) words.push_back(number_text(numbers->data[i]));
    (*flat)[name] = fmt::format("[{}]", joined(words));
  } else {
    (*flat)[name] = std::get<Scalar>(setting.value).text();
  }
}

}  // namespace

Scenario cell_scenario(const Cell& cell, Places* places) {
  DrawOptions options;
  options.scenario = std::filesystem::path(IMPEDRAW_ROOT) / cell.base;
  if (!cell.svg.empty()) options.svg = std::filesystem::path(IMPEDRAW_ROOT) / cell.svg;
  options.assignments = cell.assignments;
  return resolve(options, places);
}

std::string cell_command(const Cell& cell) {
  std::string command = "./impedraw draw " + cell.base;
  if (!cell.svg.empty()) command += " --svg " + cell.svg;
  for (const std::string& assignment : cell.assignments) {
    const char* quote = assignment.find_first_of(" [\\") == std::string::npos ? "" : "'";
    command += fmt::format(" --set {0}{1}{0}", quote, assignment);
  }
  return command;
}

std::map<std::string, std::string> flat_settings(Scenario scenario) {
  std::map<std::string, std::string> flat;
  const Group group = described(scenario);
  for (const Setting& field : group.fields) flatten(field.name, field, &flat);
  return flat;
}

std::string within_tree(std::string text) {
  const std::string root = std::string(IMPEDRAW_ROOT) + "/";
  for (std::size_t at = text.find(root); at != std::string::npos; at = text.find(root))
    text.erase(at, root.size());
  return text;
}

}  // namespace impedraw
