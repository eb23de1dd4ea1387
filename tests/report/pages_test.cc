// report.html and compare.html: they stand alone, and hold what they must.
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <regex>

#include <gtest/gtest.h>
#include <zlib.h>
#include <nlohmann/json.hpp>

#include "impedraw/metrics/metrics.h"
#include "impedraw/report/picture.h"
#include "impedraw/report/report.h"
#include "log/made_up_folder.h"
#include "log/run_columns.h"

namespace impedraw {
namespace {

using testing::text_of;
using PagesTest = testing::MadeUpFolder;

// The parts of a page: what the browser reads, and the program's data.
struct Page {
  std::string markup;  // without program, style and data
  nlohmann::json json;
  std::string columns;
};

// Of several runs compared, `which` counts from 0.
Page read_page(const std::filesystem::path& file, int which = 0) {
  const std::string text = text_of(file);
  static const std::string kOpen = "<script type=\"application/octet-stream\" id=\"data\">";
  const std::size_t begin = text.find(kOpen), end = text.find("</script>", begin),
                    style = text.find("<style>"), style_end = text.find("</style>", style);
  Page page;
  page.markup = text.substr(0, style) + text.substr(style_end, begin - style_end);
  std::string bytes;
  std::uint32_t three = 0;
  int digits = 0;
  std::size_t first = begin + kOpen.size();
  for (int k = 0; k < which; ++k) first = text.find(',', first) + 1;
  EXPECT_LT(first, end);
  for (std::size_t i = first; i < end && text[i] != '=' && text[i] != ','; ++i) {
    static const std::string kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    three = three << 6 | static_cast<std::uint32_t>(kDigits.find(text[i]));
    if (++digits % 4 != 1) bytes += static_cast<char>(three >> (6 - 2 * ((digits - 1) % 4)) & 255);
  }
  std::string data(64 << 20, '\0');
  uLongf size = data.size();
  EXPECT_EQ(uncompress(reinterpret_cast<Bytef*>(data.data()), &size,
                       reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()),
            Z_OK);
  std::uint32_t length = 0;
  for (int k = 3; k >= 0; --k) length = length << 8 | static_cast<unsigned char>(data[k]);
  page.json = nlohmann::json::parse(data.substr(4, length));
  page.columns = data.substr(4 + length, size - 4 - length);
  return page;
}

// No page may reach for anything outside itself.
void expect_stands_alone(const Page& page) {
  const std::regex reference(R"re((?:src|href)=|<link|@import|url\()re");
  EXPECT_FALSE(std::regex_search(page.markup, reference)) << page.markup;
  EXPECT_NE(page.markup.find("default-src 'none'"), std::string::npos);
}

// The values of a packed column, by the description in page_json.h.
std::vector<double> unpacked(const Page& page, const nlohmann::json& how) {
  const std::size_t n = how["n"], at = how["at"];
  std::vector<long long> k(n);
  for (std::size_t i = 0; i < n; ++i) {
    unsigned long long code = 0;
    for (int plane = how["planes"]; plane-- > 0;)
      code = code << 8 | static_cast<unsigned char>(page.columns[at + plane * n + i]);
    k[i] = code & 1 ? -static_cast<long long>(code / 2) - 1 : static_cast<long long>(code / 2);
  }
  for (int pass = 0; pass < how["order"]; ++pass)
    for (std::size_t i = 1; i < n; ++i) k[i] += k[i - 1];
  std::vector<double> values;
  for (const long long x : k) values.push_back(static_cast<double>(x) * double(how["quantum"]));
  return values;
}

TEST_F(PagesTest, ReportStandsAloneAndHoldsEveryMetric) {
  const RunData run = made_up({}, folder_);
  const InkMatch drawn = match_ink(run);
  ink_top(run, drawn).write(folder_ / "ink_top");
  std::ofstream(folder_ / "scenario.yaml") << "speed: 50 # <mm/s> & more\n";
  write_report(folder_, run, drawn, compute_metrics(run, drawn),
               {.title = "A <title>", .limits = {{"ink_error_rms", {.most = 0.001}}}});
  const Page page = read_page(folder_ / "report.html");
  EXPECT_LT(std::filesystem::file_size(folder_ / "report.html"), 2u << 20);
  expect_stands_alone(page);
  EXPECT_NE(page.markup.find("A &lt;title&gt;"), std::string::npos);
  EXPECT_EQ(page.json["title"], "A <title>");
  EXPECT_EQ(page.json["scenario"], "speed: 50 # <mm/s> & more\n");
  EXPECT_EQ(page.json["pictures"].size(), 1u);
  EXPECT_EQ(page.json["limits"]["ink_error_rms"]["max"], 0.001);
  for (const MetricDefinition& d : metric_definitions())
    EXPECT_TRUE(page.json["metrics"].contains(d.name)) << d.name;
}

TEST_F(PagesTest, ReplayHoldsTheRowsOfTheLog) {
  const RunData run = made_up({}, folder_);
  const InkMatch drawn = match_ink(run);
  write_report(folder_, run, drawn, compute_metrics(run, drawn));
  const RunRows rows = read_rows(folder_ / "run.h5");
  const Page page = read_page(folder_ / "report.html");
  const auto& scene = page.json["scene"];
  const std::vector<double> time = unpacked(page, scene["time"]),
                            q = unpacked(page, scene["joints"][1]),
                            x = unpacked(page, scene["tip"][0]);
  ASSERT_GT(time.size(), rows.rows() / 11);
  std::size_t row = 0;
  for (std::size_t i = 0; i < time.size(); ++i) {
    while (rows.time[row] < time[i] - 0.6e-3) ++row;
    ASSERT_NEAR(rows.time[row], time[i], 0.51e-3);
    EXPECT_NEAR(rows.joint_position(static_cast<Eigen::Index>(row), 1), q[i], 0.51e-5);
    EXPECT_NEAR(rows.tip_position[row].x(), x[i], 0.51e-5);
  }
  EXPECT_EQ(row + 1, rows.rows()) << "the last row is shown";
  EXPECT_TRUE(page.json["complete"]);
  EXPECT_TRUE(page.json["closed"]);
  // A plot shows the extremes of all steps.
  const auto& force = page.json["step_plots"]["series"][0];
  ASSERT_EQ(force["name"], "force");
  const std::vector<double> shown =
      unpacked(page, force.contains("high") ? force["high"] : force["low"]);
  EXPECT_NEAR(*std::max_element(shown.begin(), shown.end()),
              *std::max_element(run.f.begin(), run.f.end()), 0.51e-3);
}

TEST_F(PagesTest, ComparisonShowsAllRuns) {
  made_up({}, folder_ / "a");
  made_up({.perception = false}, folder_ / "b");
  write_comparison({{"with <perception>", folder_ / "a"}, {"without", folder_ / "b"}}, folder_);
  const Page a = read_page(folder_ / "compare.html"), b = read_page(folder_ / "compare.html", 1);
  expect_stands_alone(a);
  EXPECT_LT(std::filesystem::file_size(folder_ / "compare.html"), 4u << 20);
  EXPECT_EQ(a.json["name"], "with <perception>");
  EXPECT_EQ(b.json["name"], "without");
  EXPECT_TRUE(a.json["metrics"]["cloud_bias_mean"].is_number());
  EXPECT_TRUE(b.json["metrics"]["cloud_bias_mean"].is_null());
  EXPECT_GT(std::filesystem::file_size(folder_ / "compare.png"), 20000u);
  // Each run alone is as its report shows it.
  const RunData run = read_run(folder_ / "b/run.h5");
  const InkMatch drawn = match_ink(run);
  write_report(folder_ / "b", run, drawn, compute_metrics(run, drawn));
  const Page alone = read_page(folder_ / "b/report.html");
  EXPECT_EQ(unpacked(b, b.json["scene"]["joints"][1]),
            unpacked(alone, alone.json["scene"]["joints"][1]));
}

TEST_F(PagesTest, ARunWithoutAnythingStillGetsItsPage) {
  RunLogHeader header = testing::small_header();
  RunLog log(folder_ / "run.h5", header);
  log.append(testing::numbered_row(0));
  log.close();
  RunData run = read_run(folder_ / "run.h5");
  run.stroke[0] = -1;
  const InkMatch drawn = match_ink(run);
  ink_top(run, drawn).write(folder_ / "ink_top");
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
    write_comparison({{"東京", folder}, {"東京", folder}}, folder);
    return text_of(folder / "report.html") + text_of(folder / "compare.html");
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

}  // namespace
}  // namespace impedraw
