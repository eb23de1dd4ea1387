#include <algorithm>
#include <cctype>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "impedraw/canvas/polygon_mesh.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/text_fields.h"

namespace impedraw {
namespace {

constexpr std::size_t kStlHeader = 84, kStlTriangle = 50;  // bytes

struct Lines {
  std::string_view text;
  std::size_t number = 0;

  bool next(std::string_view* line) {
    ++number;
    return next_line(&text, line);
  }
};

// An OBJ's line without its comment; true if it goes on in the next line.
bool cut_comment(std::string_view* line) {
  *line = line->substr(0, line->find('#'));
  line->remove_suffix(line->size() - (line->find_last_not_of(" \t") + 1));
  return line->ends_with('\\');
}

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

// Gives each face three vertices that no other face shares.
PolygonMesh soup(PolygonMesh mesh) {
  mesh.corners.resize(mesh.vertices.size());
  std::iota(mesh.corners.begin(), mesh.corners.end(), 0);
  for (std::size_t end = 3; end <= mesh.vertices.size(); end += 3) mesh.ends.push_back(end);
  return mesh;
}

PolygonMesh parse_text_stl(std::string_view text, const std::string& name) {
  Lines lines{text};
  std::string_view line;
  PolygonMesh mesh;
  std::size_t facets = 0, vertices = 0;
  bool inside = false, ended = false, told = false;
  while (lines.next(&line)) {  // of one solid or of several
    std::string_view rest = line;
    std::string key(next_word(&rest));
    if (key.empty()) continue;
    const bool apart = same_word(key, "end");  // "end solid", "end facet"
    if (apart) key += next_word(&rest);
    const bool over = ended;
    ended = same_word(std::string_view(key).substr(0, 8), "endsolid") ||
            (over && !same_word(key, "solid") && !same_word(key, "facet"));
    if (ended && !over && (apart || key.size() > 8)) {
      mesh.warnings.push_back(
          fmt::format("line {}: '{}' is read as endsolid", lines.number, line.substr(0, 60)));
    }
    if (ended && over && !std::exchange(told, true)) {
      mesh.warnings.push_back(
          fmt::format("line {}: '{}' follows endsolid: ignored", lines.number, line.substr(0, 60)));
    }
    if (same_word(key, "facet")) {
      if (inside)
        throw InputError(
            fmt::format("{}:{}: triangle {} has no endfacet", name, lines.number, facets));
      inside = true;
      vertices = 0;
    } else if (same_word(key, "vertex")) {
      const std::string where = fmt::format("{}:{}: triangle {}", name, lines.number, facets);
      if (!inside) throw InputError(where + " has a vertex before its facet");
      mesh.vertices.push_back(three_numbers(line, where, vertices++));
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
  return soup(std::move(mesh));
}

PolygonMesh parse_binary_stl(std::string_view text, std::size_t facets) {
  PolygonMesh mesh;
  mesh.vertices.reserve(facets * 3);
  for (std::size_t at = kStlHeader; facets > 0; at += kStlTriangle, --facets) {
    float xyz[9];  // after the normal
    static_assert(std::numeric_limits<float>::is_iec559);
    for (int i = 0; i < 9; ++i) {
      const std::uint32_t bits = little_endian_u32(text.substr(at + 12 + 4 * i, 4));
      std::memcpy(&xyz[i], &bits, 4);
    }
    for (int i = 0; i < 9; i += 3) mesh.vertices.emplace_back(xyz[i], xyz[i + 1], xyz[i + 2]);
  }
  return soup(std::move(mesh));
}

// True unless a face from `first` on has no area or lies far outside those before it.
bool are_triangles(const PolygonMesh& mesh, std::size_t first) {
  double far = 0.0;
  for (std::size_t i = 0; i < mesh.vertices.size(); i += 3) {
    const auto* p = &mesh.vertices[i];
    const double most = std::max({p[0].lpNorm<Eigen::Infinity>(), p[1].lpNorm<Eigen::Infinity>(),
                                  p[2].lpNorm<Eigen::Infinity>()});
    if (i < 3 * first)
      far = std::max(far, most);
    else if (!(most <= 10.0 * far && (p[1] - p[0]).cross(p[2] - p[0]).norm() > 0.0))
      return false;
  }
  return true;
}

const Eigen::Vector3d kNoColour = Eigen::Vector3d::Constant(-1.0);

// Adds the diffuse colours of an .mtl file's materials; none where it cannot be read, or has a
// picture in their place.
void read_materials(const std::filesystem::path& file,
                    std::map<std::string, Eigen::Vector3d>* materials) {
  if (!std::filesystem::is_regular_file(file)) return;
  std::ifstream in(file);
  Eigen::Vector3d* colour = nullptr;
  for (std::string line; std::getline(in, line);) {
    std::string_view rest = line;
    const std::string_view key = next_word(&rest);
    if (key == "newmtl") colour = &(*materials)[std::string(trimmed(rest))];
    if (!colour || (key != "newmtl" && key != "Kd" && key != "map_Kd")) continue;
    Eigen::Vector3d given;
    const bool plain = key == "Kd" && std::all_of(given.begin(), given.end(), [&](double& c) {
                         return finite_number(next_word(&rest), &c);
                       });
    *colour = plain ? given : kNoColour;
  }
}

}  // namespace

PolygonMesh parse_obj(std::string_view text, const std::string& name) {
  PolygonMesh mesh;
  std::map<std::string, Eigen::Vector3d> materials;
  Eigen::Vector3d colour_of_faces = kNoColour;
  Lines lines{text};
  std::string_view line;
  std::string joined;
  while (lines.next(&line)) {
    const std::size_t first = lines.number;
    if (bool goes_on = cut_comment(&line)) {
      for (joined.clear(); goes_on; goes_on = lines.next(&line) && cut_comment(&line)) {
        joined.append(line.substr(0, line.size() - 1)) += ' ';
        line = {};
      }
      line = joined += line;
    }
    std::string_view rest = line;
    const std::string_view key = next_word(&rest);
    if (key == "v") {
      const std::string where = fmt::format("{}:{}", name, first);
      mesh.vertices.push_back(three_numbers(line, where, mesh.vertices.size()));
      for (int i = 0; i < 3; ++i) next_word(&rest);
      Eigen::Vector3d colour;
      if (std::all_of(colour.begin(), colour.end(),
                      [&](double& c) { return finite_number(next_word(&rest), &c); }))
        mesh.colours.push_back(colour);
    } else if (key == "mtllib") {
      read_materials(std::filesystem::path(name).parent_path() / trimmed(rest), &materials);
    } else if (key == "usemtl") {
      const auto material = materials.find(std::string(trimmed(rest)));
      colour_of_faces = material == materials.end() ? kNoColour : material->second;
    } else if (key == "f") {
      const std::size_t before = mesh.corners.size();
      const long count = static_cast<long>(mesh.vertices.size());
      for (std::string_view word = next_word(&rest); !word.empty(); word = next_word(&rest)) {
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
      if (materials.empty()) continue;
      mesh.face_colours.resize(mesh.faces() - 1, kNoColour);
      mesh.face_colours.push_back(colour_of_faces);
    }
  }
  return mesh;
}

PolygonMesh parse_stl(std::string_view text, const std::string& name) {
  const bool has_count = text.size() >= kStlHeader;
  const std::size_t count = has_count ? little_endian_u32(text.substr(kStlHeader - 4)) : 0;
  const std::size_t desired = kStlHeader + kStlTriangle * count;
  if (has_count && text.size() == desired) return parse_binary_stl(text, count);
  std::string_view rest = text;
  if (same_word(next_word(&rest).substr(0, 5), "solid") && is_text(text.substr(0, 512)))
    return parse_text_stl(text, name);
  if (!has_count) {
    throw InputError(
        fmt::format("{}: {} bytes, an STL has a header of {} bytes or begins with 'solid'", name,
                    text.size(), kStlHeader));
  }
  // Some programs leave the count 0 or write a wrong one, others append bytes of their own.
  const std::size_t size = text.size() - kStlHeader, held = size / kStlTriangle;
  const bool whole = size % kStlTriangle == 0;
  if (held == 0 || (text.size() < desired && !whole)) {
    throw InputError(fmt::format("{}: truncated in triangle {}, its header declares {} triangles",
                                 name, held, count));
  }
  PolygonMesh mesh = parse_binary_stl(text, held);
  const bool appended =
      count > 0 && text.size() > desired && (!whole || !are_triangles(mesh, count));
  if (appended) mesh = parse_binary_stl(text, count);
  mesh.warnings.push_back(
      appended ? fmt::format("{} bytes follow the {} triangles that its header declares: ignored",
                             text.size() - desired, count)
               : fmt::format("its header declares {} triangles, {} are there: is the file whole?",
                             count, held));
  return mesh;
}

PolygonMesh parse_off(std::string_view text, const std::string& name) {
  std::string_view line, rest;
  std::size_t number = 0;
  const auto fail = [&](const char* desired) {
    throw InputError(
        fmt::format("{}:{}: '{}', must be {}", name, number, line.substr(0, 60), desired));
  };
  const auto read_line = [&](const char* what, std::size_t i) {  // one that holds something
    do {
      if (!next_line(&text, &line))
        throw InputError(fmt::format("{}: truncated in {} {}", name, what, i));
      ++number;
      rest = line = line.substr(0, line.find('#'));
    } while (next_word(&rest).empty());
    rest = line;
  };
  read_line("line", 0);
  if (next_word(&rest).ends_with("OFF")) {  // or COFF, NOFF, STOFF
    if (std::string_view counts = rest; next_word(&counts).empty()) read_line("header", 0);
  } else {
    rest = line;
  }
  std::size_t vertices, faces, corners;
  if (!whole_number(next_word(&rest), &vertices) || !whole_number(next_word(&rest), &faces))
    fail("OFF, then the numbers of vertices and of faces");
  PolygonMesh mesh;
  for (std::size_t i = 0; i < vertices; ++i) {  // normals and colours follow in the line
    read_line("vertex", i);
    Eigen::Vector3d p;
    for (double& value : p)
      if (!finite_number(next_word(&rest), &value)) fail("three finite numbers");
    mesh.vertices.push_back(p);
  }
  for (std::size_t i = 0; i < faces; ++i) {
    read_line("face", i);
    if (!whole_number(next_word(&rest), &corners)) fail("a number of corners");
    if (corners < 3) continue;  // a point or a line
    for (std::size_t k = 0; k < corners; ++k)
      if (!whole_number(next_word(&rest), &mesh.corners.emplace_back())) fail("whole numbers");
    mesh.ends.push_back(mesh.corners.size());
  }
  return mesh;
}

}  // namespace impedraw
