// The part of validate_file.h about PLY.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace impedraw {

// The faces that the header promises. Throws InputError, opened by `name`, where the body does not
// hold all that the header promises.
std::size_t validate_ply(std::string_view text, const std::string& name);

}  // namespace impedraw
