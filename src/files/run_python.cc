#include "impedraw/files/run_python.h"

#include <unistd.h>

#include <cstdlib>
#include <string_view>

extern char** environ;

namespace impedraw {
namespace {

namespace fs = std::filesystem;

// The folder, or a temporary one that is removed again where it cannot be written.
class CacheFolder {
 public:
  explicit CacheFolder(const fs::path& wanted) : path_(wanted) {
    if (path_.empty()) return;
    std::error_code ignored;
    fs::create_directories(path_, ignored);
    if (access(path_.c_str(), W_OK | X_OK) == 0) return;
    std::string name = (fs::temp_directory_path(ignored) / "impedraw_python_XXXXXX").string();
    if (mkdtemp(name.data()) != nullptr) path_ = scratch_ = name;
  }
  ~CacheFolder() {
    std::error_code ignored;
    if (!scratch_.empty()) fs::remove_all(scratch_, ignored);
  }
  CacheFolder(const CacheFolder&) = delete;
  CacheFolder& operator=(const CacheFolder&) = delete;

  const fs::path& path() const { return path_; }

 private:
  fs::path path_, scratch_;
};

}  // namespace

int run_python(const PythonCall& call) {
  const CacheFolder cache(call.matplotlib_folder);
  // A matplotlibrc counts if the working directory, MATPLOTLIBRC or MPLCONFIGDIR has one.
  std::vector<std::string> variables;
  for (char** variable = environ; *variable != nullptr; ++variable) {
    const std::string_view text = *variable;
    if (!text.starts_with("MPL") && !text.starts_with("MATPLOTLIB")) variables.emplace_back(text);
  }
  variables.push_back("MATPLOTLIBRC=/dev/null");
  if (!cache.path().empty()) variables.push_back("MPLCONFIGDIR=" + cache.path().string());
  std::vector<std::string> words{call.python, "-I", "-X", "utf8"};
  words.insert(words.end(), call.arguments.begin(), call.arguments.end());
  return run_child(words, call.files, call.check, variables);
}

}  // namespace impedraw
