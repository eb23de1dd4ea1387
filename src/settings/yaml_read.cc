#include "impedraw/settings/yaml_read.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <set>
#include <sstream>

#include "impedraw/common/errors.h"
#include "impedraw/common/input_file.h"
#include "impedraw/common/printable.h"

namespace impedraw {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t largest_file = 1 << 20;  // bytes; anything larger is the wrong file

[[noreturn]] void wrong(const std::string& place, const std::string& what) {
  throw InputError(place + ": " + what);
}

std::string below(const std::string& name, const std::string& key) {
  return name.empty() ? key : name + "." + key;
}

std::vector<std::string> names_of(const Group& group) {
  std::vector<std::string> names;
  for (const Setting& field : group.fields) names.push_back(field.name);
  return names;
}

bool is_called(const Setting& field, const std::string& name) {
  const auto& former = field.former_names;
  return field.name == name || std::find(former.begin(), former.end(), name) != former.end();
}

// Finds a field by its current or a former name; the end iterator if there is none.
auto find_field(const Group& group, const std::string& key) {
  return std::find_if(group.fields.begin(), group.fields.end(),
                      [&](const Setting& f) { return is_called(f, key); });
}

std::string unknown_key(std::string_view key, const std::string& name, const Group& group) {
  std::vector<std::string> valid = names_of(group), known = valid;
  for (const Setting& field : group.fields)
    known.insert(known.end(), field.former_names.begin(), field.former_names.end());
  std::string hint = "valid here: " + joined(valid);
  if (const auto nearest = nearest_word(key, known)) {
    const std::string& now = find_field(group, *nearest)->name;
    hint = fmt::format("did you mean '{}'{}?", now,
                       now == *nearest ? "" : fmt::format(", formerly '{}'", *nearest));
  }
  return fmt::format("unknown key '{}'{}; {}", shown(key), name.empty() ? "" : " in " + name, hint);
}

// A value, or the numbers of a list, as ConstantSetting has them; empty: neither.
std::string one_line(const YAML::Node& node) {
  if (node.IsScalar()) return node.Scalar();
  if (!node.IsSequence()) return "";
  Words words;
  for (const YAML::Node& entry : node) words.push_back(entry.IsScalar() ? entry.Scalar() : "");
  return "[" + joined(words) + "]";
}

// Returns true if `text` is the value of a setting that has become a constant, as files of earlier
// versions and recorded scenarios may give it; false: there is no such constant. Throws if it is
// another value.
bool is_constant(const Group& group, const std::string& key, std::string_view text,
                 const std::string& name, const std::string& place) {
  const auto found = std::find_if(group.constants.begin(), group.constants.end(),
                                  [&](const ConstantSetting& c) { return c.name == key; });
  if (found == group.constants.end()) return false;
  double given = 0.0, constant = 0.0;
  const bool same = parse_number(found->value, Range::any(), "", constant)
                        ? text == found->value
                        : !parse_number(text, Range::any(), "", given) && given == constant;
  if (!same)
    wrong(place, fmt::format("{} is a constant: {}{}{}", below(name, key), found->value,
                             found->unit.empty() ? "" : " ", found->unit));
  return true;
}

// An index below size, or nullopt.
std::optional<std::size_t> index(std::string_view text, std::size_t size) {
  std::size_t i = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), i);
  if (error != std::errc() || end != text.data() + text.size() || i >= size) return std::nullopt;
  return i;
}

// Reads the nodes of one file or one assignment into settings.
class Reader {
 public:
  Reader(std::string source, bool has_lines, fs::path folder, Places& places)
      : source_(std::move(source)),
        has_lines_(has_lines),
        folder_(std::move(folder)),
        places_(places) {}

  void read(const YAML::Node& node, int line, const Setting& setting, const std::string& name) {
    if (node.Mark().line >= 0) line = node.Mark().line + 1;
    std::visit([&](const auto& value) { read(node, line, value, name); }, setting.value);
  }

  void read(const YAML::Node& node, int line, const Group& group, const std::string& name) {
    if (node.IsNull()) return;  // `push:` without content
    if (!node.IsMap()) {
      wrong(place(line), fmt::format("{} must hold settings of its own: {}",
                                     name.empty() ? "a scenario" : name, joined(names_of(group))));
    }
    std::set<std::string> seen;
    for (const auto& pair : node) {
      const int key_line = pair.first.Mark().line + 1;
      if (!pair.first.IsScalar())
        wrong(place(key_line),
              fmt::format("a key{} is not a word", name.empty() ? "" : " in " + name));
      const std::string& key = pair.first.Scalar();
      const auto field = find_field(group, key);
      const std::string& now = field == group.fields.end() ? key : field->name;
      if (!seen.insert(now).second)
        wrong(place(key_line), fmt::format("{} is given twice{}", shown(below(name, now)),
                                           now == key ? "" : ", here by its former name " + key));
      if (name.empty() && key == "extends" && has_lines_) continue;
      if (is_constant(group, key, one_line(pair.second), name, place(key_line))) continue;
      if (field == group.fields.end()) wrong(place(key_line), unknown_key(key, name, group));
      // Errors use the name that was given.
      read(pair.second, key_line, *field, below(name, key));
      if (now != key) places_.rename(below(name, key), below(name, now), place(key_line));
    }
  }

  void take(std::string_view text, int line, const Scalar& scalar, const std::string& name) {
    for (const auto& [former, now] : scalar.former_words) {
      if (text != former) continue;
      places_.note(name + ": " + former, now, place(line));
      text = now;
      break;
    }
    if (scalar.kind == Scalar::Kind::path && !text.empty() && fs::path(text).is_relative()) {
      scalar.take((fs::absolute(folder_) / text).lexically_normal().string());
    } else if (const auto error = scalar.take(text)) {
      wrong(place(line), name + " " + *error);
    }
    places_.put(name, place(line));
  }

 private:
  std::string place(int line) const {
    return has_lines_ ? fmt::format("{}:{}", source_, line) : source_;
  }

  void read(const YAML::Node& node, int line, const Scalar& scalar, const std::string& name) {
    if (node.IsNull()) wrong(place(line), fmt::format("{} has no value ({})", name, scalar.type));
    if (!node.IsScalar()) {
      wrong(place(line), fmt::format("{} must be one value ({}), not {}", name, scalar.type,
                                     node.IsMap() ? "a map" : "a list"));
    }
    take(node.Scalar(), line, scalar, name);
  }

  void read(const YAML::Node& node, int line, const Numbers& numbers, const std::string& name) {
    if (!node.IsSequence() || node.size() != static_cast<std::size_t>(numbers.size)) {
      const std::string given = node.IsSequence() ? fmt::format(", not {}", node.size()) : "";
      wrong(place(line),
            fmt::format("{} must be a list of {} numbers{}", name, numbers.size, given));
    }
    for (int i = 0; i < numbers.size; ++i)
      read(node[i], line, component(numbers, i), below(name, std::to_string(i)));
    places_.put(name, place(line));
  }

  void read(const YAML::Node& node, int line, const Optional& optional, const std::string& name) {
    optional.engage(!node.IsNull());
    places_.put(name, place(line));
    if (optional.engaged()) read(node, line, optional.value(), name);
  }

  void read(const YAML::Node& node, int line, const List& list, const std::string& name) {
    if (list.or_one && node.IsScalar()) {
      list.resize(1);
      places_.forget(name);
      return read(node, line, list.element(0), name);
    }
    if (!node.IsSequence())
      wrong(place(line),
            fmt::format("{} must be {}a list", name, list.or_one ? "a number or " : ""));
    if (node.size() > most_entries)
      wrong(place(line), fmt::format("{} has {} entries, allowed are at most {}", name, node.size(),
                                     most_entries));
    list.resize(0);
    list.resize(node.size());
    places_.forget(name);
    places_.put(name, place(line));
    for (std::size_t i = 0; i < node.size(); ++i)
      read(node[i], line, list.element(i), below(name, std::to_string(i)));
  }

 public:
  static Setting component(const Numbers& numbers, int i) {
    double& value = numbers.data[i];
    const auto take = [&value, numbers](std::string_view text) {
      return parse_number(text, numbers.range, numbers.unit, value);
    };
    return {"", "", numbers.unit, numbers.range,
            Scalar{take, [&value] { return number_text(value); }, "number"}};
  }

 private:
  std::string source_;
  bool has_lines_;
  fs::path folder_;
  Places& places_;
};

std::string content(const fs::path& file, const std::string& asked_by) {
  const std::string before =
      asked_by.empty() ? file.string() : asked_by + ": extends " + file.string();
  const std::string text = InputFile(file, before).read(largest_file + 1);
  if (text.size() > largest_file) wrong(before, "is larger than 1 MiB, which no scenario is");
  if (!is_utf8(text)) wrong(before, "is not UTF-8 text");
  return text;
}

// Records where a document starts and skips its content.
struct DocumentStart : YAML::EventHandler {
  YAML::Mark mark = YAML::Mark::null_mark();

  void OnDocumentStart(const YAML::Mark& start) override { mark = start; }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark&, YAML::anchor_t) override {}
  void OnAlias(const YAML::Mark&, YAML::anchor_t) override {}
  void OnScalar(const YAML::Mark&, const std::string&, YAML::anchor_t,
                const std::string&) override {}
  void OnSequenceStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                       YAML::EmitterStyle::value) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const YAML::Mark&, const std::string&, YAML::anchor_t,
                  YAML::EmitterStyle::value) override {}
  void OnMapEnd() override {}
};

// Does not use YAML::LoadAll: in a text that begins with a comma its parser consumes nothing and
// returns empty documents endlessly.
void require_one_document(const std::string& text, const std::string& name) {
  std::istringstream stream(text);
  YAML::Parser parser(stream);
  DocumentStart start;
  for (int last = -1; parser.HandleNextDocument(start); last = start.mark.pos) {
    if (last == start.mark.pos)
      throw YAML::ParserException(start.mark, "a value cannot begin like this");
    if (last >= 0) wrong(name, "holds more than one YAML document");
  }
}

// YAML has no control characters; yaml-cpp takes a zero for its escape character, and what follows
// for an escape sequence.
void require_no_control_character(const std::string& text) {
  for (int i = 0, line = 0; i < static_cast<int>(text.size()); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    if (c == '\n') ++line;
    if ((c >= 0x20 && c != 0x7f) || c == '\t' || c == '\n' || c == '\r') continue;
    YAML::Mark mark;
    mark.line = line;
    throw YAML::ParserException(mark, fmt::format("control character \\u{:04x}", c));
  }
}

YAML::Node parse(const std::string& text, const std::string& name, bool has_lines) {
  try {
    require_no_control_character(text);
    require_one_document(text, name);
    return YAML::Load(text);
  } catch (const YAML::Exception& e) {
    const std::string place =
        has_lines && e.mark.line >= 0 ? fmt::format("{}:{}", name, e.mark.line + 1) : name;
    wrong(place, fmt::format("is not valid YAML: {}", shown(e.msg)));
  }
}

void read_text(const std::string& text, const std::string& name, const fs::path& folder,
               const Group& settings, Places& places, std::vector<fs::path> chain) {
  const YAML::Node root = parse(text, name, true);
  const int first_line = 1;
  if (root.IsMap()) {
    for (const auto& pair : root) {
      if (!pair.first.IsScalar() || pair.first.Scalar() != "extends") continue;
      const std::string place = fmt::format("{}:{}", name, pair.first.Mark().line + 1);
      if (!pair.second.IsScalar() || pair.second.Scalar().empty())
        wrong(place, "extends must name one YAML file");
      const fs::path base = (folder / pair.second.Scalar()).lexically_normal();
      const fs::path canonical = fs::weakly_canonical(base);
      if (std::find(chain.begin(), chain.end(), canonical) != chain.end()) {
        wrong(place, fmt::format("extends {}, which extends this file", base.string()));
      }
      std::vector<fs::path> longer = chain;
      longer.push_back(canonical);
      read_text(content(base, place), base.string(), base.parent_path(), settings, places,
                std::move(longer));
    }
  }
  Reader(name, true, folder.empty() ? "." : folder, places).read(root, first_line, settings, "");
}

}  // namespace

std::string Places::of(const std::string& setting) const {
  for (std::string name = setting;;) {
    if (const auto found = places_.find(name); found != places_.end()) return found->second;
    const std::size_t dot = name.rfind('.');
    if (dot == std::string::npos) break;
    name.resize(dot);
  }
  const auto inside = places_.lower_bound(setting + ".");
  if (inside != places_.end() && inside->first.starts_with(setting + ".")) return inside->second;
  return "default of " + setting;
}

void Places::rename(const std::string& given, const std::string& now, const std::string& place) {
  forget(now);
  std::map<std::string, std::string> moved;
  for (const auto& [name, where] : places_)
    if (name == given || name.starts_with(given + "."))
      moved[now + name.substr(given.size())] = where;
  forget(given);
  places_.merge(moved);
  note(given, now, place);
}

void Places::note(const std::string& given, const std::string& now, const std::string& place) {
  std::string former = given;  // without indices: one note covers all elements of a list
  std::erase_if(former, [](char c) { return c >= '0' && c <= '9'; });
  notes_.emplace(former, fmt::format("{}: {} is now called {}", place, given, now));
}

void Places::forget(const std::string& setting) {
  std::erase_if(places_, [&](const auto& place) {
    return place.first == setting || place.first.starts_with(setting + ".");
  });
}

void read_yaml_file(const fs::path& file, const Group& settings, Places& places) {
  read_text(content(file, ""), file.string(), file.parent_path(), settings, places,
            {fs::weakly_canonical(file)});
}

void read_yaml_text(const std::string& text, const std::string& name, const fs::path& folder,
                    const Group& settings, Places& places) {
  read_text(text, name, folder, settings, places, {});
}

void read_assignment(const std::string& assignment, const Group& settings, Places& places) {
  const std::string source = "--set " + shown(assignment);
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos || equals == 0)
    wrong(source, "expected NAME=VALUE, as in control.normal_force=3");
  const std::string path = assignment.substr(0, equals), text = assignment.substr(equals + 1);
  Reader reader(source, false, ".", places);

  Setting setting{"", "", "", Range::any(), settings};
  std::string name, now;  // as given, and its current name
  for (std::size_t from = 0; from <= path.size();) {
    const std::size_t dot = std::min(path.find('.', from), path.size());
    const std::string key = path.substr(from, dot - from);
    std::string current = key;
    from = dot + 1;
    if (const auto* optional = std::get_if<Optional>(&setting.value)) {
      optional->engage(true);
      setting = Setting(optional->value());
    }
    if (const auto* group = std::get_if<Group>(&setting.value)) {
      const auto field = find_field(*group, key);
      if (is_constant(*group, key, text, name, source)) return;
      if (field == group->fields.end()) wrong(source, unknown_key(key, name, *group));
      current = field->name;
      setting = Setting(*field);
    } else if (const auto* list = std::get_if<List>(&setting.value)) {
      const auto i = index(key, list->size());
      if (!i)
        wrong(source, fmt::format("{} has no element '{}': there are {}, counted from 0", name,
                                  shown(key), list->size()));
      setting = Setting(list->element(*i));
    } else if (const auto* numbers = std::get_if<Numbers>(&setting.value)) {
      const auto i = index(key, static_cast<std::size_t>(numbers->size));
      if (!i)
        wrong(source, fmt::format("{} has no element '{}': there are {}, counted from 0", name,
                                  shown(key), numbers->size));
      setting = Reader::component(*numbers, static_cast<int>(*i));
    } else {
      wrong(source, fmt::format("{} is a single value and has no '{}'", name, shown(key)));
    }
    name = below(name, key);
    now = below(now, current);
  }

  if (const auto* optional = std::get_if<Optional>(&setting.value);
      optional && text != "null" && text != "~") {
    optional->engage(true);
    setting = Setting(optional->value());
  }
  if (const auto* scalar = std::get_if<Scalar>(&setting.value))
    reader.take(text, 0, *scalar, name);
  else
    reader.read(parse(text, source, false), 0, setting, name);
  if (now != name) places.rename(name, now, source);
}

}  // namespace impedraw
