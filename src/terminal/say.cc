#include "impedraw/terminal/say.h"

#include <string_view>

namespace impedraw {
namespace {

constexpr std::string_view kInTree = "./impedraw";

std::string& command() {
  static std::string name(kInTree);
  return name;
}

}  // namespace

void set_command(const std::string& name) { command() = name; }

std::string as_called(std::string text) {
  if (command() == kInTree) return text;
  for (std::size_t at = 0; (at = text.find(kInTree, at)) != std::string::npos;) {
    // No part of a path, as in ../impedraw or ./impedraw/file.
    const std::size_t end = at + kInTree.size();
    const bool starts = at == 0 || (text[at - 1] != '.' && text[at - 1] != '/');
    const bool ends = end == text.size() || text.find_first_of("/.-_", end) != end;
    if (starts && ends) text.replace(at, kInTree.size(), command());
    at += starts && ends ? command().size() : kInTree.size();
  }
  return text;
}

}  // namespace impedraw
