#include "impedraw/canvas/ply_header.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "impedraw/canvas/polygon_mesh.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

int ply_size(std::string_view type) {
  if (type == "char" || type == "uchar" || type == "int8" || type == "uint8") return 1;
  if (type == "short" || type == "ushort" || type == "int16" || type == "uint16") return 2;
  if (type == "int" || type == "uint" || type == "int32" || type == "uint32" || type == "float" ||
      type == "float32")
    return 4;
  return type == "double" || type == "float64" ? 8 : 0;
}

bool is_ply_whole(std::string_view type) {
  return ply_size(type) > 0 && !type.starts_with("float") && !type.starts_with("double");
}

bool is_ply_signed(std::string_view type) { return is_ply_whole(type) && !type.starts_with('u'); }

[[noreturn]] void wrong_ply_line(const std::string& name, std::size_t number,
                                 std::string_view line) {
  throw InputError(fmt::format("{}:{}: '{}' is not valid in the header of a PLY", name, number,
                               line.substr(0, 60)));
}

bool names_corners(const PlyElement& element, const PlyProperty& property) {
  return (element.name == "face" || element.name == "tristrips") && property.count_size > 0 &&
         (property.name == "vertex_indices" || property.name == "vertex_index");
}

template <class T>
double value_as(std::string_view bytes, bool big_endian) {
  char raw[sizeof(T)];
  for (std::size_t i = 0; i < sizeof(T); ++i) raw[i] = bytes[big_endian ? sizeof(T) - 1 - i : i];
  T value;
  std::memcpy(&value, raw, sizeof(T));
  return static_cast<double>(value);
}

// Returns an invalid index if the value is beyond an int.
int as_index(double value) {
  constexpr int most = std::numeric_limits<int>::max();
  return value >= 0 && value < most ? static_cast<int>(value) : value < 0 ? -1 : most;
}

struct Body {
  std::string_view text;
  PlyHeader::Format format;
  const std::string& name;
  PolygonMesh mesh = {};

  [[noreturn]] void cut_short(const PlyElement& element, std::size_t i) const {
    throw InputError(fmt::format("{}: truncated in {} {}, its header declares {}", name,
                                 element.name, i, element.count));
  }

  // Removes one number from the front.
  double number(const PlyElement& element, std::size_t i, int size, bool whole, bool has_sign) {
    if (format == PlyHeader::Format::text) {
      const std::string_view word = next_word(&text);
      if (word.empty()) cut_short(element, i);
      double value;
      if (!finite_number(word, &value) || (whole && value != std::floor(value))) {
        throw InputError(fmt::format("{}: {} {} holds '{}', must be a {} number", name,
                                     element.name, i, word.substr(0, 60),
                                     whole ? "whole" : "finite"));
      }
      return value;
    }
    if (text.size() < static_cast<std::size_t>(size)) cut_short(element, i);
    const bool big = format == PlyHeader::Format::big_endian;
    const std::string_view bytes = text.substr(0, size);
    text.remove_prefix(size);
    if (size == 8) return value_as<double>(bytes, big);
    if (!whole) return value_as<float>(bytes, big);
    if (!has_sign) return unsigned_bytes(bytes, size, big);
    return size == 4   ? value_as<std::int32_t>(bytes, big)
           : size == 2 ? value_as<std::int16_t>(bytes, big)
                       : value_as<std::int8_t>(bytes, big);
  }

  std::size_t list_count(const PlyElement& element, std::size_t i, const PlyProperty& property) {
    const double count = number(element, i, property.count_size, true, property.count_signed);
    if (count < 0) {
      throw InputError(
          fmt::format("{}: {} {} has a list of {} values", name, element.name, i, count));
    }
    if (count > static_cast<double>(text.size())) cut_short(element, i);
    return static_cast<std::size_t>(count);
  }

  // Cuts the strip of vertices from `begin` on into triangles; −1 begins another strip.
  void cut_strip(std::size_t begin) {
    const std::vector<int> strip(mesh.corners.begin() + static_cast<long>(begin),
                                 mesh.corners.end());
    mesh.corners.resize(begin);
    for (std::size_t i = 0, first = 0; i < strip.size(); ++i) {
      if (strip[i] < 0) first = i + 1;
      if (i < first + 2) continue;
      int a = strip[i - 2], b = strip[i - 1];
      if (a == b || b == strip[i] || a == strip[i]) continue;  // turns or bridges the strip
      if ((i - first) % 2 == 1) std::swap(a, b);
      mesh.corners.insert(mesh.corners.end(), {a, b, strip[i]});
      mesh.ends.push_back(mesh.corners.size());
    }
  }

  void take(const PlyElement& element) {
    constexpr std::array<const char*, 6> kNames = {"x", "y", "z", "red", "green", "blue"};
    std::array<std::size_t, 6> known;  // among the properties of a vertex
    known.fill(element.properties.size());
    bool has_corners = false;
    for (std::size_t k = 0; k < element.properties.size(); ++k) {
      const PlyProperty& property = element.properties[k];
      has_corners = has_corners || names_corners(element, property);
      for (std::size_t i = 0; i < known.size(); ++i)
        if (property.count_size == 0 &&
            (property.name == kNames[i] || property.name == std::string("diffuse_") + kNames[i]))
          known[i] = k;
    }
    const bool vertex = element.name == "vertex", strip = element.name == "tristrips",
               face = element.name == "face";
    const bool coloured = std::max({known[3], known[4], known[5]}) < element.properties.size();
    for (std::size_t i = 0; i < element.count; ++i) {
      Eigen::Vector<double, 6> values = Eigen::Vector<double, 6>::Zero();
      for (std::size_t k = 0; k < element.properties.size(); ++k) {
        const PlyProperty& property = element.properties[k];
        const bool corners = names_corners(element, property);
        const std::size_t count =
            property.count_size > 0 ? list_count(element, i, property) : std::size_t{1};
        if (corners && !strip && count < 3) {
          throw InputError(
              fmt::format("{}: face {} has {} corners, must have at least 3", name, i, count));
        }
        const std::size_t begin = mesh.corners.size();
        for (std::size_t j = 0; j < count; ++j) {
          const double value = number(element, i, property.size, property.whole, property.has_sign);
          if (corners) mesh.corners.push_back(as_index(value));
          if (!vertex && !face) continue;
          for (std::size_t m = 0; m < known.size(); ++m)
            if (known[m] == k)
              values[static_cast<Eigen::Index>(m)] =
                  m >= 3 && property.whole ? value / (std::pow(256.0, property.size) - 1.0) : value;
        }
        if (corners && strip) cut_strip(begin);
        if (corners && !strip) mesh.ends.push_back(mesh.corners.size());
      }
      if (vertex) mesh.vertices.push_back(values.head<3>());
      if (coloured && (vertex || face))
        (vertex ? mesh.colours : mesh.face_colours).push_back(values.tail<3>());
    }
    if (vertex && std::max({known[0], known[1], known[2]}) == element.properties.size())
      throw InputError(fmt::format("{}: its vertices have no x, y and z", name));
    if ((strip || face) && element.count > 0 && !has_corners)
      throw InputError(fmt::format("{}: its faces have no list vertex_indices", name));
  }
};

}  // namespace

PlyHeader read_ply_header(std::string_view* text, const std::string& name) {
  PlyHeader header;
  char end_of_line = '\n';
  for (std::size_t number = 1;; ++number) {
    if (number == 1) {  // a binary body may begin with the byte of LF
      const std::size_t first = text->find_first_of("\r\n");
      if (text->substr(std::min(first, text->size()), 2) != "\r\n" && first != text->npos)
        end_of_line = (*text)[first];
    }
    const std::size_t end = text->find(end_of_line);
    if (end == text->npos)
      throw InputError(fmt::format("{}: truncated in its header, or not a PLY", name));
    const std::string_view line = text->substr(0, end);
    text->remove_prefix(end + 1);
    std::string_view rest = line;
    const std::string_view key = next_word(&rest);
    if (number == 1) {
      if (key != "ply")
        throw InputError(
            fmt::format("{}: begins with '{}', must begin with 'ply'", name, line.substr(0, 20)));
    } else if (key == "end_header") {
      return header;
    } else if (key == "format") {
      const std::string_view format = next_word(&rest);
      if (format == "binary_little_endian")
        header.format = PlyHeader::Format::little_endian;
      else if (format == "binary_big_endian")
        header.format = PlyHeader::Format::big_endian;
      else if (format != "ascii")
        wrong_ply_line(name, number, line);
    } else if (key == "element") {
      PlyElement element;
      element.name = next_word(&rest);
      if (!whole_number(next_word(&rest), &element.count)) wrong_ply_line(name, number, line);
      header.elements.push_back(element);
    } else if (key == "property") {
      if (header.elements.empty()) wrong_ply_line(name, number, line);
      PlyProperty property;
      std::string_view type = next_word(&rest);
      if (type == "list") {
        const std::string_view count_type = next_word(&rest);
        property.count_size = ply_size(count_type);
        property.count_signed = is_ply_signed(count_type);
        if (!is_ply_whole(count_type)) wrong_ply_line(name, number, line);
        type = next_word(&rest);
      }
      property.size = ply_size(type);
      property.whole = is_ply_whole(type);
      property.has_sign = is_ply_signed(type);
      property.name = next_word(&rest);
      if (property.size == 0 || property.name.empty()) wrong_ply_line(name, number, line);
      header.elements.back().properties.push_back(property);
    }
  }
}

PolygonMesh parse_ply(std::string_view text, const std::string& name) {
  const PlyHeader header = read_ply_header(&text, name);
  Body body{text, header.format, name};
  for (const auto& element : header.elements) {  // in any order
    if (element.properties.empty() && element.count > 0)
      throw InputError(
          fmt::format("{}: element {} of its header has no property", name, element.name));
    body.take(element);
  }
  return std::move(body.mesh);
}

}  // namespace impedraw
