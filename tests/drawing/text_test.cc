// Text as strokes: sizes and places by what is asked for, letters by what the font's file says,
// read here in another way.
#include "impedraw/drawing/text.h"

#include <filesystem>
#include <fstream>
#include <numeric>
#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/hershey.h"
#include "impedraw/drawing/letters.h"
#include "impedraw/drawing/stroke.h"
#include "lines.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using testing::HasSubstr;

Artwork set(const std::string& text, double size = 21, const std::string& font = "futural") {
  TextSettings settings;
  settings.text = text;
  settings.size_mm = size;
  settings.font = font;
  return make_text(settings);
}

Eigen::AlignedBox2d box_of(const std::vector<Stroke>& strokes, std::size_t first = 0,
                           std::size_t last = SIZE_MAX) {
  Eigen::AlignedBox2d box;
  for (std::size_t i = first; i < std::min(last, strokes.size()); ++i) {
    for (const Vector2d& p : strokes[i].points) box.extend(p);
  }
  return box;
}

std::string error_of(const std::string& text, const std::string& font = "futural") {
  try {
    set(text, 21, font);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(Text, CapitalsHaveTheHeightAskedFor) {
  for (const char* font : {"futural", "rowmans", "timesr", "scripts"}) {
    for (const char* letter : {"F", "E", "H", "T"}) {
      SCOPED_TRACE(std::string(font) + " " + letter);
      const Eigen::AlignedBox2d box = box_of(set(letter, 12.5, font).strokes);
      EXPECT_NEAR(box.sizes().y(), 12.5, 1e-9);
      EXPECT_NEAR(box.min().y(), 0, 1e-9);
      EXPECT_NEAR(box.min().x(), 0, 1e-9);
    }
  }
}

TEST(Text, FIsWhatTheFilesLineSays) {
  // 12345  8G… of F: pairs of letters about R, a blank and R between strokes; decoded here anew.
  std::ifstream in(hershey_folder() / "futural.jhf");
  std::string line;
  for (int i = 0; i <= 'F' - ' '; ++i) std::getline(in, line);
  std::vector<std::vector<Vector2d>> expected(1);
  for (std::size_t i = 10; i + 1 < line.size(); i += 2) {
    if (line.substr(i, 2) == " R")
      expected.emplace_back();
    else
      expected.back().push_back({line[i] - 'R', line[i + 1] - 'R'});
  }
  const Artwork f = set("F");
  ASSERT_EQ(f.strokes.size(), expected.size());
  const double left = expected[0][0].x();  // the stem, leftmost
  for (std::size_t s = 0; s < expected.size(); ++s) {
    ASSERT_EQ(f.strokes[s].points.size(), expected[s].size());
    for (std::size_t i = 0; i < expected[s].size(); ++i)
      EXPECT_LT((f.strokes[s].points[i] - (expected[s][i] - Vector2d(left, -12))).norm(), 1e-9);
  }
}

TEST(Text, LinesAreAlignedAndSpaced) {
  TextSettings settings;
  settings.text = "HHHH\\nH\nHH";
  settings.size_mm = 10;
  settings.line_spacing = 2;
  const double whole = box_of(set("HHHH", 10).strokes).sizes().x(),
               one = box_of(set("H", 10).strokes).sizes().x();
  EXPECT_GT(whole, 4 * one);
  for (const auto& [align, share] :
       {std::pair(TextAlign::left, 0.0), {TextAlign::centre, 0.5}, {TextAlign::right, 1.0}}) {
    SCOPED_TRACE(share);
    settings.align = align;
    const Artwork text = make_text(settings);
    ASSERT_EQ(text.strokes.size(), 3u * 7);  // an H has three
    const auto first = box_of(text.strokes, 0, 12), second = box_of(text.strokes, 12, 15),
               third = box_of(text.strokes, 15, 21);
    EXPECT_NEAR(first.sizes().x(), whole, 1e-9);
    EXPECT_NEAR(first.min().x(), -share * whole, 1e-9);
    EXPECT_NEAR(second.min().x(), -share * one, 1e-9);
    EXPECT_NEAR(second.min().y() - first.min().y(), 20, 1e-9);
    EXPECT_NEAR(third.min().y() - second.min().y(), 20, 1e-9);
    EXPECT_LT((text.page.max() - box_of(text.strokes).max()).norm(), 1e-12);
  }
  // A blank in front counts.
  EXPECT_NEAR(box_of(set(" H").strokes).min().x(), 16, 1e-9);
}

TEST(Text, AccentsLieOverTheirLettersAndCedillasBelow) {
  const std::u32string pairs =
      U"áaàaâaäaãaåaÁAÀAÂAÄAÃAÅAéeèeêeëeěeĕeėeēeíiìiîiïiīióoòoôoöoõoőoúuùuûuüuůuűuýyÿyñnńnňnćcčcČCš"
      U"sśsžzźzżzŘRřrğgĜGŤTĤHĴJ";
  for (std::size_t k = 0; k < pairs.size(); k += 2) {
    const std::string base = encoded_utf8(pairs[k + 1]), letter = encoded_utf8(pairs[k]);
    SCOPED_TRACE(letter);
    const auto plain = set("H" + base).strokes,
               with = set("H" + letter).strokes;            // beside an H, to stand on one line
    const std::size_t mark = plain.size() - (base == "i");  // whose dot goes
    ASSERT_GT(with.size(), mark);
    const Eigen::AlignedBox2d body = box_of(with, 3, mark), accent = box_of(with, mark);
    EXPECT_LT(accent.max().y(), body.min().y() - 0.5);
    EXPECT_LT(std::abs(accent.center().x() - body.center().x()), 2.5);
    EXPECT_NEAR(body.max().y(), box_of(plain, 3).max().y(), 1e-9);
  }
  for (const std::string letter : {"ç", "Ç", "ş", "ą", "Ę", "ņ"}) {
    SCOPED_TRACE(letter);
    const auto with = set("H" + letter).strokes;
    EXPECT_GT(box_of(with, with.size() - 1).max().y(), 21 + 3);
    EXPECT_GE(box_of(with, with.size() - 1).min().y(), 21 - 1e-9);
  }
}

TEST(Text, EveryLetterOfLatin1AndLatinExtendedAIsThereAndItsOwn) {
  for (const char* font : {"futural", "rowmant", "scriptc", "gothiceng"}) {
    const HersheyFont hershey = read_hershey_font(font);
    for (char32_t c = 0xc0; c < 0x180; ++c) {
      SCOPED_TRACE(std::string(font) + " " + encoded_utf8(c));
      const auto glyph = glyph_of(hershey, c);
      ASSERT_TRUE(glyph.has_value());
      EXPECT_FALSE(glyph->strokes.empty());
      EXPECT_GT(glyph->right, glyph->left);
      for (char32_t plain = 33; plain < 127; ++plain)
        EXPECT_NE(glyph->strokes, hershey.find(plain)->strokes);
    }
  }
}

TEST(Text, CombiningMarksAndTypographicSignsAreTheirPlainForms) {
  const auto same = [](const std::string& a, const std::string& b) {
    const Artwork one = set(a), other = set(b);
    ASSERT_EQ(one.strokes.size(), other.strokes.size());
    for (std::size_t i = 0; i < one.strokes.size(); ++i)
      EXPECT_EQ(one.strokes[i].points, other.strokes[i].points);
  };
  same("re\xcc\x81sume\xcc\x81", "résumé");
  same("“A” – ‘b’ — it’s…", "\"A\" - 'b' - it's...");
  same("A\u00a0b", "A b");
}

TEST(Text, WhatTheFontLacksIsNamedWithItsPlace) {
  const std::string error = error_of("Aあ\nb €漢");
  EXPECT_THAT(error, HasSubstr("'あ' (U+3042) at line 1, character 2"));
  EXPECT_THAT(error, HasSubstr("'漢' (U+6F22) at line 2, character 4"));
  EXPECT_THAT(error, HasSubstr("font futural has ASCII, the letters of Latin-1"));
  EXPECT_EQ(error.find("€"), error.rfind("€"));  // only in what there is
  EXPECT_THAT(error_of("Y", "greekc"), HasSubstr("font greekc has ASCII without YZyz"));
  EXPECT_THAT(error_of("漢字漢字漢字漢字漢字"), HasSubstr("and 2 more"));
  EXPECT_THAT(error_of("a\x01"), HasSubstr("U+0001 at line 1, character 2"));
  EXPECT_THAT(error_of("  \n "), HasSubstr("has nothing to draw"));
  EXPECT_THAT(error_of("A", "comic"),
              HasSubstr("font 'comic' is not known; there are astrology, cursive,"));
  EXPECT_THAT(error_of("A", "../futural"), HasSubstr("is not known"));
}

TEST(Text, Utf8IsReadStrictly) {
  for (const std::string text :
       {"\xff", "a\xc3", "\xc0\x80", "\xed\xa0\x80", "\xf4\x90\x80\x80", "\xe2\x82", "\x80"}) {
    EXPECT_THAT(error_of(text), HasSubstr("not valid UTF-8"));
  }
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    const char32_t c = random() % 0x110000;
    if (c >= 0xd800 && c < 0xe000) continue;
    EXPECT_EQ(decoded_utf8(encoded_utf8(c)), std::u32string(1, c));
  }
}

TEST(Text, FilesThatAreNoFonts) {
  for (const char* text : {"", "12345  3MWRM", "12345 xxMWRM", "1234", "12345  1MWRMRN"}) {
    SCOPED_TRACE(text);
    EXPECT_THROW(parse_jhf(text, "broken"), InputError);
  }
  // Pairs may go on in the next line.
  const HersheyFont font = parse_jhf("    1  1JZ\n    2  6JZRFR\nT RRY\nRZ\n", "wrapped");
  ASSERT_EQ(font.glyphs.size(), 2u);
  ASSERT_EQ(font.glyphs[1].strokes.size(), 2u);
  EXPECT_EQ(font.glyphs[1].strokes[0], (std::vector<Vector2d>{{0, -12}, {0, 2}}));
  EXPECT_EQ(font.glyphs[1].strokes[1], (std::vector<Vector2d>{{0, 7}, {0, 8}}));
  EXPECT_GE(hershey_font_names().size(), 30u);
  for (const std::string& name : hershey_font_names())
    EXPECT_NO_THROW(read_hershey_font(name)) << name;
}

// The file of a font whose H is 700 units high, read here by eye.
std::string font_file(const std::string& glyphs, const std::string& face = "cap-height='700'") {
  const std::string file = (std::filesystem::path(testing::TempDir()) / "own-font.svg").string();
  std::ofstream(file) << "<svg xmlns='http://www.w3.org/2000/svg'><defs><font horiz-adv-x='600'>"
                         "<font-face units-per-em='1000' " +
                             face + "/><missing-glyph/>" + glyphs + "</font></defs></svg>";
  return file;
}

TEST(Text, AnSvgFontIsDrawnByItsOwnLines) {
  const std::string glyphs =
      "<glyph unicode=' ' horiz-adv-x='300'/><glyph unicode='fi' d='M0 0H1'/>"
      "<glyph unicode='H' d='M100 0V700M500 0V700M100 350H500'/>"
      "<glyph unicode='&#x416;' horiz-adv-x='800'><path d='M0 -200L700 700'/></glyph>";
  for (const char* face : {"cap-height='700'", ""}) {  // without it, the H tells
    SCOPED_TRACE(face);
    const Artwork a = set("H ЖH", 70, font_file(glyphs, face));
    ASSERT_EQ(a.strokes.size(), 7u);
    const std::vector<std::vector<Vector2d>> expected = {
        {{0, 70}, {0, 0}},     {{40, 70}, {40, 0}},   {{0, 35}, {40, 35}},   {{80, 90}, {150, 0}},
        {{170, 70}, {170, 0}}, {{210, 70}, {210, 0}}, {{170, 35}, {210, 35}}};
    const Vector2d middle = a.strokes[0].points[0] - expected[0][0];
    for (std::size_t i = 0; i < expected.size(); ++i) {
      for (std::size_t k = 0; k < 2; ++k)
        EXPECT_LT((a.strokes[i].points[k] - expected[i][k] - middle).norm(), 1e-3) << i;
    }
  }
  const std::string file = font_file(glyphs);
  const auto error = [](const std::string& text, const std::string& font) {
    try {
      set(text, 20, font);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_THAT(error("Hx", file), HasSubstr("'x' (U+0078) at line 1, character 2: font " + file));
  EXPECT_THAT(error("H", "/no/such.svg"), HasSubstr("/no/such.svg"));
  EXPECT_THAT(error("H", font_file("")), HasSubstr("holds no <glyph>"));
  EXPECT_THAT(error("H", font_file(glyphs, "units-per-em='0'")), HasSubstr("font "));
  EXPECT_THAT(error("H", "futurella"), HasSubstr("'futurella' is not known"));
}

TEST(Text, GreekAndCyrillicAreLettersOfTheirOwn) {
  std::vector<std::vector<Vector2d>> known;
  for (const char* letter :
       {"Γ", "Δ", "Θ", "Λ", "Ξ", "Π", "Σ", "Φ", "Ψ", "Ω", "α", "β", "γ", "δ", "λ", "π", "σ",
        "ω", "Б", "Г", "Д", "Ж", "И", "Л", "Ф", "Ц", "Ш", "Ю", "Я", "б", "ж", "ю", "я", "э"}) {
    SCOPED_TRACE(letter);
    std::vector<Vector2d> points;
    for (const Stroke& stroke : set(letter).strokes)
      points.insert(points.end(), stroke.points.begin(), stroke.points.end());
    for (const auto& other : known) EXPECT_NE(points, other);
    known.push_back(points);
  }
  for (const auto& [accented, plain] : {std::pair{"ά", "α"}, {"Ё", "Е"}, {"й", "и"}, {"ї", "і"}})
    EXPECT_LT(box_of(set(accented).strokes).sizes().y(), 40) << plain;
  EXPECT_NO_THROW(set("Ελληνικά, ϋς; Съешь ещё этих мягких булок, їжак"));
}

}  // namespace
}  // namespace impedraw
