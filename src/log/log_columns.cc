#include "impedraw/log/log_columns.h"

namespace impedraw {

namespace {

// Adds what a visit calls it with, with the shape of the value.
auto adder(std::vector<LogColumn>* columns) {
  return [columns](const char* name, const auto& value, const char* unit, const char* frame,
                   const char* description, const std::string& term = {}) {
    put_value(value, [&](const void*, int width, std::size_t size) {
      columns->push_back({name + term, width, size == sizeof(int), unit, frame,
                          (term.empty() ? "" : "term '" + term + "'") + description});
    });
  };
}

}  // namespace

std::vector<LogColumn> log_columns(const RunLogHeader& header) {
  std::vector<LogColumn> columns;
  const LogRow row(static_cast<int>(header.joint_names.size()));
  visit_row(row, header, adder(&columns));
  return columns;
}

const std::vector<LogColumn>& step_columns(bool moving_canvas) {
  static const auto with_frame = [](const char* canvas) {
    std::vector<LogColumn> columns;
    const LogStep step;
    visit_step(step, canvas, adder(&columns));
    return columns;
  };
  static const std::vector<LogColumn> still = with_frame("world"), moving = with_frame("canvas");
  return moving_canvas ? moving : still;
}

}  // namespace impedraw
