#include "impedraw/study/provenance.h"

#include <array>
#include <cstdio>
#include <ctime>

namespace impedraw {

namespace {

// The output of a git command in the source tree; empty if it fails.
std::string git(const std::string& arguments) {
  const std::string command =
      std::string("git -C '") + IMPEDRAW_ROOT + "' " + arguments + " 2>/dev/null";
  std::string text;
  if (FILE* pipe = popen(command.c_str(), "r")) {
    std::array<char, 256> part;
    while (std::fgets(part.data(), static_cast<int>(part.size()), pipe)) text += part.data();
    pclose(pipe);
  }
  while (text.ends_with('\n')) text.pop_back();
  return text;
}

}  // namespace

std::string provenance() {
  const std::time_t now = std::time(nullptr);
  char date[11] = "";
  std::strftime(date, sizeof date, "%Y-%m-%d", std::localtime(&now));
  const std::string commit = git("rev-parse --short HEAD");
  if (commit.empty()) return date;
  const bool changed = !git("status --porcelain -- src scenarios models artwork").empty();
  return std::string(date) + ", commit " + commit + (changed ? "+" : "");
}

}  // namespace impedraw
