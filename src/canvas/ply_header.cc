#include "impedraw/canvas/ply_header.h"

#include <algorithm>

#include <fmt/format.h>

#include "impedraw/canvas/mesh_tokens.h"
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

}  // namespace impedraw
