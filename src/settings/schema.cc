#include "impedraw/settings/schema.h"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

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

Fields& Fields::add(std::string name, std::string help, std::string unit, Range range,
                    decltype(Setting::value) value) {
  settings_.push_back({std::move(name), std::move(help), std::move(unit), range, std::move(value)});
  return *this;
}

Scalar Fields::word(const Words& words, std::function<void(std::size_t)> set,
                    std::function<std::size_t()> get) {
  auto take = [words, set](std::string_view text) -> std::optional<std::string> {
    const auto at = std::ranges::find(words, text);
    if (at == words.end()) return not_among(text, words);
    set(static_cast<std::size_t>(at - words.begin()));
    return std::nullopt;
  };
  return {take, [words, get] { return words.at(get()); },
          fmt::format("{}", fmt::join(words, " | ")), Scalar::Kind::word, words};
}

Fields& Fields::field(std::string name, bool& value, std::string help) {
  auto set = [&value](std::size_t i) { value = i == 0; };
  Scalar scalar = word({"true", "false"}, set, [&value] { return value ? 0u : 1u; });
  scalar.words.clear();  // which a choice has
  return add(std::move(name), std::move(help), "", Range::any(), std::move(scalar));
}

Fields& Fields::field(std::string name, std::string& value, std::string help) {
  return add(std::move(name), std::move(help), "", Range::any(), plain_word(value));
}

Fields& Fields::field(std::string name, std::filesystem::path& value, std::string help) {
  auto take = [&value](std::string_view text) {
    return value = text, std::optional<std::string>();
  };
  return add(std::move(name), std::move(help), "", Range::any(),
             Scalar{take, [&value] { return value.string(); }, "path", Scalar::Kind::path});
}

}  // namespace impedraw
