// A program run as a user would, its output kept.
#pragma once

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace impedraw {

inline std::string content_of(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

struct Ended {
  int code;  // 128 + the signal that ended it, else its exit code
  std::string out, err;
};

class Process {
 public:
  // In the working directory `folder`, which its output is kept in, too.
  Process(const std::filesystem::path& folder, const std::vector<std::string>& arguments)
      : out_(folder / ".stdout"), err_(folder / ".stderr") {
    pid_ = fork();
    if (pid_ == 0) {
      redirect(out_, STDOUT_FILENO);
      redirect(err_, STDERR_FILENO);
      start(folder, arguments);
    }
  }
  void signal(int number) const { kill(pid_, number); }
  bool running() const {
    siginfo_t ended{};
    return waitid(P_PID, static_cast<id_t>(pid_), &ended, WEXITED | WNOHANG | WNOWAIT) == 0 &&
           ended.si_pid == 0;
  }
  Ended wait() {
    int status = 0;
    waitpid(pid_, &status, 0);
    return {WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status), content_of(out_),
            content_of(err_)};
  }

  [[noreturn]] static void start(const std::filesystem::path& folder,
                                 const std::vector<std::string>& arguments) {
    std::vector<char*> argv{const_cast<char*>(IMPEDRAW)};
    for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    // What started the tests may ignore them, and so would the program.
    for (const int s : {SIGINT, SIGTERM, SIGHUP}) std::signal(s, SIG_DFL);
    if (chdir(folder.c_str()) == 0) execv(IMPEDRAW, argv.data());
    _exit(127);
  }

 private:
  static void redirect(const std::filesystem::path& file, int to) {
    dup2(open(file.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600), to);
  }

  std::filesystem::path out_, err_;
  pid_t pid_ = -1;
};

}  // namespace impedraw
