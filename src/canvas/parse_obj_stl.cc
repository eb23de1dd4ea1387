#include <algorithm>
#include <cctype>
#include <cstring>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "impedraw/canvas/mesh_tokens.h"
#include "impedraw/canvas/polygon_mesh.h"
#include "impedraw/common/errors.h"

namespace impedraw {
namespace {

constexpr std::size_t kStlHeader = 84, kStlTriangle = 50;  // bytes

// The next line without its end.
struct Lines {
  std::string_view text;
  std::size_t number = 0;

  bool next(std::string_view* line) {
    if (text.empty()) return false;
    ++number;
    const std::size_t end = text.find('\n');
    *line = text.substr(0, end);
    text.remove_prefix(end == text.npos ? text.size() : end + 1);
    if (!line->empty() && line->back() == '\r') line->remove_suffix(1);
    return true;
  }
};

// The line after its first word.
Eigen::Vector3d three_numbers(std::string_view line, const std::string& where, std::size_t vertex) {
  std::string_view rest = line;
  next_word(&rest);
  Eigen::Vector3d p;
  for (double& value : p) {
    if (!finite_number(next_word(&rest), &value)) {
      throw InputError(fmt::format("{}: vertex {} is '{}', must have three finite numbers", where,
                                   vertex, line.substr(0, 60)));
    }
  }
  return p;
}

bool is_text(std::string_view head) {
  return std::none_of(head.begin(), head.end(),
                      [](unsigned char c) { return c < 32 && !std::isspace(c); });
}

// Adds three new vertices that no other face shares.
PolygonMesh soup(std::vector<Eigen::Vector3d> vertices) {
  PolygonMesh mesh;
  mesh.corners.resize(vertices.size());
  std::iota(mesh.corners.begin(), mesh.corners.end(), 0);
  for (std::size_t end = 3; end <= vertices.size(); end += 3) mesh.ends.push_back(end);
  mesh.vertices = std::move(vertices);
  return mesh;
}

PolygonMesh parse_text_stl(std::string_view text, const std::string& name) {
  Lines lines{text};
  std::string_view line;
  std::vector<Eigen::Vector3d> corners;
  std::size_t facets = 0, vertices = 0;
  bool inside = false, ended = false;
  while (lines.next(&line)) {  // of one solid or of several
    std::string_view rest = line;
    const std::string_view key = next_word(&rest);
    if (key.empty()) continue;
    ended = same_word(key, "endsolid");
    if (same_word(key, "facet")) {
      if (inside)
        throw InputError(
            fmt::format("{}:{}: triangle {} has no endfacet", name, lines.number, facets));
      inside = true;
      vertices = 0;
    } else if (same_word(key, "vertex")) {
      const std::string where = fmt::format("{}:{}: triangle {}", name, lines.number, facets);
      if (!inside) throw InputError(where + " has a vertex before its facet");
      corners.push_back(three_numbers(line, where, vertices++));
    } else if (same_word(key, "endfacet")) {
      if (!inside || vertices != 3) {
        throw InputError(fmt::format("{}:{}: triangle {} has {} vertices, must have 3", name,
                                     lines.number, facets, vertices));
      }
      inside = false;
      ++facets;
    }
  }
  if (inside || !ended) {
    throw InputError(fmt::format("{}: truncated {} triangle {}, must end with endsolid", name,
                                 inside ? "within" : "after",
                                 inside || facets == 0 ? facets : facets - 1));
  }
  return soup(std::move(corners));
}

PolygonMesh parse_binary_stl(std::string_view text) {
  std::vector<Eigen::Vector3d> corners;
  corners.reserve((text.size() - kStlHeader) / kStlTriangle * 3);
  for (std::size_t at = kStlHeader; at < text.size(); at += kStlTriangle) {
    float xyz[9];  // after the normal
    static_assert(std::numeric_limits<float>::is_iec559);
    for (int i = 0; i < 9; ++i) {
      const std::uint32_t bits = little_endian_u32(text.substr(at + 12 + 4 * i, 4));
      std::memcpy(&xyz[i], &bits, 4);
    }
    for (int i = 0; i < 9; i += 3) corners.emplace_back(xyz[i], xyz[i + 1], xyz[i + 2]);
  }
  return soup(std::move(corners));
}

}  // namespace

PolygonMesh parse_obj(std::string_view text, const std::string& name) {
  PolygonMesh mesh;
  Lines lines{text};
  std::string_view line;
  std::string joined;
  while (lines.next(&line)) {
    const std::size_t first = lines.number;
    if (line.ends_with('\\')) {  // continues on the next line
      joined.assign(line);
      while (joined.ends_with('\\')) {
        joined.back() = ' ';
        if (lines.next(&line)) joined += line;
      }
      line = joined;
    }
    std::string_view rest = line;
    const std::string_view key = next_word(&rest);
    if (key == "v") {
      const std::string where = fmt::format("{}:{}", name, first);
      mesh.vertices.push_back(three_numbers(line, where, mesh.vertices.size()));
    } else if (key == "f") {
      const std::size_t before = mesh.corners.size();
      const long count = static_cast<long>(mesh.vertices.size());
      for (std::string_view word = next_word(&rest); !word.empty() && word[0] != '#';
           word = next_word(&rest)) {
        long index = 0;
        const bool whole = whole_number(word.substr(0, word.find('/')), &index);
        if (!whole || index == 0 || index > count || index < -count) {
          throw InputError(fmt::format(
              "{}:{}: face {} names vertex '{}', must be in 1 … {} or, counted back, −1 … −{}",
              name, first, mesh.faces(), word, count, count));
        }
        mesh.corners.push_back(static_cast<int>(index > 0 ? index - 1 : count + index));
      }
      if (mesh.corners.size() < before + 3) {
        throw InputError(fmt::format("{}:{}: face {} has {} corners, must have at least 3", name,
                                     first, mesh.faces(), mesh.corners.size() - before));
      }
      mesh.ends.push_back(mesh.corners.size());
    }
  }
  return mesh;
}

PolygonMesh parse_stl(std::string_view text, const std::string& name) {
  const bool has_count = text.size() >= kStlHeader;
  const std::size_t count = has_count ? little_endian_u32(text.substr(kStlHeader - 4)) : 0;
  const std::size_t desired = kStlHeader + kStlTriangle * count;
  if (has_count && text.size() == desired) return parse_binary_stl(text);
  if (same_word(text.substr(0, 5), "solid") && is_text(text.substr(0, 512)))
    return parse_text_stl(text, name);
  if (!has_count) {
    throw InputError(
        fmt::format("{}: {} bytes, an STL has a header of {} bytes or begins with 'solid'", name,
                    text.size(), kStlHeader));
  }
  if (text.size() < desired) {
    throw InputError(fmt::format("{}: truncated in triangle {}, its header declares {} triangles",
                                 name, (text.size() - kStlHeader) / kStlTriangle, count));
  }
  throw InputError(fmt::format("{}: {} bytes follow the {} triangles that its header declares",
                               name, text.size() - desired, count));
}

}  // namespace impedraw
