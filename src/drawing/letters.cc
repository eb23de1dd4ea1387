#include "impedraw/drawing/letters.h"

#include <algorithm>
#include <numbers>
#include <utility>

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/printable.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
using Line = std::vector<Vector2d>;

constexpr double kGap = 2;       // between a letter and its mark [grid]
constexpr double kHalfMark = 4;  // half the width of most marks

enum class Mark {
  acute,
  grave,
  circumflex,
  diaeresis,
  tilde,
  ring,
  caron,
  macron,
  breve,
  dot,
  double_acute,  // above
  cedilla,
  ogonek,
  comma,  // below
  slash,
  bar,
  short_slash,
  apostrophe,
  middle_dot,
  dotless,
  turned
};

struct Composed {
  Mark mark;
  const char32_t* pairs;  // letter, base, letter, base, …
};
constexpr Composed kComposed[] = {
    {Mark::acute,
     U"ÁAÉEÍIÓOÚUÝYáaéeíióoúuýyĆCćcĹLĺlŃNńnŔRŕrŚSśsŹZźz´ άαέεήηίιόούυώωΆΑΈΕΉΗΊΙΌΟΎΥΏΩЃГѓгЌКќк"},
    {Mark::grave, U"ÀAÈEÌIÒOÙUàaèeìiòoùu"},
    {Mark::circumflex, U"ÂAÊEÎIÔOÛUâaêeîiôoûuĈCĉcĜGĝgĤHĥhĴJĵjŜSŝsŴWŵwŶYŷy"},
    {Mark::diaeresis, U"ÄAËEÏIÖOÜUäaëeïiöoüuÿyŸY¨ ϊιϋυΪΙΫΥЁЕёеЇІїі"},
    {Mark::tilde, U"ÃAÑNÕOãañnõoĨIĩiŨUũu"},
    {Mark::ring, U"ÅAåaŮUůu"},
    {Mark::caron, U"ČCčcĎDĚEěeŇNňnŘRřrŠSšsŤTŽZžz"},
    {Mark::macron, U"ĀAāaĒEēeĪIīiŌOōoŪUūu¯ "},
    {Mark::breve, U"ĂAăaĔEĕeĞGğgĬIĭiŎOŏoŬUŭuЎУўу"},
    {Mark::dot, U"ĊCċcĖEėeĠGġgİIŻZżz"},
    {Mark::double_acute, U"ŐOőoŰUűu"},
    {Mark::cedilla, U"ÇCçcŞSşsŢTţt¸ ςc"},
    {Mark::ogonek, U"ĄAąaĘEęeĮIįiŲUųu"},
    {Mark::comma, U"ĢGĶKķkĻLļlŅNņnŖRŗrȘSșsȚTțt"},
    {Mark::apostrophe, U"ďdĽLľlťtģg"},  // above the g in ģ, where there is room
    {Mark::slash, U"ØOøo"},
    {Mark::bar, U"ĐDđdÐDĦHħhŦTŧt"},
    {Mark::short_slash, U"ŁLłl"},
    {Mark::middle_dot, U"ĿLŀl"},
    {Mark::dotless, U"ıiȷj"},
    {Mark::turned, U"¡!¿?"},
};

constexpr std::pair<char32_t, Mark> kCombining[] = {
    {0x301, Mark::acute},     {0x300, Mark::grave},        {0x302, Mark::circumflex},
    {0x308, Mark::diaeresis}, {0x303, Mark::tilde},        {0x30a, Mark::ring},
    {0x30c, Mark::caron},     {0x304, Mark::macron},       {0x306, Mark::breve},
    {0x307, Mark::dot},       {0x30b, Mark::double_acute}, {0x327, Mark::cedilla},
    {0x328, Mark::ogonek},    {0x326, Mark::comma}};

// Characters replaced by ASCII: first the character, then its replacement.
constexpr const char32_t* kPlain[] = {
    U"‘'",   U"’'",      U"‚,",      U"‛'",      U"′'",  U"“\"", U"”\"", U"„\"", U"‟\"",
    U"″\"",  U"‐-",      U"‑-",      U"‒-",      U"–-",  U"—-",  U"―-",  U"−-",  U"\u00ad-",
    U"…...", U"\u00a0 ", U"\u2009 ", U"\u202f ", U"ŉ'n", U"ĳij", U"ĲIJ"};
constexpr const char32_t* kMovedTogether[] = {U"æae", U"ÆAE", U"œoe", U"ŒOE"};

struct DrawnLetter {
  char32_t letter;
  Glyph glyph;
};

Line circle(const Vector2d& centre, double radius) {
  Line line;
  for (int i = 0; i < 12; ++i)
    line.push_back(centre + radius * Vector2d(std::sin(i * std::numbers::pi / 6),
                                              -std::cos(i * std::numbers::pi / 6)));
  line.push_back(line.front());
  return line;
}

// In the fonts' own format. Proportions follow the plain fonts: x height from −5, stems on
// integers.
const std::vector<DrawnLetter>& drawn_here() {
  static const std::vector<DrawnLetter> all = {
      {U'ß', hershey_glyph("H[L[LKMHOFRFUGVIVKUMROUPWRXUWXUZS[Q[PZ")},
      {U'þ', hershey_glyph("I\\MFMb RMPONQMTMVNXPYSYUXXVZT[Q[OZMX")},
      {U'Þ', hershey_glyph("G\\KFK[ RKKTKWLXMYOYRXTWUTVKV")},
      {U'ð', hershey_glyph("H\\WQUNRMONMPLSLUMXOZQ[S[UZWXXUXRWNUJSHOF ROKWG")},
      {U'ŋ', hershey_glyph("I\\MMM[ RMQPNRMUMWNXQX^WaUbSb")},
      {U'Ŋ', hershey_glyph("G]KFK[ RKKOGRFUFXHYKY]X`VbSb")},
      {U'ſ', hershey_glyph("NXQ[QJRGTFVF")},
      {U'ĸ', hershey_glyph("JZNMN[ RXMNW RRSX[")},
      {U'µ', hershey_glyph("I\\MMMb RMWNZP[S[UZXW RXMX[")},
      {U'€', hershey_glyph("G\\ZIWGTFQGNJMNMSNWQZT[WZZX RIOVO RISUS")},
      {U'°', hershey_glyph("MW", {circle({0, -9}, 3)})},
      {U'·', hershey_glyph("NV", {circle({0, -1}, 1)})},
      {U'×', hershey_glyph("G]KKYY RYKKY")},
      {U'÷', hershey_glyph("E_IR[R", {circle({0, -6}, 1), circle({0, 6}, 1)})},
      {U'±', hershey_glyph("E_RGRW RJOZO RJ[Z[")},
      {U'«', hershey_glyph("JZRNMTRZ RWNRTWZ")},
      {U'»', hershey_glyph("JZRNWTRZ RMNRTMZ")},
      {U'‹', hershey_glyph("LXUNPTUZ")},
      {U'›', hershey_glyph("LXONTTOZ")},
  };
  return all;
}

// A mark above a letter, with the middle of its foot at (0, 0).
std::vector<Line> above(Mark mark) {
  switch (mark) {
    case Mark::acute:
      return {{{-2, 0}, {2, -4}}};
    case Mark::grave:
      return {{{2, 0}, {-2, -4}}};
    case Mark::circumflex:
      return {{{-kHalfMark, 0}, {0, -4}, {kHalfMark, 0}}};
    case Mark::caron:
      return {{{-kHalfMark, -4}, {0, 0}, {kHalfMark, -4}}};
    case Mark::diaeresis:
      return {circle({-3.5, -1}, 1), circle({3.5, -1}, 1)};
    case Mark::dot:
      return {circle({0, -1}, 1)};
    case Mark::tilde:
      return {{{-5, 0}, {-4, -2}, {-2, -3}, {2, -1}, {4, -2}, {5, -4}}};
    case Mark::ring:
      return {circle({0, -2.5}, 2.5)};
    case Mark::macron:
      return {{{-kHalfMark, -1}, {kHalfMark, -1}}};
    case Mark::breve:
      return {{{-kHalfMark, -4}, {-3, -1}, {-1, 0}, {1, 0}, {3, -1}, {kHalfMark, -4}}};
    case Mark::double_acute:
      return {{{-4, 0}, {-1, -4}}, {{1, 0}, {4, -4}}};
    default:
      return {};
  }
}

void put(Glyph& glyph, const std::vector<Line>& lines, const Vector2d& at) {
  for (Line line : lines) {
    for (Vector2d& p : line) p += at;
    glyph.strokes.push_back(std::move(line));
  }
}

// Drops strokes that lie wholly above the x height: the dots of i and j.
void take_dot(Glyph& glyph, const HersheyFont& font) {
  const Glyph* x = font.find(U'x');
  const double top = x ? x->box().min().y() : -5;
  const auto lowest = [](const Line& line) {
    return std::max_element(line.begin(), line.end(),
                            [](auto& a, auto& b) { return a.y() < b.y(); })
        ->y();
  };
  if (std::all_of(glyph.strokes.begin(), glyph.strokes.end(),
                  [&](const Line& line) { return lowest(line) < top - 1; }))
    return;
  std::erase_if(glyph.strokes, [&](const Line& line) { return lowest(line) < top - 1; });
}

void turn(Glyph& glyph) {  // by 180° about the middle of the x height
  for (Line& line : glyph.strokes) {
    for (Vector2d& p : line) p = Vector2d(-p.x(), 4 - p.y());
  }
  std::swap(glyph.left, glyph.right);
  glyph.left = -glyph.left, glyph.right = -glyph.right;
}

void add_mark(Glyph& glyph, Mark mark, char32_t base, const HersheyFont& font) {
  if (mark == Mark::turned) return turn(glyph);
  if (base == 'i' || base == 'j') {
    if (mark == Mark::dotless || !above(mark).empty()) take_dot(glyph, font);
  }
  // A mark on a space has the position that it has on a small letter.
  const Eigen::AlignedBox2d box = glyph.strokes.empty()
                                      ? Eigen::AlignedBox2d(Vector2d(0, -5), Vector2d(0, kBaseline))
                                      : glyph.box();
  const double middle = box.center().x(), bottom = box.max().y();
  const bool capital = base < 'a';
  switch (mark) {
    case Mark::cedilla:
      return put(glyph, {{{0, 0}, {0, 2}, {2, 3}, {2, 5}, {0, 6}, {-2, 6}}}, {middle, bottom});
    case Mark::ogonek:
      return put(glyph, {{{0, 0}, {-2, 2}, {-2, 4}, {0, 5}, {2, 4}}}, {box.max().x() - 1, bottom});
    case Mark::comma:
      return put(glyph, {{{1, 0}, {1, 2}, {-1, 5}}}, {middle, bottom + kGap});
    case Mark::slash:
      return put(glyph, {{{box.min().x() - 1, bottom + 2}, {box.max().x() + 1, box.min().y() - 2}}},
                 {0, 0});
    case Mark::short_slash:
      return put(glyph, {{{-4, 2}, {4, -4}}}, {box.min().x() + (capital ? 1 : 0), -1.5});
    case Mark::apostrophe:
      if (base == 'g')
        return put(glyph, {{{1, -4}, {-1, -2}, {-1, 0}}}, {middle, box.min().y() - kGap});
      put(glyph, {{{0, -12}, {0, -10}, {-1, -8}}}, {box.max().x() + 3, 0});
      glyph.right = std::max(glyph.right, box.max().x() + 5);
      return;
    case Mark::middle_dot:
      put(glyph, {circle({0, 0}, 1)}, {box.max().x() + 3, -1.5});
      glyph.right = std::max(glyph.right, box.max().x() + 6);
      return;
    case Mark::bar: {
      const double y = capital ? (base == 'H' ? -7 : -1.5) : (base == 't' ? 1 : -8.5);
      const double left = base == 'd' ? box.max().x() - 6 : box.min().x() - (base == 'T' ? -3 : 3);
      const double right = base == 'd'                  ? box.max().x() + 3
                           : base == 'D' || base == 'h' ? box.min().x() + 6
                                                        : box.max().x() + (base == 'T' ? -3 : 3);
      return put(glyph, {{{left, y}, {right, y}}}, {0, 0});
    }
    default:
      return put(glyph, above(mark), {middle, box.min().y() - kGap});
  }
}

// Several letters in a row. `together`: their ink touches.
std::optional<Glyph> row_of(const HersheyFont& font, std::u32string_view letters, bool together) {
  Glyph row;
  for (const char32_t c : letters) {
    const Glyph* next = font.find(c);
    if (!next) return std::nullopt;
    if (row.strokes.empty()) {
      row = *next;
      continue;
    }
    const double shift =
        together ? row.box().max().x() - next->box().min().x() : row.right - next->left;
    put(row, next->strokes, {shift, 0});
    row.right = next->right + shift;
  }
  return row;
}

std::optional<Glyph> plain_glyph(const HersheyFont& font, char32_t letter) {
  if (const Glyph* own = font.find(letter)) return *own;
  for (const Composed& group : kComposed) {
    for (const char32_t* pair = group.pairs; *pair; pair += 2) {
      if (pair[0] != letter) continue;
      const Glyph* base = font.find(pair[1]);
      if (!base) return std::nullopt;
      Glyph glyph = *base;
      add_mark(glyph, group.mark, pair[1], font);
      return glyph;
    }
  }
  for (const char32_t* plain : kPlain) {
    if (plain[0] == letter) return row_of(font, plain + 1, false);
  }
  for (const char32_t* pair : kMovedTogether) {
    if (pair[0] == letter) return row_of(font, pair + 1, true);
  }
  for (const DrawnLetter& drawn : drawn_here()) {
    if (drawn.letter == letter) return drawn.glyph;
  }
  return std::nullopt;
}

}  // namespace

bool is_combining_mark(char32_t c) {
  return std::any_of(std::begin(kCombining), std::end(kCombining),
                     [&](const auto& known) { return known.first == c; });
}

std::optional<Glyph> glyph_of(const HersheyFont& font, char32_t letter,
                              std::u32string_view combining) {
  std::optional<Glyph> glyph = plain_glyph(font, letter);
  if (!glyph) return glyph;
  for (const char32_t c : combining) {
    for (const auto& [code, mark] : kCombining) {
      if (code == c) add_mark(*glyph, mark, c == combining.front() ? letter : U'x', font);
    }
  }
  return glyph;
}

std::u32string decoded_utf8(std::string_view text) {
  std::u32string decoded;
  for (std::size_t i = 0; i < text.size();) {
    const Utf8Character c = first_character(text.substr(i));
    if (c.bytes == 0)
      throw InputError(
          fmt::format("text: byte {} (0x{:02x}) is not valid UTF-8, after {} characters", i + 1,
                      static_cast<unsigned char>(text[i]), decoded.size()));
    decoded += c.code;
    i += c.bytes;
  }
  return decoded;
}

std::string encoded_utf8(char32_t c) {
  if (c < 0x80) return std::string(1, static_cast<char>(c));
  std::string text;
  const int more = c < 0x800 ? 1 : c < 0x10000 ? 2 : 3;
  text += static_cast<char>((0xffu << (7 - more) & 0xff) | c >> (6 * more));
  for (int k = more - 1; k >= 0; --k) text += static_cast<char>(0x80 | (c >> (6 * k) & 0x3f));
  return text;
}

}  // namespace impedraw
