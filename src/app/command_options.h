// The commands' names, options and help.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "impedraw/app/commands.h"
#include "impedraw/report/report.h"

namespace CLI {
class App;
}

namespace impedraw {

// The arguments as read, and the exit code of the command that they name.
struct Call {
  DrawOptions options;
  LiveOptions live;
  PlaceOptions by_hand;
  FilmOptions filmed;
  JudgeForceOptions judged;
  PenOnFlange pen;
  SettingsForm form = SettingsForm::users;
  std::filesystem::path commissioned, region, folder, inspected, arm_file;
  std::filesystem::path commissioning = "commissioning";
  std::vector<std::filesystem::path> compared;
  std::string unit, bare_arm, flange, mark;
  bool table = false, plan_json = false, plan_suggest = false, as_json = false;
  int poses = 8;
  double arm_seconds = 2.0, watch_seconds = 20.0;
  int code = 0;
};

void add_set(CLI::App* command, DrawOptions* options, const char* help);  // --set
void add_arm(CLI::App& app, Call& call);                                  // arm check, hold, …
// Adds all commands to `app`; the one that is called fills `call`, which must outlive it, in.
// Returns those whose options must have a value.
std::vector<CLI::App*> add_commands(CLI::App& app, Call& call, int argc, char** argv);

}  // namespace impedraw
