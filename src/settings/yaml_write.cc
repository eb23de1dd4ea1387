#include "impedraw/settings/yaml_write.h"

#include <algorithm>

namespace impedraw {

namespace {

constexpr std::size_t comment_column = 36;

std::string text_of(const Scalar& scalar) {
  return scalar.kind == Scalar::Kind::word ? scalar.text() : yaml_string(scalar.text());
}

std::string text_of(const Numbers& numbers) {
  std::vector<std::string> words;
  for (int i = 0; i < numbers.size; ++i) words.push_back(number_text(numbers.data[i]));
  return "[" + joined(words) + "]";
}

// One line: "key: value   # unit: meaning".
void put_line(std::string& yaml, std::string line, const Setting& setting) {
  std::string comment = setting.unit;
  if (!setting.help.empty()) comment += (comment.empty() ? "" : ": ") + setting.help;
  std::replace(comment.begin(), comment.end(), '\n', ' ');
  if (!comment.empty()) {
    line.resize(std::max(line.size() + 2, comment_column), ' ');
    line += "# " + comment;
  }
  yaml += line + "\n";
}

void put(std::string& yaml, const std::string& head, std::size_t indent, const Setting& setting,
         const Setting& described_by);

void put_group(std::string& yaml, std::string head, std::size_t indent, const Group& group) {
  for (const Setting& field : group.fields) {
    put(yaml, head + field.name + ":", indent, field, field);
    head = std::string(indent, ' ');  // only the first line of an element has a dash
  }
}

void put_list(std::string& yaml, const std::string& head, std::size_t indent, const List& list,
              const Setting& described_by) {
  std::vector<std::string> words;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Setting element = list.element(i);
    if (const auto* scalar = std::get_if<Scalar>(&element.value)) words.push_back(text_of(*scalar));
  }
  if (words.size() == list.size())
    return put_line(yaml, head + " [" + joined(words) + "]", described_by);
  put_line(yaml, head, described_by);
  for (std::size_t i = 0; i < list.size(); ++i)
    put_group(yaml, std::string(indent + 2, ' ') + "- ", indent + 4,
              std::get<Group>(list.element(i).value));
}

// `described_by` has the unit and the meaning, which an optional's value lacks.
void put(std::string& yaml, const std::string& head, std::size_t indent, const Setting& setting,
         const Setting& described_by) {
  if (const auto* group = std::get_if<Group>(&setting.value)) {
    if (group->fields.empty()) return;  // constants alone
    put_line(yaml, head, described_by);
    put_group(yaml, std::string(indent + 2, ' '), indent + 2, *group);
  } else if (const auto* list = std::get_if<List>(&setting.value)) {
    put_list(yaml, head, indent, *list, described_by);
  } else if (const auto* optional = std::get_if<Optional>(&setting.value)) {
    if (optional->engaged())
      put(yaml, head, indent, optional->value(), described_by);
    else
      put_line(yaml, head + " null", described_by);
  } else if (const auto* numbers = std::get_if<Numbers>(&setting.value)) {
    put_line(yaml, head + " " + text_of(*numbers), described_by);
  } else {
    put_line(yaml, head + " " + text_of(std::get<Scalar>(setting.value)), described_by);
  }
}

}  // namespace

std::string yaml_text(const Group& settings) {
  std::string yaml;
  put_group(yaml, "", 0, settings);
  return yaml;
}

}  // namespace impedraw
