// What docs/data.md promises about a run's folder, as the program's user meets it: locks, inputs,
// foreign files and links, disk space, signals.
#include <chrono>
#include <cstdlib>
#include <regex>
#include <thread>

#include <gmock/gmock.h>
#include <nlohmann/json.hpp>

#include "impedraw/common/errors.h"
#include "impedraw/log/run_data.h"
#include "impedraw/run/run_folder.h"
#include "log/made_up_run.h"
#include "process.h"
#include "scratch_folder.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;

using ::testing::Not;
using Words = std::vector<std::string>;

const Words kShort = {"--set", "path.draw_speed=0.3", "--set", "path.draw_acceleration=5"};
const Words kLong = {"--set", "path.draw_speed=0.0015"};  // 200 s of simulated time and more

std::string svg(const char* path) {
  return std::string(R"(<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" )"
                     R"(viewBox="0 0 40 40"><path fill="none" stroke="black" d=")") +
         path + "\"/></svg>\n";
}

Words operator+(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

class Data : public ScratchFolder {
 protected:
  Data() {
    fs::create_directories(folder_ / "tmp");
    setenv("TMPDIR", (folder_ / "tmp").c_str(), 1);
    write("drawing.svg", svg("M5 5H35M5 35H35"));
  }
  ~Data() override { unsetenv("TMPDIR"); }

  Ended call(const Words& arguments) const { return Process(folder_, arguments).wait(); }
  fs::path run(const char* name = "") const { return folder_ / "run" / name; }
  static Words draw(const Words& more) {
    return Words{"draw", "--svg", "drawing.svg", "--out", "run"} + more;
  }
  // Waits until the file exists and has that many bytes, or the process has ended.
  static void until(const Process& process, const fs::path& file, std::uintmax_t bytes = 0) {
    std::error_code none;
    const auto there = [&] { return fs::exists(file) && fs::file_size(file, none) >= bytes; };
    for (int i = 0; i < 60000 && process.running() && !there(); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  // A run that a signal ends while it draws.
  Ended draw_until(int signal, const Words& more = {}) const {
    Process process(folder_, draw(kLong + more));
    until(process, run("run.journal"), 4096);  // 1 kB before the first step
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    process.signal(signal);
    return process.wait();
  }
  static double time_in(const std::string& text) {
    std::smatch found;
    return std::regex_search(text, found, std::regex("t = ([0-9.]+) s")) ? std::stod(found[1])
                                                                         : -1.0;
  }
  void expect_refused(const Words& arguments, const std::vector<std::string>& said) const {
    SCOPED_TRACE(::testing::PrintToString(arguments));
    const Ended ended = call(arguments);
    EXPECT_EQ(ended.code, 2) << ended.err;
    EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << ended.err;
    for (const std::string& words : said) EXPECT_THAT(ended.err, HasSubstr(words));
  }
};

TEST_F(Data, ASecondRunIntoTheFolderIsRefused) {
  Process first(folder_, draw(kLong));
  until(first, run("inputs/drawing.svg"));
  ASSERT_TRUE(first.running());
  const std::string lock = content_of(run("run.lock"));
  std::smatch holder;
  ASSERT_TRUE(std::regex_search(lock, holder, std::regex("process [0-9]+ on .+ since [0-9]")));
  for (const Words& second :
       {draw(kShort), draw(kLong + Words{"--resume"}), Words{"report", "run"}})
    expect_refused(second, {"run: process ", " writes there", holder[0]});
  first.signal(SIGKILL);
  EXPECT_EQ(first.wait().code, 137);
  // The lock of a process that is gone is none.
  EXPECT_EQ(call(draw(kShort)).code, 0);
  EXPECT_NE(content_of(run("run.lock")), lock);
}

TEST_F(Data, AnEditedDrawingIsNoneToGoOnWith) {
  EXPECT_EQ(draw_until(SIGINT).code, 130);
  const std::size_t drawn = read_run(run("run.h5")).rows();
  write("drawing.svg", svg("M5 35H35M5 5H35"));  // two strokes swapped
  for (const Words& words :
       {draw(kLong + Words{"--resume"}), Words{"draw", "--resume", "--out", "run"}})
    expect_refused(
        words, {"drawing.svg (drawing.svg) is not the file that the run in run was started with",
                "run/inputs/drawing.svg is a copy"});
  EXPECT_EQ(read_run(run("run.h5")).rows(), drawn);
  // The copy is as good as the file, wherever the folder is.
  fs::remove(folder_ / "drawing.svg");
  fs::rename(run(), folder_ / "moved");
  Process resumed(folder_, {"draw", "--resume", "--out", "moved"});
  until(resumed, folder_ / "moved/run.journal");
  std::this_thread::sleep_for(std::chrono::milliseconds(500));
  resumed.signal(SIGTERM);
  const Ended ended = resumed.wait();
  EXPECT_EQ(ended.code, 143) << ended.err;
  EXPECT_GT(read_run(folder_ / "moved/run.h5").rows(), drawn);
}

TEST_F(Data, AReportNeedsNothingButTheFolder) {
  ASSERT_EQ(call(draw(kShort)).code, 0);
  const std::string metrics = content_of(run("metrics.json")),
                    page = content_of(run("ink_page.svg"));
  write("drawing.svg", svg("M20 0V40"));  // another file at that path
  fs::rename(run(), folder_ / "moved");
  for (const char* name : {"metrics.json", "ink_page.svg", "report.html", "scenario.yaml"})
    fs::remove(folder_ / "moved" / name);
  const Ended ended = call({"report", "moved"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(content_of(folder_ / "moved/metrics.json"), metrics);
  EXPECT_EQ(content_of(folder_ / "moved/ink_page.svg"), page);
  EXPECT_THAT(content_of(folder_ / "moved/scenario.yaml"), HasSubstr("draw_speed: 0.3"));
  write("moved/inputs/drawing.svg", svg("M20 0V40"));
  expect_refused({"report", "moved"}, {"moved/inputs/drawing.svg",
                                       "not the file that the run in "
                                       "moved was made from"});
}

TEST_F(Data, AFolderIsARunOnlyWithOurMark) {
  for (const char* text : {"", "\x89HDF\r\n\x1a\n", "anything"}) {
    write("run/run.h5", text);
    write("run/metrics.json", "mine");
    expect_refused(draw(kShort), {"run/run.h5: was not written by impedraw"});
    expect_refused(draw(kShort + Words{"--resume"}), {"run/run.h5: was not written by impedraw"});
    EXPECT_EQ(content_of(run("run.h5")), text);
    EXPECT_EQ(content_of(run("metrics.json")), "mine");
    EXPECT_FALSE(fs::exists(run("run.lock")));
  }
}

TEST_F(Data, LinksOutOfTheFolderAreNotFollowed) {
  ASSERT_EQ(call(draw(kShort)).code, 0);
  const fs::path target = write("elsewhere/target", "mine");
  for (const char* name : {"report.html", "metrics.json", "ink_top.png", "scenario.yaml"}) {
    fs::remove(run(name));
    fs::create_symlink(target, run(name));
  }
  write("run/notes.txt", "mine");
  EXPECT_EQ(call({"report", "run"}).code, 0);
  EXPECT_EQ(call(draw(kShort + Words{"--overwrite"})).code, 0);
  EXPECT_EQ(content_of(target), "mine");
  EXPECT_EQ(content_of(run("notes.txt")), "mine");
  for (const char* name : {"report.html", "metrics.json", "ink_top.png", "scenario.yaml"})
    EXPECT_FALSE(fs::is_symlink(run(name))) << name;

  fs::rename(run("run.h5"), folder_ / "elsewhere/run.h5");
  fs::create_symlink(folder_ / "elsewhere/run.h5", run("run.h5"));
  expect_refused(draw(kShort), {"run/run.h5: is a link"});
  fs::remove(run("run.h5"));
  fs::rename(folder_ / "elsewhere/run.h5", run("run.h5"));
  fs::remove(run("run.lock"));
  fs::create_symlink(target, run("run.lock"));
  expect_refused({"report", "run"}, {"run/run.lock: cannot be locked: it is a symbolic link"});
  EXPECT_EQ(content_of(target), "mine");
}

TEST_F(Data, ADiskThatIsTooSmallIsToldBefore) {
  EXPECT_NO_THROW(require_space(folder_, 1.0, 10.0));
  try {
    require_space(folder_, 1e18, 1500.0);
    FAIL() << "a million terabytes";
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr(" MB of disk are free"),
                                    HasSubstr("needs 1000000000000 MB for 1500 s of drawing"),
                                    HasSubstr("--out"), HasSubstr("log.rate=reduced")));
  }
}

TEST_F(Data, ARunThatDrewNothingStartsAnew) {
  fs::create_directories(run());
  RunLog(run("run.h5"), testing::small_header());  // as of a run that is killed at its first step
  const Ended ended = call(draw(kShort + Words{"--resume"}));
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.err,
              HasSubstr("nothing has been drawn in run yet; the run starts from the beginning"));
  EXPECT_EQ(nlohmann::json::parse(content_of(run("metrics.json"))).at("strokes_missed"), 0);
  // Nor is there a run without a folder.
  const Ended none =
      call(Words{"draw", "--svg", "drawing.svg", "--out", "new", "--resume"} + kShort);
  EXPECT_EQ(none.code, 0);
  EXPECT_THAT(none.err, HasSubstr("starts from the beginning"));
  expect_refused({"draw", "--resume", "--out", "none"}, {"none contains no run to resume"});
}

TEST_F(Data, EverySignalLiftsThePenAndTimesCountFromTheBeginning) {
  double before = 0.0;
  for (const auto& [signal, code] : {std::pair{SIGHUP, 129}, {SIGTERM, 143}, {SIGINT, 130}}) {
    SCOPED_TRACE(signal);
    const Ended ended = draw_until(signal, before > 0.0 ? Words{"--resume"} : Words{});
    EXPECT_EQ(ended.code, code);
    EXPECT_THAT(ended.err, AllOf(HasSubstr("the pen was lifted"), HasSubstr("log is kept")));
    EXPECT_GT(time_in(ended.err), before);
    before = time_in(ended.err);
    const RunData data = read_run(run("run.h5"));
    EXPECT_NEAR(data.time.back(), before + 1.0, 0.1) << "the lift takes a second";
    EXPECT_EQ(data.f.back(), 0.0);
    EXPECT_TRUE(fs::exists(run("report.html")));
  }
}

TEST_F(Data, AnEmergencyStopDampsWhereThePenIsAndLeavesAnIncident) {
  const Ended ended = draw_until(SIGQUIT);
  EXPECT_EQ(ended.code, 3) << ended.err;
  EXPECT_THAT(ended.err, HasSubstr("emergency stop at t = "));
  const RunData data = read_run(run("run.h5"));
  ASSERT_GT(data.rows(), 0u);
  EXPECT_LT(data.time.back(), time_in(ended.err) + 0.6) << "the motion is damped, not lifted";
  EXPECT_THAT(content_of(run("incident.html")), HasSubstr("emergency stop"));
  EXPECT_TRUE(fs::exists(run("metrics.json")));
}

TEST_F(Data, ASignalWhileResultsAreMadeIsSaidInOneLine) {
  for (const bool again : {false, true}) {
    SCOPED_TRACE(again);
    fs::remove(run("metrics.json"));  // written before the pictures and the page
    Process process(folder_, again ? Words{"report", "run"} : draw(kShort));
    until(process, run("metrics.json"));
    process.signal(SIGINT);
    const Ended ended = process.wait();
    EXPECT_EQ(ended.code, 130) << ended.err;
    EXPECT_THAT(ended.err, AllOf(HasSubstr("./impedraw report run finishes them"),
                                 Not(HasSubstr("Traceback"))));
    EXPECT_EQ(std::count(ended.err.begin(), ended.err.end(), '\n'), 1) << ended.err;
    EXPECT_FALSE(fs::exists(run("report.html")));
    for (const auto& entry : fs::directory_iterator(run()))
      EXPECT_THAT(entry.path().filename().string(), Not(HasSubstr("impedraw-part")));
    EXPECT_TRUE(fs::is_empty(folder_ / "tmp"));
  }
  EXPECT_EQ(call({"report", "run"}).code, 0);
  EXPECT_TRUE(fs::exists(run("report.html")));
}

}  // namespace
}  // namespace impedraw
