#include "impedraw/settings/schema.h"

namespace impedraw {

namespace {

// A string accepts every text.
Scalar plain_word(std::string& value) {
  auto take = [&value](std::string_view text) {
    return value = text, std::optional<std::string>();
  };
  return {take, [&value] { return value; }, "text", Scalar::Kind::text};
}

}  // namespace

void Fields::add(std::string name, std::string help, std::string unit, Range range,
                 decltype(Setting::value) value) {
  settings_.push_back({std::move(name), std::move(help), std::move(unit), range, std::move(value)});
}

void Fields::field(std::string name, bool& value, std::string help) {
  auto take = [&value](std::string_view text) -> std::optional<std::string> {
    if (text != "true" && text != "false") return not_among(text, {"true", "false"});
    value = text == "true";
    return std::nullopt;
  };
  auto text = [&value] { return std::string(value ? "true" : "false"); };
  add(std::move(name), std::move(help), "", Range::any(), Scalar{take, text, "true | false"});
}

void Fields::field(std::string name, std::string& value, std::string help) {
  add(std::move(name), std::move(help), "", Range::any(), plain_word(value));
}

void Fields::field(std::string name, std::filesystem::path& value, std::string help) {
  auto take = [&value](std::string_view text) {
    return value = text, std::optional<std::string>();
  };
  add(std::move(name), std::move(help), "", Range::any(),
      Scalar{take, [&value] { return value.string(); }, "path", Scalar::Kind::path});
}

}  // namespace impedraw
