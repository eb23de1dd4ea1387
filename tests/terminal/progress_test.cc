#include "impedraw/terminal/progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

namespace impedraw {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using ::testing::Not;

TEST(ProgressText, TellsTimeStrokeShareLeftAndFactor) {
  EXPECT_EQ(progress_line({12.4, 2, 5, 0.63}, 0.5),
            "drawing   12.4 s  stroke 2/5   63 %  0:00 left  25x real time");
  EXPECT_EQ(progress_line({400, 3, 5, 0.25}, 10),
            "drawing  400.0 s  stroke 3/5   25 %  0:30 left  40x real time");
  EXPECT_EQ(progress_line({12.4, 2, 5, 0.63, 0.312, 0.46}, 0.5),
            "drawing   12.4 s  stroke 2/5  0.31/0.46 m   63 %  0:00 left  25x real time");
  EXPECT_THAT(progress_line({12.4, 2, 5, 0.63, 0.312, 0.46, true}, 0.5),
              HasSubstr("again     12.4 s  stroke 2/5"));
  EXPECT_THAT(progress_line({0, 0, 1, 0}, 0), HasSubstr("stroke 0/1    0 %  -:-- left"));
  EXPECT_THAT(progress_line({1, 1, 1, 0.999}, 1), HasSubstr(" 99 %")) << "100 % is when it is done";
  EXPECT_THAT(progress_line({1, 1, 1, 1}, 1), HasSubstr("100 %  0:00 left"));
  EXPECT_THAT(progress_line({1, 1, 1, 7}, 1), HasSubstr("100 %"));
  EXPECT_EQ(progress_line({12.4, 2, 5, 0.63}, 1, 20).size(), 20u);
  EXPECT_EQ(progress_line({12.4, 2, 5, 0.63}, 1, -1), "");
}

TEST(ProgressText, OfWorkBeforeTheDrawing) {
  EXPECT_EQ(step_line("placing the canvas", 0.25, 1.0), "placing the canvas   25 %  0:03 left");
  EXPECT_EQ(step_line("checking the strokes", 0.0, 5.0), "checking the strokes    0 %  -:-- left");
}

TEST(ProgressText, Clock) {
  EXPECT_EQ(clock_text(7.4), "0:07");
  EXPECT_EQ(clock_text(59.6), "1:00");
  EXPECT_EQ(clock_text(754), "12:34");
  EXPECT_EQ(clock_text(3723), "1:02:03");
  EXPECT_EQ(clock_text(-3), "0:00");
}

class ProgressOutput : public ::testing::Test {
 protected:
  ProgressOutput() : file_(std::tmpfile()) {}
  ~ProgressOutput() override { std::fclose(file_); }

  std::string printed() const {
    std::rewind(file_);
    std::string text(100000, '\0');
    text.resize(std::fread(text.data(), 1, text.size(), file_));
    return text;
  }

  std::FILE* file_;
  ProgressLine::Clock::time_point start_{};
};

TEST_F(ProgressOutput, IsRedrawnTenTimesASecondAtMost) {
  {
    ProgressLine line(file_, true, start_);
    for (int i = 0; i < 1000; ++i) line.draw({i * 1e-3, 1, 1, i * 1e-3}, start_ + i * 1ms);
    const std::string text = printed();
    EXPECT_EQ(std::count(text.begin(), text.end(), '\r'), 10);
    EXPECT_THAT(text, Not(HasSubstr("\n")));
  }
  const std::string text = printed();
  EXPECT_EQ(text.substr(text.size() - 4), "\r\x1b[K") << "its end wipes the line";
}

TEST_F(ProgressOutput, NothingWhereThereIsNoTerminal) {
  {
    ProgressLine line(file_);
    for (int i = 0; i < 10; ++i) line.draw({}, start_ + i * 1s);
    line.update({});
    line.wipe();
  }
  EXPECT_EQ(printed(), "");
}

}  // namespace
}  // namespace impedraw
