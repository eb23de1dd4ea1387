#include "impedraw/run/run_folder.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <initializer_list>
#include <vector>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/log/log.h"
#include "impedraw/run/folder_lock.h"

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
  fs::directory_iterator entries(folder, error);
  if (error) refuse(fmt::format("cannot be read: {}", error.message()));
  // Files that a command leaves when it is killed before its first result.
  const auto left_over = [](const fs::directory_entry& entry) {
    return entry.path().filename() == kLockFile || is_unfinished(entry.path());
  };
  if (std::all_of(entries, fs::directory_iterator(), left_over)) return;
  for (const char* mark : marks)
    if (fs::exists(folder / mark, error)) return;
  refuse(fmt::format(
      "contains files but no {0}; name a new or an empty folder, or one that contains a {0}",
      kind));
}

}  // namespace

void require_run_folder(const fs::path& folder) {
  require_folder(folder, {"run.h5"}, "run");
  require_own_log(folder);
  FolderLock::require_free(folder);
}

void require_no_finished_run(const fs::path& folder) {
  std::error_code error;
  if (!fs::exists(folder / "metrics.json", error) || fs::exists(folder / "incident.html", error))
    return;
  throw InputError(
      fmt::format("--out {}: holds the results of a run; --overwrite replaces them, or name "
                  "another folder",
                  folder.string()));
}

void require_own_log(const fs::path& folder) {
  const fs::path log = folder / "run.h5";
  std::error_code error;
  if (fs::symlink_status(log, error).type() == fs::file_type::not_found) return;
  if (!is_own_file(log))
    throw InputError(fmt::format("{}: is a link or a folder; a file is needed", log.string()));
  if (!is_marked_log(log))
    throw InputError(
        fmt::format("{}: was not written by impedraw, so it is not replaced; move it away, or "
                    "name another folder",
                    log.string()));
}

void require_comparison_folder(const fs::path& folder) {
  require_folder(folder, {"perception/run.h5", "blind/run.h5"}, "comparison");
  for (const char* side : {"perception", "blind"}) require_run_folder(folder / side);
}

void require_page_folder(const fs::path& folder) {
  require_folder(folder, {"compare.html"}, "comparison");
}

void require_plan_folder(const fs::path& folder) { require_folder(folder, {"plan.json"}, "plan"); }

void require_space(const fs::path& folder, double bytes, double seconds) {
  std::error_code error;
  const fs::space_info space = fs::space(folder, error);
  if (error || static_cast<double>(space.available) >= bytes) return;
  throw InputError(fmt::format(
      "{}: {:.0f} MB of disk are free, the run needs {:.0f} MB for {:.0f} s of drawing; "
      "free some, name a folder on another disk with --out, or draw with --set "
      "log.rate=reduced",
      folder.string(), 1e-6 * static_cast<double>(space.available), 1e-6 * bytes, seconds));
}

void make_folder(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> made;
  for (fs::path at = fs::absolute(folder).lexically_normal(); !fs::exists(at, error);
       at = at.parent_path())
    made.push_back(at);
  fs::create_directories(folder, error);
  if (error)
    throw InputError(fmt::format("--out {}: cannot be made: {}", folder.string(), error.message()));
  for (const fs::path& one : made) sync_folder(one.parent_path());
  remove_unfinished(folder);  // of a command that was killed
}

}  // namespace impedraw
