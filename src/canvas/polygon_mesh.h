// Polygon meshes as listed in files, and the parsers of the formats.
#pragma once

#include <cctype>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>

namespace impedraw {

struct PolygonMesh {
  std::vector<Eigen::Vector3d> vertices;  // [file's unit]
  std::vector<int> corners;               // vertex indices of all faces in turn, from 0
  std::vector<std::size_t> ends;          // end of each face in `corners`
  // Colours are of the vertices and of the faces, 0 … 1; other counts: the file has none. An OBJ's
  // faces have those of the .mtl files that it names, in its folder and below.
  std::vector<Eigen::Vector3d> colours, face_colours;
  double unit = 0.0;                  // [m], as the file says; 0: it says nothing
  bool y_up = false;                  // the file's format has its y axis up
  std::vector<std::string> warnings;  // one line each

  std::size_t faces() const { return ends.size(); }
  std::span<const int> face(std::size_t i) const {
    const std::size_t begin = i == 0 ? 0 : ends[i - 1];
    return {corners.data() + begin, ends[i] - begin};
  }
};

// Each throws InputError naming the file (`name`) and the line, vertex or face (from 0): truncated
// data, a text vertex without three finite numbers, a face with fewer than three corners, or an OBJ
// index out of range. The caller checks the other indices and whether binary values are finite.
PolygonMesh parse_obj(std::string_view text, const std::string& name);
PolygonMesh parse_stl(std::string_view text, const std::string& name);  // text or binary
PolygonMesh parse_ply(std::string_view text, const std::string& name);  // all three formats
PolygonMesh parse_off(std::string_view text, const std::string& name);  // text
// glb, gltf, 3mf and dae (read_scene.cc): all meshes where the scene's nodes place them. Assimp
// parses them in a process of its own, which may use 60 s and 4 GiB. A glTF's buffers are read from
// the folder of `name` and below.
PolygonMesh parse_scene(std::string_view text, const std::string& name);

// Triangulates all faces, keeping their order and winding. A face may be non-convex; one whose
// outline crosses itself is cut arbitrarily. InputError: a non-convex outline of more than 2,000
// corners.
std::vector<Eigen::Vector3i> triangulate(const PolygonMesh& mesh, const std::string& name);

// Parses words and numbers of mesh files.

// Removes the next word from the front of `text`; empty at its end.
inline std::string_view next_word(std::string_view* text) {
  const auto space = [](char c) { return c == ' ' || (c >= '\t' && c <= '\r'); };
  std::size_t from = 0;
  while (from < text->size() && space((*text)[from])) ++from;
  std::size_t to = from;
  while (to < text->size() && !space((*text)[to])) ++to;
  const std::string_view word = text->substr(from, to - from);
  text->remove_prefix(to);
  return word;
}

// Removes the next line from the front of `text`; false at its end. LF, CR LF or CR ends a line.
inline bool next_line(std::string_view* text, std::string_view* line) {
  if (text->empty()) return false;
  const std::size_t end = text->find_first_of("\r\n");
  *line = text->substr(0, end);
  text->remove_prefix(end == text->npos ? text->size() : end);
  text->remove_prefix(text->starts_with("\r\n") ? 2 : text->empty() ? 0 : 1);
  return true;
}

// Parses all of `word` as a number, with an optional "+".
template <class T>
bool whole_number(std::string_view word, T* value) {
  if (word.starts_with('+')) word.remove_prefix(1);
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), *value);
  return error == std::errc() && end == word.data() + word.size();
}

inline bool finite_number(std::string_view word, double* value) {
  return whole_number(word, value) && std::isfinite(*value);
}

// Compares ignoring case; `lower` is in lower case.
inline bool same_word(std::string_view word, std::string_view lower) {
  if (word.size() != lower.size()) return false;
  for (std::size_t i = 0; i < word.size(); ++i) {
    if (std::tolower(static_cast<unsigned char>(word[i])) != lower[i]) return false;
  }
  return true;
}

// Reads the first `size` bytes, at most 4.
inline std::uint32_t unsigned_bytes(std::string_view bytes, int size, bool big_endian) {
  std::uint32_t value = 0;
  for (int i = 0; i < size; ++i)
    value |= std::uint32_t{static_cast<unsigned char>(bytes[i])}
             << 8 * (big_endian ? size - 1 - i : i);
  return value;
}
inline std::uint32_t little_endian_u32(std::string_view bytes) {
  return unsigned_bytes(bytes, 4, false);
}

}  // namespace impedraw
