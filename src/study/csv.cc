#include "impedraw/study/csv.h"

#include <algorithm>
#include <fstream>

namespace impedraw {

namespace {

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
    if (c == '"' && quoted && i + 1 < line.size() && line[i + 1] == '"')
      fields.back() += line[++i];
    else if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      fields.emplace_back();
    else
      fields.back() += c;
  }
  return fields;
}

}  // namespace

std::string csv_line(const std::vector<std::string>& fields) {
  std::string line;
  for (std::size_t i = 0; i < fields.size(); ++i)
    line += (i == 0 ? "" : ",") + field_text(fields[i]);
  return line + "\n";
}

std::string csv_line(const std::vector<std::string>& columns, const Record& record) {
  std::vector<std::string> fields;
  for (const std::string& name : columns) fields.push_back(field(record, name));
  return csv_line(fields);
}

std::vector<Record> read_csv(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::vector<Record> records;
  std::vector<std::string> names;
  for (std::string line;
       std::getline(in, line) && !in.eof();) {  // at the end of the file: a line that was cut off
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

std::string field(const Record& record, const std::string& column) {
  const auto it = record.find(column);
  return it == record.end() ? std::string() : it->second;
}

}  // namespace impedraw
