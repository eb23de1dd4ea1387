#include "impedraw/canvas/validate_file.h"

#include <algorithm>
#include <cctype>
#include <fstream>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "impedraw/canvas/mesh_tokens.h"
#include "impedraw/canvas/validate_ply.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/file_extension.h"

namespace impedraw {
namespace {

constexpr std::size_t kStlHeader = 84, kStlTriangle = 50;  // bytes

std::string read_all(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(file, error))
    throw InputError(fmt::format("{}: no such file", file.string()));
  const auto size = std::filesystem::file_size(file, error);
  if (size > (std::size_t{1} << 31)) {
    throw InputError(fmt::format("{}: {:.1f} GiB, at most 2 GiB are read: thin the mesh out",
                                 file.string(), size / 1073741824.0));
  }
  std::string text(size, '\0');
  std::ifstream in(file, std::ios::binary);
  if (!in.read(text.data(), static_cast<std::streamsize>(size)))
    throw InputError(fmt::format("{}: cannot be read", file.string()));
  if (text.empty())
    throw InputError(fmt::format("{}: the file is empty, must hold triangles", file.string()));
  return text;
}

// The next line without its end; in an OBJ a backslash before the end joins the next line.
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

void require_three_numbers(std::string_view line, const std::string& where, std::size_t vertex) {
  std::string_view rest = line;
  next_word(&rest);
  for (int i = 0; i < 3; ++i) {
    double value;
    if (!finite_number(next_word(&rest), &value)) {
      throw InputError(fmt::format("{}: vertex {} is '{}', must have three finite numbers", where,
                                   vertex, line.substr(0, 60)));
    }
  }
}

std::size_t require_whole_obj(std::string_view text, const std::string& name) {
  Lines lines{text};
  std::string_view line;
  std::size_t vertices = 0, faces = 0;
  std::string joined;
  while (lines.next(&line)) {
    const std::size_t first = lines.number;
    if (!line.empty() && line.back() == '\\') {
      joined.assign(line);
      while (!joined.empty() && joined.back() == '\\' && lines.next(&line)) {
        joined.back() = ' ';
        joined += line;
      }
      line = joined;
    }
    std::string_view rest = line;
    const std::string_view key = next_word(&rest);
    if (key == "v") {
      require_three_numbers(line, fmt::format("{}:{}", name, first), vertices++);
    } else if (key == "f") {
      int corners = 0;
      for (std::string_view word = next_word(&rest); !word.empty();
           word = next_word(&rest), ++corners) {
        long index = 0;
        const bool whole = whole_number(word.substr(0, word.find('/')), &index);
        const long count = static_cast<long>(vertices);
        if (!whole || index == 0 || index > count || index < -count) {
          throw InputError(fmt::format(
              "{}:{}: face {} names vertex '{}', must be in 1 … {} or, counted back, −1 … −{}",
              name, first, faces, word, count, count));
        }
      }
      if (corners < 3)
        throw InputError(fmt::format("{}:{}: face {} has {} corners, must have at least 3", name,
                                     first, faces, corners));
      ++faces;
    }
  }
  return faces;
}

bool is_text(std::string_view head) {
  return std::none_of(head.begin(), head.end(),
                      [](unsigned char c) { return c < 32 && !std::isspace(c); });
}

std::size_t require_whole_text_stl(std::string_view text, const std::string& name) {
  Lines lines{text};
  std::string_view line;
  std::size_t facets = 0, vertices = 0;
  bool inside = false, ended = false;
  while (lines.next(&line)) {
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
      require_three_numbers(line, fmt::format("{}:{}: triangle {}", name, lines.number, facets),
                            vertices++);
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
    throw InputError(fmt::format("{}: cut short {} triangle {}, must end with endsolid", name,
                                 inside ? "within" : "after",
                                 inside || facets == 0 ? facets : facets - 1));
  }
  return facets;
}

std::size_t require_whole_stl(std::string_view text, const std::string& name) {
  const bool has_count = text.size() >= kStlHeader;
  const std::size_t count = has_count ? little_endian_u32(text.substr(kStlHeader - 4)) : 0;
  const std::size_t desired = kStlHeader + kStlTriangle * count;
  if (has_count && text.size() == desired) return count;
  if (same_word(text.substr(0, 5), "solid") && is_text(text.substr(0, 512)))
    return require_whole_text_stl(text, name);
  if (!has_count) {
    throw InputError(fmt::format("{}: {} bytes, an STL has a header of {} or opens with 'solid'",
                                 name, text.size(), kStlHeader));
  }
  if (text.size() < desired) {
    throw InputError(
        fmt::format("{}: cut short within triangle {}, its header promises {} triangles", name,
                    (text.size() - kStlHeader) / kStlTriangle, count));
  }
  throw InputError(
      fmt::format("{}: {} bytes stand behind the {} triangles that its header promises", name,
                  text.size() - desired, count));
}

}  // namespace

bool is_mesh_file(const std::filesystem::path& file) {
  const std::string ending = lower_extension(file);
  return ending == ".obj" || ending == ".stl" || ending == ".ply";
}

std::size_t validate_mesh_file(const std::filesystem::path& file) {
  const std::string ending = lower_extension(file);
  if (!is_mesh_file(file)) {
    throw InputError(fmt::format("{}: ends in '{}', a mesh must be a .obj, .stl or .ply",
                                 file.string(), ending));
  }
  const std::string text = read_all(file);
  if (ending == ".obj") return require_whole_obj(text, file.string());
  if (ending == ".stl") return require_whole_stl(text, file.string());
  return validate_ply(text, file.string());
}

}  // namespace impedraw
