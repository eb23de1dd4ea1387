// File extensions, used to distinguish kinds of files.
#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

namespace impedraw {

// The extension in lower case with its dot, such as ".svg"; empty if there is none.
inline std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

}  // namespace impedraw
