#include "impedraw/run/run_folder.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <stdexcept>

#include <fmt/format.h>

#include "impedraw/common/errors.h"

namespace impedraw {

namespace fs = std::filesystem;

namespace {

// A folder, or none where one can be made, that is empty or holds one of `marks`.
void require_folder(const fs::path& folder, std::initializer_list<const char*> marks,
                    const char* kind) {
  const auto refuse = [&](const std::string& why) {
    throw InputError(fmt::format("--out {}: {}", folder.string(), why));
  };
  std::error_code error;
  fs::path there = fs::absolute(folder);
  while (!fs::exists(there, error) && there.has_parent_path() && there != there.parent_path())
    there = there.parent_path();
  const bool made = fs::equivalent(there, folder, error);
  if (!fs::is_directory(there, error))
    refuse(made ? "is a file; a folder is needed"
                : fmt::format("{} is a file; a folder cannot be made in it", there.string()));
  if (access(there.c_str(), W_OK | X_OK) != 0)
    refuse(fmt::format("nothing can be written in {}: {}", there.string(), std::strerror(errno)));
  if (!made) return;
  const fs::directory_iterator entries(folder, error);
  if (error) refuse(fmt::format("cannot be read: {}", error.message()));
  if (entries == fs::directory_iterator()) return;
  for (const char* mark : marks)
    if (fs::exists(folder / mark, error)) return;
  refuse(fmt::format(
      "holds files but no {0}; name a new or an empty folder, or one that holds a {0}", kind));
}

}  // namespace

void require_run_folder(const fs::path& folder) { require_folder(folder, {"run.h5"}, "run"); }

void require_comparison_folder(const fs::path& folder) {
  require_folder(folder, {"perception/run.h5", "blind/run.h5"}, "comparison");
  for (const char* side : {"perception", "blind"}) require_run_folder(folder / side);
}

void require_plan_folder(const fs::path& folder) { require_folder(folder, {"plan.json"}, "plan"); }

void require_table_folder(const fs::path& folder, const std::string& csv) {
  require_folder(folder, {csv.c_str()}, csv.c_str());
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error)
    throw InputError(fmt::format("--out {}: cannot be made: {}", folder.string(), error.message()));
}

void write_file(const fs::path& file, const std::string& text) {
  errno = 0;
  std::ofstream out(file, std::ios::binary);
  out << text << std::flush;
  if (!out)
    throw std::runtime_error(fmt::format("cannot write {}: {}", file.string(),
                                         errno ? std::strerror(errno) : "unknown cause"));
}

}  // namespace impedraw
