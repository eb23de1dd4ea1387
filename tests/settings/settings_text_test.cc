#include "impedraw/settings/settings_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <functional>
#include <random>

namespace impedraw {
namespace {

using ::testing::HasSubstr;

// What parse_number says of text; "" when it took it.
template <class T>
std::string complaint(std::string_view text, Range range = Range::any(),
                      std::string_view unit = "") {
  T value = 42;
  const auto wrong = parse_number(text, range, unit, value);
  if (wrong) {
    EXPECT_EQ(value, T(42)) << "a refused text changed the value";
  }
  return wrong.value_or("");
}

TEST(ParseNumber, TakesWhatIsANumber) {
  const std::pair<const char*, double> cases[] = {
      {"3", 3}, {"-0.5", -0.5}, {"+2", 2}, {"1e-3", 1e-3}, {".5", 0.5}, {"5.", 5}, {"1E3", 1000}};
  for (const auto& [text, expected] : cases) {
    double value = 0;
    EXPECT_EQ(parse_number(text, Range::any(), "", value), std::nullopt) << text;
    EXPECT_EQ(value, expected) << text;
  }
  int whole = 0;
  EXPECT_EQ(parse_number("-7", Range::any(), "", whole), std::nullopt);
  EXPECT_EQ(whole, -7);
  std::uint64_t seed = 0;
  EXPECT_EQ(parse_number("18446744073709551615", Range::any(), "", seed), std::nullopt);
  EXPECT_EQ(seed, ~std::uint64_t{0});
}

TEST(ParseNumber, RefusesEverythingThatIsNotFinite) {
  for (const char* text : {"nan", ".nan", "NaN", ".NaN", "-nan", "inf", ".inf", "-.inf", "+.inf",
                           "Infinity", "-infinity", ".Inf", "1e999", "-1e999"}) {
    EXPECT_NE(complaint<double>(text), "") << text;
    EXPECT_NE(complaint<int>(text), "") << text;
  }
}

TEST(ParseNumber, RefusesWhatIsNoNumber) {
  for (const char* text : {"", " ", "abc", "1.2.3", "5 N", "1,5", "0x10", "--3", "+-3", "1e",
                           "true", "~", "nan(1)", "1_000"}) {
    EXPECT_NE(complaint<double>(text), "") << '"' << text << '"';
    EXPECT_NE(complaint<int>(text), "") << '"' << text << '"';
  }
  for (const char* text : {"3.5", "1e-3", "0.5"})
    EXPECT_THAT(complaint<int>(text), HasSubstr("not a whole number")) << text;
}

TEST(ParseNumber, TakesWholeNumbersHoweverTheyAreWritten) {
  for (const auto& [text, expected] :
       {std::pair{"3.0", 3}, {"1e3", 1000}, {"-2E2", -200}, {"+1.5e1", 15}, {"1e9", 1000000000}}) {
    int value = 0;
    EXPECT_EQ(parse_number(text, Range::any(), "", value), std::nullopt) << text;
    EXPECT_EQ(value, expected) << text;
  }
  EXPECT_THAT(complaint<int>("1e10"), HasSubstr("is 1e10, allowed is"));
  EXPECT_THAT(complaint<int>("1e400"), HasSubstr("1e400"));
  EXPECT_THAT(complaint<int>("1e3", {0, 50}), HasSubstr("is 1e3, allowed is 0 to 50"));
}

TEST(ParseNumber, NamesValueLimitsAndUnit) {
  EXPECT_EQ(complaint<double>("70", {0, 50}, "N"), "is 70 N, allowed is 0 to 50 N");
  EXPECT_EQ(complaint<double>("50", {0, 50}, "N"), "");
  EXPECT_EQ(complaint<double>("0", Range::positive(), "s"), "is 0 s, allowed is more than 0 s");
  EXPECT_EQ(complaint<double>("-1", Range::at_least(0), ""), "is -1, allowed is at least 0");
  EXPECT_EQ(complaint<double>("2", Range::at_most(1), "m"), "is 2 m, allowed is at most 1 m");
  EXPECT_EQ(complaint<double>("1", {0, 1, false, true}, ""),
            "is 1, allowed is at least 0 and less than 1");
  EXPECT_EQ(complaint<double>("abc", {0, 50}, "N"), "is 'abc', which is not a number (of N)");
  EXPECT_EQ(complaint<int>("3000000000"), "is 3000000000, allowed is -2147483648 to 2147483647");
  EXPECT_EQ(complaint<unsigned>("-1", {0, 9}), "is -1, allowed is 0 to 9");
  EXPECT_THAT(complaint<std::uint64_t>("99999999999999999999999"), HasSubstr("allowed is"));
}

TEST(NumberText, ReadsBackAsTheSameBits) {
  const unsigned seed = 7;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  for (int i = 0; i < 20000; ++i) {
    const std::uint64_t bits = random();
    double x = 0, back = 0;
    std::memcpy(&x, &bits, sizeof x);
    if (!std::isfinite(x)) continue;
    ASSERT_EQ(parse_number(number_text(x), Range::any(), "", back), std::nullopt) << number_text(x);
    ASSERT_EQ(std::memcmp(&x, &back, sizeof x), 0) << number_text(x);
  }
  EXPECT_EQ(number_text(0.1), "0.1");
  EXPECT_EQ(number_text(5.0), "5");
}

// The definition, without a table: exponential, but plainly right.
int slow_distance(std::string_view a, std::string_view b) {
  if (a.empty() || b.empty()) return static_cast<int>(a.size() + b.size());
  int best = std::min({slow_distance(a.substr(1), b) + 1, slow_distance(a, b.substr(1)) + 1,
                       slow_distance(a.substr(1), b.substr(1)) + (a[0] != b[0])});
  if (a.size() > 1 && b.size() > 1 && a[0] == b[1] && a[1] == b[0])
    best = std::min(best, slow_distance(a.substr(2), b.substr(2)) + 1);
  return best;
}

TEST(EditDistance, IsThatOfItsDefinition) {
  const unsigned seed = 3;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937 random(seed);
  const auto word = [&] {
    std::string letters(random() % 6, ' ');
    for (char& c : letters) c = "abc"[random() % 3];
    return letters;
  };
  for (int i = 0; i < 300; ++i) {
    const std::string a = word(), b = word();
    EXPECT_EQ(edit_distance(a, b), slow_distance(a, b)) << a << " to " << b;
  }
  EXPECT_EQ(edit_distance("foce", "force"), 1);
  EXPECT_EQ(edit_distance("froce", "force"), 1);
}

TEST(NearestWord, FindsSlipsAndLeavesStrangersAlone) {
  const std::vector<std::string> valid = {"force", "friction", "time_step", "k"};
  EXPECT_EQ(nearest_word("frce", valid), "force");
  EXPECT_EQ(nearest_word("fric", valid), "friction");
  EXPECT_EQ(nearest_word("timestep", valid), "time_step");
  EXPECT_EQ(nearest_word("Force", valid), "force");
  EXPECT_EQ(nearest_word("banana", valid), std::nullopt);
  EXPECT_EQ(nearest_word("", {}), std::nullopt);
  EXPECT_EQ(nearest_word(std::string(100000, 'f'), valid), std::nullopt);
}

TEST(Shown, KeepsToOneLineAndToWholeLetters) {
  EXPECT_EQ(shown("a\nb\tc"), "a b c");
  const std::string longer = shown(std::string(59, 'x') + "ü" + std::string(50, 'y'));
  EXPECT_EQ(longer, std::string(59, 'x') + "…");
}

}  // namespace
}  // namespace impedraw
