// The ending of a file's name, as kinds of file are told apart by it.
#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

namespace impedraw {

// With its dot, in small letters: ".svg". Empty where there is none.
inline std::string lower_extension(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension;
}

}  // namespace impedraw
