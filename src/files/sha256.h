// SHA-256 (FIPS 180-4), as sha256sum prints it.
#pragma once

#include <string>
#include <string_view>

namespace impedraw {

std::string sha256(std::string_view data);  // 64 hexadecimal digits

}  // namespace impedraw
