// Checks the text of an arm description before an XML library sees it. urdfdom and MuJoCo recurse
// into nested elements, open the files that an <include> names, and MuJoCo reads its own format
// (MJCF) where a URDF is expected.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace impedraw {

inline constexpr int kMostUrdfLinks = 256;

// Throws InputError "arm description <name>: line <n>: …" unless the text is well-formed XML whose
// root element is <robot>, with at most kMostUrdfLinks links and as many joints, nested no deeper
// than 16 elements.
void require_urdf(std::string_view text, const std::string& name);

// The same of a file, which must be a regular file of at most 4 MB.
void require_urdf_file(const std::filesystem::path& file);

}  // namespace impedraw
