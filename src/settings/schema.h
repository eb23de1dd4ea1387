// Describes settings once. One description of a struct yields its YAML reader, --set, the resolved
// YAML and the documentation.
//
//   enum class Sensor { none, truth };
//   struct PushSettings {
//     double force = 5;
//     struct Limits {
//       static constexpr Limit force = {"force", "N", {0, 50}};
//     };
//     Sensor sensor = Sensor::none;
//     std::optional<double> stop_at;
//   };
//   struct Scenario {
//     PushSettings push;
//     std::vector<CameraSettings> cameras;
//     std::filesystem::path svg;
//   };
//
//   void describe(Fields& f, PushSettings& s) {
//     f.field(PushSettings::Limits::force, s.force, "desired normal force");
//     f.choice("sensor", s.sensor, {"none", "true"}, "source of the wrench");
//     f.field("stop_at", s.stop_at, Range::at_least(0), "s",
//             "end of the run; absent: when the drawing is done");
//   }
//   void describe(Fields& f, Scenario& s) {
//     f.field("push", s.push, "the push along the normal");
//     f.field("cameras", s.cameras, "depth cameras");
//     f.field("svg", s.svg, "artwork");
//   }
//
// describe() belongs to the struct's namespace. The struct's initialisers are the only defaults. A
// field is one of
//   a number with a Limit, or with a name, a Range and a unit: double, any integer,
//     Eigen::Matrix<double, N, 1>, Eigen::VectorXd (of its default's length), or std::optional or
//     std::vector of a number. Limits apply to every component; NaN and inf are never valid;
//   bool, std::string, std::filesystem::path;
//   choice(): an enum, written by name, or std::optional of one; its values' names in the enum's
//     order, which counts from 0;
//   a struct with its own describe(), or std::optional or std::vector of one.
// A renamed setting or word of a choice keeps its old name as an alias:
//   f.field("normal_force", s.force, ...).formerly("push");
//   f.choice("sensor", s.sensor, ...).formerly("true", "ground_truth");
// A setting for users of the program, rather than experts on the arm: f.field(...).for_users(); A
// former setting that is a constant keeps its name, so that files with that value load and others
// are refused by name:
//   f.constant("fold_height", s.fold_height, {1e-6, 0.1}, "m");
// A list that may be given as one value: f.field("speeds", s.speeds, ...).or_one();
// A path in a file is relative to the file's folder; in --set, to the working directory. An empty
// path stays empty.
#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "impedraw/settings/settings_text.h"

namespace impedraw {

struct Setting;
class Fields;
using Words = std::vector<std::string>;

// The kinds of setting. Each alternative refers into the described object, which must outlive it.

// One word or number. take() stores the text's value, or leaves the value unchanged and returns the
// fault ("is not a number").
struct Scalar {
  std::function<std::optional<std::string>(std::string_view text)> take;
  std::function<std::string()> text;
  std::string type;  // for the documentation: "number", "none | true"
  // Text and paths are quoted if YAML requires it; paths are made absolute.
  enum class Kind { word, text, path } kind = Kind::word;
  Words words{};  // the valid words of a choice
  // Former and current names of a choice's words.
  std::vector<std::pair<std::string, std::string>> former_words{};
};

struct Numbers {  // a fixed count of doubles
  double* data;
  int size;
  Range range;
  std::string unit;
};

// A former setting, and the value that it has as a constant.
struct ConstantSetting {
  std::string name, value, unit;
};

struct Group {  // a nested struct
  std::vector<Setting> fields;
  std::vector<ConstantSetting> constants{};
};

struct Optional {
  std::function<bool()> engaged;
  std::function<void(bool)> engage;  // true: emplaces a default value if there is none
  std::function<Setting()> value;    // call only if engaged
};

struct List {
  std::function<std::size_t()> size;
  std::function<void(std::size_t)> resize;  // new elements have their defaults
  std::function<Setting(std::size_t)> element;
  // a default element, for the documentation
  std::function<std::pair<std::shared_ptr<void>, Setting>()> sample;
  bool or_one = false;  // one element may stand without brackets
};

struct Setting {
  std::string name;  // empty for an element of a list
  std::string help;
  std::string unit;
  Range range = Range::any();
  std::variant<Scalar, Numbers, Group, Optional, List> value;
  // still accepted, with a note that gives the current name
  std::vector<std::string> former_names{};
  bool for_users = false;
};

template <class T>
concept Described = requires(Fields& f, T& t) {
  describe(f, t);
};

template <class T>
concept Number = std::is_same_v<T, double> ||(std::is_integral_v<T> && !std::is_same_v<T, bool>);

// Collects the settings that describe() declares.
class Fields {
 public:
  template <Number T>
  Fields& field(std::string name, T& value, Range range, std::string unit, std::string help) {
    return add(std::move(name), std::move(help), unit, range, number(value, range, unit));
  }
  template <int N>
  Fields& field(std::string name, Eigen::Matrix<double, N, 1>& value, Range range, std::string unit,
                std::string help) {
    return add(std::move(name), std::move(help), unit, range,
               Numbers{value.data(), static_cast<int>(value.size()), range, unit});
  }
  template <Number T>
  Fields& field(std::string name, std::optional<T>& value, Range range, std::string unit,
                std::string help) {
    auto inner = [&value, range, unit] {
      return Setting{"", "", unit, range, number(*value, range, unit)};
    };
    return add(std::move(name), std::move(help), unit, range, optional(value, inner));
  }
  template <int N>
  Fields& field(std::string name, std::optional<Eigen::Matrix<double, N, 1>>& value, Range range,
                std::string unit, std::string help) {
    auto inner = [&value, range, unit] {
      return Setting{"", "", unit, range, Numbers{value->data(), N, range, unit}};
    };
    return add(std::move(name), std::move(help), unit, range, optional(value, inner));
  }
  template <Number T>
  Fields& field(std::string name, std::vector<T>& value, Range range, std::string unit,
                std::string help) {
    auto element = [range, unit](T& t) {
      return Setting{"", "", unit, range, number(t, range, unit)};
    };
    return add(std::move(name), std::move(help), unit, range, list(value, element));
  }

  // The same with name, range and unit of the limit.
  template <class T>
  Fields& field(const Limit& limit, T& value, std::string help) {
    return field(std::string(limit.name), value, limit.range, std::string(limit.unit),
                 std::move(help));
  }

  Fields& field(std::string name, bool& value, std::string help);
  Fields& field(std::string name, std::string& value, std::string help);
  Fields& field(std::string name, std::filesystem::path& value, std::string help);

  template <class E>
  requires std::is_enum_v<E> Fields& choice(std::string name, E& value, const Words& words,
                                            std::string help) {
    return add(std::move(name), std::move(help), "", Range::any(), word(value, words));
  }
  template <class E>
  requires std::is_enum_v<E> Fields& choice(std::string name, std::optional<E>& value,
                                            const Words& words, std::string help) {
    auto inner = [&value, words] { return Setting{"", "", "", Range::any(), word(*value, words)}; };
    return add(std::move(name), std::move(help), "", Range::any(), optional(value, inner));
  }

  template <Described T>
  Fields& field(std::string name, T& value, std::string help) {
    return add(std::move(name), std::move(help), "", Range::any(), group(value));
  }
  template <Described T>
  Fields& field(std::string name, std::optional<T>& value, std::string help) {
    auto inner = [&value] { return Setting{"", "", "", Range::any(), group(*value)}; };
    return add(std::move(name), std::move(help), "", Range::any(), optional(value, inner));
  }
  template <Described T>
  Fields& field(std::string name, std::vector<T>& value, std::string help) {
    auto element = [](T& t) { return Setting{"", "", "", Range::any(), group(t)}; };
    return add(std::move(name), std::move(help), "", Range::any(), list(value, element));
  }

  // Adds a former name of the last setting, or of a word of that choice.
  Fields& formerly(std::string name) {
    settings_.back().former_names.push_back(std::move(name));
    return *this;
  }
  Fields& formerly(std::string word, std::string now) {
    std::get<Scalar>(settings_.back().value)
        .former_words.emplace_back(std::move(word), std::move(now));
    return *this;
  }

  // The last setting belongs to the users' tier.
  Fields& for_users() {
    settings_.back().for_users = true;
    return *this;
  }
  template <class T>
  void constant(std::string name, const T& value, const Range& = Range::any(),
                std::string unit = "") {
    std::string text;
    if constexpr (std::is_same_v<T, bool>) {
      text = value ? "true" : "false";
    } else if constexpr (std::is_same_v<T, std::string_view>) {
      text = value;
    } else if constexpr (requires { value.size(); }) {
      Words numbers;
      for (const double x : value) numbers.push_back(number_text(x));
      text = "[" + joined(numbers) + "]";
    } else {
      text = number_text(value);
    }
    constants_.push_back({std::move(name), std::move(text), std::move(unit)});
  }

  // The last setting is a list, and may be given as one value: 0.1 for [0.1].
  Fields& or_one() {
    std::get<List>(settings_.back().value).or_one = true;
    return *this;
  }

  Group take() && { return {std::move(settings_), std::move(constants_)}; }

 private:
  Fields& add(std::string name, std::string help, std::string unit, Range range,
              decltype(Setting::value) value);

  template <Number T>
  static Scalar number(T& value, Range range, const std::string& unit) {
    auto take = [&value, range, unit](std::string_view text) {
      return parse_number(text, range, unit, value);
    };
    return {take, [&value] { return number_text(value); },
            std::is_same_v<T, double> ? "number" : "whole number"};
  }
  template <class E>
  static Scalar word(E& value, const Words& words) {
    auto set = [&value](std::size_t i) { value = static_cast<E>(i); };
    return word(words, set, [&value] { return static_cast<std::size_t>(value); });
  }
  static Scalar word(const Words& words, std::function<void(std::size_t)> set,
                     std::function<std::size_t()> get);
  template <Described T>
  static Group group(T& value) {
    Fields fields;
    describe(fields, value);
    return std::move(fields).take();
  }
  template <class T>
  static Optional optional(std::optional<T>& value, std::function<Setting()> inner) {
    auto engage = [&value](bool on) {
      on ? void(value ? 0 : (value.emplace(), 0)) : value.reset();
    };
    return {[&value] { return value.has_value(); }, engage, std::move(inner)};
  }
  template <class T, class Element>
  static List list(std::vector<T>& value, Element element) {
    auto sample = [element] {
      auto t = std::make_shared<T>();
      Setting setting = element(*t);
      return std::pair<std::shared_ptr<void>, Setting>(t, std::move(setting));
    };
    return {[&value] { return value.size(); }, [&value](std::size_t n) { value.resize(n); },
            [&value, element](std::size_t i) { return element(value[i]); }, sample, false};
  }

  std::vector<Setting> settings_;
  std::vector<ConstantSetting> constants_;
};

// The description of a whole struct, bound to it.
template <Described T>
Group described(T& value) {
  Fields fields;
  describe(fields, value);
  return std::move(fields).take();
}

}  // namespace impedraw
