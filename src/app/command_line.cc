#include "impedraw/app/command_line.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <sstream>
#include <string>
#include <system_error>
#include <vector>

#include <CLI/CLI.hpp>

#include "impedraw/app/command_options.h"
#include "impedraw/common/errors.h"
#include "impedraw/settings/settings_text.h"
#include "impedraw/terminal/interrupt.h"
#include "impedraw/terminal/say.h"

namespace impedraw {
namespace {

// Some libraries' messages are longer.
std::string one_line(std::string text) {
  while (!text.empty() && std::isspace(static_cast<unsigned char>(text.back()))) text.pop_back();
  std::replace(text.begin(), text.end(), '\n', ' ');
  return text;
}

// Names and texts from here end up in JSON and HTML, which hold UTF-8 alone.
void require_utf8(int argc, char** argv) {
  for (int i = 1; i < argc; ++i)
    if (!is_utf8(argv[i]))
      throw InputError(fmt::format("argument '{}' is not valid UTF-8", printable(argv[i])));
  std::error_code error;
  const std::string folder = std::filesystem::current_path(error).string();
  if (!error && !is_utf8(folder))
    throw InputError(fmt::format("the name of the working directory, {}, is not valid UTF-8",
                                 printable(folder)));
}

// The rest of the buffer may find a full disk.
int flushed(int code) {
  errno = 0;
  if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return code;
  say(stderr, "impedraw: cannot write to the standard output: {}\n",
      errno != 0 ? std::strerror(errno) : "an earlier write failed");
  return kStopped;
}

int fail(const std::string& what, int code) {
  std::fflush(stdout);
  say(stderr, "impedraw: {}\n", one_line(what));
  return code;
}

// CLI11 fills the lines of a footer anew from version 2.5 on, and examples are no paragraph.
template <class Formatter>
void keep_lines_of_footers(Formatter& formatter) {
  if constexpr (requires { formatter.enable_footer_formatting(false); })
    formatter.enable_footer_formatting(false);
}

int run_program(int argc, char** argv) {
  CLI::App app(
      "impedraw: a pen on a simulated robot arm draws on unknown curved surfaces, held there by "
      "operational-space impedance control.");
  keep_lines_of_footers(*app.get_formatter());
  app.name("./impedraw");
  app.set_version_flag("--version", "impedraw " IMPEDRAW_VERSION, "print the version");
  app.require_subcommand(1);
  app.footer(
      "Each command has its own help with examples: ./impedraw draw --help\n"
      "Beside them, ./impedraw runs many drawings (sweep, robustness, reach), measures the figures "
      "of the documentation (figures), builds it (docs) and the Python package (wheel), and says "
      "what is installed (doctor).");
  app.failure_message(CLI::FailureMessage::simple);
  Call call;
  const std::vector<CLI::App*> checked = add_commands(app, call, argc, argv);
  for (CLI::App* command : checked)
    for (CLI::Option* option : command->get_options())
      if (option->get_items_expected_max() > 0)
        option->check(
            [](const std::string& text) {
              return text.empty() ? std::string("a value is missing") : std::string();
            },
            "", "");

  require_utf8(argc, argv);
  if (argc < 2) {
    say(stderr, "{}", app.help());
    return kBadInput;
  }
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands(nullptr))
    commands.push_back(command->get_name());
  const std::string first = argv[1];
  const bool known = std::find(commands.begin(), commands.end(), first) != commands.end();
  if (!known && !first.starts_with('-')) throw InputError("command " + not_among(first, commands));
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // help or the version was asked for
      std::ostringstream text;
      app.exit(error, text);
      say(stdout, "{}", text.str());
      return kFinished;
    }
    return fail(fmt::format("{}; see ./impedraw {}--help", one_line(error.what()),
                            known ? first + " " : ""),
                kBadInput);
  }
  return call.code;
}

}  // namespace

int command_line(int argc, char** argv) {
  // A file opened under the number of a closed stream would receive what is printed.
  for (int stream = 0; stream < 3; ++stream)
    if (fcntl(stream, F_GETFD) < 0) open("/dev/null", O_RDWR);
  std::signal(SIGXFSZ, SIG_IGN);  // a file beyond its limit is an error like a full disk
  std::signal(SIGCHLD, SIG_DFL);  // ignored, it would hide how a child process ended
  try {
    return flushed(run_program(argc, argv));
  } catch (const Interrupted& error) {
    return fail(error.what(), error.exit_code());
  } catch (const InputError& error) {
    return fail(error.what(), kBadInput);
  } catch (const std::filesystem::filesystem_error& error) {
    if (error.code() != std::errc::filename_too_long) return fail(error.what(), kStopped);
    return fail(
        fmt::format("{}: the name is too long; a file system takes names of up to 255 bytes",
                    shown(error.path1().string())),
        kBadInput);
  } catch (const std::exception& error) {
    return fail(error.what(), kStopped);
  }
}

}  // namespace impedraw
