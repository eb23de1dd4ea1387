#include "impedraw/canvas/validate_ply.h"

#include <vector>

#include <fmt/format.h>

#include "impedraw/canvas/mesh_tokens.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

struct Property {
  std::string_view name;
  int count_size = 0;  // bytes of a list's count; 0: not a list
  int size = 0;        // bytes
  bool whole = false;  // not a float
};

struct Element {
  std::string_view name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

struct Header {
  enum class Format { text, little_endian, big_endian } format = Format::text;
  std::vector<Element> elements;
};

int size_of(std::string_view type) {
  if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
  if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
  if (type == "int" || type == "uint" || type == "int32" || type == "uint32" || type == "float" ||
      type == "float32")
    return 4;
  return type == "double" || type == "float64" ? 8 : 0;
}

bool is_whole(std::string_view type) {
  return size_of(type) > 0 && !type.starts_with("float") && !type.starts_with("double");
}

[[noreturn]] void wrong_line(const std::string& name, std::size_t number, std::string_view line) {
  throw InputError(
      fmt::format("{}:{}: the header of a PLY cannot hold '{}'", name, number, line.substr(0, 60)));
}

// Takes the header off the front of `text`.
Header read_header(std::string_view* text, const std::string& name) {
  Header header;
  for (std::size_t number = 1;; ++number) {
    const std::size_t end = text->find('\n');
    if (end == text->npos)
      throw InputError(fmt::format("{}: cut short within its header, or no PLY at all", name));
    const std::string_view line = text->substr(0, end);
    text->remove_prefix(end + 1);
    std::string_view rest = line;
    const std::string_view key = next_word(&rest);
    if (number == 1) {
      if (key != "ply")
        throw InputError(
            fmt::format("{}: opens with '{}', a PLY with 'ply'", name, line.substr(0, 20)));
    } else if (key == "end_header") {
      return header;
    } else if (key == "format") {
      const std::string_view format = next_word(&rest);
      if (format == "binary_little_endian")
        header.format = Header::Format::little_endian;
      else if (format == "binary_big_endian")
        header.format = Header::Format::big_endian;
      else if (format != "ascii")
        wrong_line(name, number, line);
    } else if (key == "element") {
      Element element;
      element.name = next_word(&rest);
      if (!whole_number(next_word(&rest), &element.count)) wrong_line(name, number, line);
      header.elements.push_back(element);
    } else if (key == "property") {
      if (header.elements.empty()) wrong_line(name, number, line);
      Property property;
      std::string_view type = next_word(&rest);
      if (type == "list") {
        const std::string_view count_type = next_word(&rest);
        property.count_size = size_of(count_type);
        if (!is_whole(count_type)) wrong_line(name, number, line);
        type = next_word(&rest);
      }
      property.size = size_of(type);
      property.whole = is_whole(type);
      property.name = next_word(&rest);
      if (property.size == 0 || property.name.empty()) wrong_line(name, number, line);
      header.elements.back().properties.push_back(property);
    }
  }
}

bool names_corners(const Element& element, const Property& property) {
  return element.name == "face" &&
         (property.name == "vertex_indices" || property.name == "vertex_index");
}

struct Body {
  std::string_view text;
  Header::Format format;
  const std::string& name;

  [[noreturn]] void cut_short(const Element& element, std::size_t i) const {
    throw InputError(fmt::format("{}: cut short within {} {}, its header promises {}", name,
                                 element.name, i, element.count));
  }

  // One number or list's count; its value, if it is a count.
  std::size_t take(const Element& element, std::size_t i, int size, bool is_count,
                   bool must_be_whole) {
    if (format != Header::Format::text) {
      if (text.size() < static_cast<std::size_t>(size)) cut_short(element, i);
      const std::size_t count =
          is_count ? unsigned_bytes(text, size, format == Header::Format::big_endian) : 0;
      text.remove_prefix(size);
      return count;
    }
    const std::string_view word = next_word(&text);
    if (word.empty()) cut_short(element, i);
    double value;
    if (!finite_number(word, &value) ||
        ((is_count || must_be_whole) && value != std::floor(value)) || (is_count && value < 0)) {
      throw InputError(fmt::format("{}: {} {} holds '{}', must be a {} number", name, element.name,
                                   i, word.substr(0, 60),
                                   is_count || must_be_whole ? "whole" : "finite"));
    }
    return is_count ? static_cast<std::size_t>(value) : 0;
  }

  void skip(const Element& element) {
    bool lists = false;
    std::size_t size = 0;
    for (const auto& property : element.properties) {
      lists = lists || property.count_size > 0;
      size += property.size;
    }
    if (!lists && format != Header::Format::text) {
      if (size > 0 && text.size() / size < element.count) cut_short(element, text.size() / size);
      text.remove_prefix(size * element.count);
      return;
    }
    for (std::size_t i = 0; i < element.count; ++i) {
      for (const auto& property : element.properties) {
        std::size_t count = 1;
        if (property.count_size > 0) count = take(element, i, property.count_size, true, true);
        if (names_corners(element, property) && count < 3) {
          throw InputError(
              fmt::format("{}: face {} has {} corners, must have at least 3", name, i, count));
        }
        if (format == Header::Format::text) {
          for (std::size_t k = 0; k < count; ++k)
            take(element, i, property.size, false, property.whole);
        } else {
          if (text.size() / property.size < count) cut_short(element, i);
          text.remove_prefix(count * property.size);
        }
      }
    }
  }
};

}  // namespace

std::size_t validate_ply(std::string_view text, const std::string& name) {
  const Header header = read_header(&text, name);
  Body body{text, header.format, name};
  std::size_t faces = 0;
  for (const auto& element : header.elements) {
    if (element.properties.empty())
      throw InputError(
          fmt::format("{}: element {} of its header has no property", name, element.name));
    body.skip(element);
    if (element.name != "face") continue;
    bool corners = false;
    for (const auto& property : element.properties)
      corners = corners || (names_corners(element, property) && property.count_size > 0);
    if (!corners) throw InputError(fmt::format("{}: its faces have no list vertex_indices", name));
    faces += element.count;
  }
  return faces;
}

}  // namespace impedraw
