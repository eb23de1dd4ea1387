// report.html and compare.html: they stand alone, and hold what they must.
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <regex>

#include <gtest/gtest.h>

#include "impedraw/metrics/metrics.h"
#include "impedraw/report/picture.h"
#include "impedraw/report/report.h"
#include "log/made_up_folder.h"

namespace impedraw {
namespace {

using testing::text_of;
using PagesTest = testing::MadeUpFolder;

// No page may reach for anything outside itself.
void expect_stands_alone(const std::string& page) {
  const std::regex reference(
      R"re((?:src|href|xlink:href)="(?!data:|#)[^"]*"|<script|<link|@import|url\((?!#))re");
  std::smatch found;
  EXPECT_FALSE(std::regex_search(page, found, reference)) << found[0];
}

TEST_F(PagesTest, ReportStandsAloneAndHoldsEveryMetric) {
  const RunData run = made_up({}, folder_);
  const InkMatch drawn = match_ink(run);
  write_ink_top(run, drawn, folder_ / "ink_top");
  std::ofstream(folder_ / "scenario.yaml") << "speed: 50 # <mm/s> & more\n";
  write_report(folder_, run, drawn, compute_metrics(run, drawn),
               {.title = "A <title>", .limits = {{"ink_error_rms", {.most = 0.001}}}});
  const std::string page = text_of(folder_ / "report.html");
  EXPECT_LT(page.size(), 10u << 20);
  expect_stands_alone(page);
  for (const MetricDefinition& d : metric_definitions())
    EXPECT_NE(page.find(std::string("<code>") + d.name), std::string::npos) << d.name;
  EXPECT_NE(page.find("A &lt;title&gt;"), std::string::npos);
  EXPECT_NE(page.find("speed: 50 # &lt;mm/s&gt; &amp; more"), std::string::npos);
  EXPECT_NE(page.find("class=\"n bad\""), std::string::npos) << "the missed limit must show";
  EXPECT_THROW(
      write_report(folder_, run, drawn, compute_metrics(run, drawn), {.python = "/no/such/python"}),
      std::runtime_error);
}

TEST_F(PagesTest, ComparisonShowsBothRuns) {
  made_up({}, folder_ / "a");
  made_up({.perception = false}, folder_ / "b");
  write_comparison({"with perception", folder_ / "a"}, {"without", folder_ / "b"}, folder_);
  const std::string page = text_of(folder_ / "compare.html");
  expect_stands_alone(page);
  EXPECT_LT(page.size(), 10u << 20);
  for (const char* text : {"with perception", "without", "tilt_mean", "no cloud"})
    EXPECT_NE(page.find(text), std::string::npos) << text;
  EXPECT_GT(std::filesystem::file_size(folder_ / "compare.png"), 20000u);
}

TEST_F(PagesTest, ARunWithoutAnythingStillGetsItsPage) {
  RunLogHeader header = testing::small_header();
  RunLog log(folder_ / "run.h5", header);
  log.append(testing::numbered_row(0));
  log.close();
  RunData run = read_run(folder_ / "run.h5");
  run.stroke[0] = -1;
  const InkMatch drawn = match_ink(run);
  write_ink_top(run, drawn, folder_ / "ink_top");
  write_report(folder_, run, drawn, compute_metrics(run, drawn));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "report.html"));
}

// The user's surroundings as they are when a test begins, back in place when it ends.
class Surroundings {
 public:
  Surroundings() {
    for (const char* name : {"HOME", "LC_ALL", "LOCPATH", "MPLCONFIGDIR", "MATPLOTLIBRC"})
      variables_.emplace_back(name, std::getenv(name) ? std::getenv(name) : "");
  }
  ~Surroundings() {
    std::filesystem::current_path(folder_);
    std::signal(SIGCHLD, SIG_DFL);
    for (const auto& [name, value] : variables_)
      value.empty() ? unsetenv(name) : setenv(name, value.c_str(), 1);
  }

 private:
  std::filesystem::path folder_ = std::filesystem::current_path();
  std::vector<std::pair<const char*, std::string>> variables_;
};

TEST_F(PagesTest, DoNotDependOnTheSurroundings) {
  const RunData run = made_up({}, folder_ / "run");
  const InkMatch drawn = match_ink(run);
  const auto page = [&](const std::filesystem::path& folder) {
    write_report(folder, run, drawn, compute_metrics(run, drawn), {.title = "Zürich → 東京"});
    return text_of(folder / "report.html");
  };
  std::ofstream(folder_ / "run/scenario.yaml") << "name: Zürich → 東京\n";
  const std::string plain = page(folder_ / "run");
  EXPECT_NE(plain.find("Zürich → 東京"), std::string::npos);

  const Surroundings surroundings;
  const std::filesystem::path home = folder_ / "home";
  std::filesystem::create_directories(home);
  std::filesystem::current_path(folder_);
  std::ofstream("matplotlibrc") << "font.size: 30\nsvg.fonttype: \xff\n";
  const std::string localedef = "localedef -i en_US -f ISO-8859-1 " + (folder_ / "latin1").string();
  const bool latin = std::system((localedef + " 2>/dev/null").c_str()) == 0;
  setenv("LOCPATH", folder_.c_str(), 1);
  setenv("LC_ALL", latin ? "latin1" : "C", 1);
  setenv("HOME", home.c_str(), 1);
  setenv("MATPLOTLIBRC", folder_.c_str(), 1);
  unsetenv("MPLCONFIGDIR");
  EXPECT_EQ(page("run"), plain);  // a relative folder, too
  EXPECT_TRUE(std::filesystem::is_empty(home));
}

// Ignored, SIGCHLD leaves no exit code of the page's process.
TEST_F(PagesTest, AFailureIsAnErrorWhateverHappensToSigchld) {
  const RunData run = made_up({}, folder_);
  const InkMatch drawn = match_ink(run);
  const Surroundings surroundings;
  std::signal(SIGCHLD, SIG_IGN);
  EXPECT_THROW(
      write_report(folder_, run, drawn, compute_metrics(run, drawn), {.python = "/bin/false"}),
      std::runtime_error);
}

}  // namespace
}  // namespace impedraw
