// The date and commit that a study's page states.
#pragma once

#include <string>

namespace impedraw {

// "2026-11-22, commit 852ed04". A "+" follows the commit if files that a drawing depends on have
// changed since. Without git, the date alone.
std::string provenance();

}  // namespace impedraw
