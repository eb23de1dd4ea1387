// Tables as comma-separated lines with a first line of names (RFC 4180): fields with a comma, a
// quote or a bracket stand in quotes, no field has a line break in it.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace impedraw {

using Record = std::map<std::string, std::string>;  // a line, by column

std::string csv_line(const std::vector<std::string>& fields);  // with its line break
std::string csv_line(const std::vector<std::string>& columns,
                     const Record& record);  // empty where the record has nothing

// Reads the lines after the header. Skips truncated lines and lines with a wrong number of fields.
std::vector<Record> read_csv(const std::filesystem::path& file);

std::string field(const Record& record, const std::string& column);  // empty where there is none

}  // namespace impedraw
