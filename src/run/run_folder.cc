#include "impedraw/run/run_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <ctime>
#include <initializer_list>
#include <sstream>
#include <thread>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "impedraw/common/text_fields.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/settings/yaml_write.h"

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
    const fs::path name = entry.path().filename();
    return name == kLockFile || name == kCoverLines || is_unfinished(entry.path());
  };
  if (std::all_of(entries, fs::directory_iterator(), left_over)) return;
  for (const char* mark : marks)
    if (fs::exists(folder / mark, error)) return;
  refuse(fmt::format(
      "contains files but no {0}; name a new or an empty folder, or one that contains a {0}",
      kind));
}

// Closes the lock's file and throws.
[[noreturn]] void refuse_held(const fs::path& folder, int file) {
  std::array<char, 256> text{};
  const ssize_t n = pread(file, text.data(), text.size(), 0);
  std::string holder(text.data(), n > 0 ? static_cast<std::size_t>(n) : 0);
  while (!holder.empty() && holder.back() == '\n') holder.pop_back();
  close(file);
  throw InputError(
      fmt::format("{}: {} writes there; wait until it has ended, or name another folder with --out",
                  folder.string(), holder.empty() ? "another process" : holder));
}

// Returns false if another process holds the lock. A file system without locks has no other
// process either, as far as anyone can tell.
bool try_lock(int file, int kind) {
  return flock(file, kind | LOCK_NB) == 0 || errno != EWOULDBLOCK;
}

std::string this_process() {
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  const std::time_t now = std::time(nullptr);
  return fmt::format("process {} on {} since {:%Y-%m-%d %H:%M:%S} UTC\n", getpid(), host.data(),
                     fmt::gmtime(now));
}

constexpr const char* kSettings = "settings";
constexpr const char* kInputs = "inputs";

// In inputs/. Two inputs may have the same name in different folders.
std::string name_of(const std::vector<KeptInput>& inputs, const KeptInput& input) {
  const std::string name = input.file.filename().string();
  for (const KeptInput& earlier : inputs) {
    if (&earlier == &input) break;
    if (earlier.file.filename() == input.file.filename()) return input.setting + "-" + name;
  }
  return name;
}

struct Recorded {
  std::string sha256;
  fs::path copy;
};

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

FolderLock::FolderLock(const fs::path& folder) {
  const fs::path path = folder / kLockFile;
  file_ = open(path.c_str(), O_RDWR | O_CREAT | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (file_ < 0)
    throw InputError(fmt::format("{}: cannot be locked: {}", path.string(),
                                 errno == ELOOP ? "it is a symbolic link" : std::strerror(errno)));
  // require_free() of another process holds the lock for an instant.
  for (int i = 0; !try_lock(file_, LOCK_EX); ++i) {
    if (i == 5) refuse_held(folder, file_);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  const std::string text = this_process();
  if (ftruncate(file_, 0) != 0 || pwrite(file_, text.data(), text.size(), 0) < 0) {
    // A full disk: the lock holds without a name.
  }
}

FolderLock::~FolderLock() { close(file_); }

void FolderLock::require_free(const fs::path& folder) {
  const int file = open((folder / kLockFile).c_str(), O_RDONLY | O_NOFOLLOW | O_CLOEXEC);
  if (file < 0) return;
  if (!try_lock(file, LOCK_SH)) refuse_held(folder, file);
  close(file);
}

std::map<std::string, std::string> record_of(const Scenario& scenario,
                                             const std::vector<KeptInput>& inputs) {
  std::map<std::string, std::string> record = {{kSettings, settings_yaml(scenario)}};
  for (const KeptInput& input : inputs)
    record["input " + input.setting] = input.sha256 + " " + name_of(inputs, input);
  return record;
}

void write_inputs(const fs::path& folder, const Scenario& scenario,
                  const std::vector<KeptInput>& inputs) {
  write_whole(folder / "scenario.yaml", settings_yaml(scenario));
  const fs::path copies = folder / kInputs;
  std::error_code error;
  const fs::file_type type = fs::symlink_status(copies, error).type();
  if (type != fs::file_type::not_found && type != fs::file_type::directory)
    throw InputError(fmt::format("{}: is a link or a file; a folder is needed", copies.string()));
  make_folder(copies);
  for (const KeptInput& input : inputs) write_whole(copies / name_of(inputs, input), input.content);
}

Scenario recorded_scenario(const fs::path& folder, Places* places) {
  Scenario scenario;
  const fs::path file = folder / "scenario.yaml";
  const auto attributes = log_attributes(folder / "run.h5");
  if (const auto settings = attributes.find(kSettings); settings != attributes.end()) {
    read_yaml_text(settings->second, (folder / "run.h5").string(), folder, described(scenario),
                   *places);
  } else {
    *places = read_settings(scenario, file);
  }
  return scenario;
}

void require_same_settings(const Scenario& scenario, const fs::path& folder) {
  Places places;
  std::istringstream now(settings_yaml(scenario)),
      then(settings_yaml(recorded_scenario(folder, &places)));
  const auto setting = [](std::string_view line) {
    return trimmed(line.substr(0, line.find(" #")));
  };
  for (std::string a, b; std::getline(then, a) && std::getline(now, b);)
    if (setting(a) != setting(b))
      throw InputError(
          fmt::format("--resume: the run in {} was started with '{}', now it is '{}'; use the same "
                      "settings, or only --out",
                      folder.string(), setting(a), setting(b)));
}

void find_inputs(Scenario* scenario, const fs::path& folder, InputsFrom from) {
  std::map<std::string, Recorded> recorded;
  for (const auto& [key, text] : log_attributes(folder / "run.h5")) {
    if (!key.starts_with("input ") || text.size() < 66) continue;
    // Only a name: a log is no reason to read a file elsewhere.
    recorded[key.substr(6)] = {text.substr(0, 64),
                               folder / kInputs / fs::path(text.substr(65)).filename()};
  }
  const bool urdf_given = !scenario->arm.urdf.empty();
  bool urdf_moved = false;
  visit_input_files(*scenario, [&](const std::string& setting, fs::path& file) {
    const auto found = recorded.find(setting);
    if (found == recorded.end()) return;
    const auto& [hash, copy] = found->second;
    const bool copied = is_own_file(copy);
    std::error_code error;
    const bool there = fs::exists(file, error);
    const fs::path taken = from == InputsFrom::originals ? (there || !copied ? file : copy)
                                                         : (copied || !there ? copy : file);
    if (sha256_of_file(taken) != hash)
      throw InputError(
          from == InputsFrom::originals
              ? fmt::format(
                    "--resume: {} ({}) is not the file that the run in {} was started with{}; "
                    "draw the changed one into a new folder",
                    taken.string(), setting, folder.string(),
                    copied && taken != copy ? ", of which " + copy.string() + " is a copy" : "")
              : fmt::format("{} ({}) is missing or not the file that the run in {} was made from",
                            taken.string(), setting, folder.string()));
    if (setting == "arm.urdf") urdf_moved = taken != file;
    file = taken;
  });
  if (!urdf_given && !urdf_moved) scenario->arm.urdf.clear();
}

}  // namespace impedraw
