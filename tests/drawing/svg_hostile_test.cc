// Input that is broken or meant to break: one line, no crash, no long wait.
#include <filesystem>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "common/errors.h"
#include "drawing/svg.h"

namespace impedraw {
namespace {

const std::string kHead = "<svg xmlns='http://www.w3.org/2000/svg' xmlns:xlink='http://www.w3.org/1999/xlink' viewBox='0 0 100 100'>";
const std::string kLine = "<line x2='50' y2='50' stroke='black'/>";

std::string message(const std::string& document) {
  try {
    parse_svg(document, "a.svg");
  } catch (const InputError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  return "accepted";
}

TEST(SvgHostile, BrokenDocumentsGetOneLine) {
  EXPECT_EQ(message(""), "a.svg: not an SVG that can be read: the document does not have a root node");
  EXPECT_EQ(message("hello").find("a.svg: not an SVG that can be read: "), 0u);
  EXPECT_EQ(message("<html/>"), "a.svg: not an SVG that can be read: the root element is <html>, not <svg>");
  EXPECT_EQ(message(kHead + "<g>" + kLine), "a.svg: not an SVG that can be read: the root node was opened but never closed");
  EXPECT_EQ(message("\xff\xfe<svg/>"), "a.svg: not an SVG that can be read: not a UTF-8 text");
  EXPECT_NE(message("<svg xmlns='http://www.w3.org/2000/svg' width='0' height='10'>" + kLine + "</svg>").find("size"), std::string::npos);
}

TEST(SvgHostile, NothingToDrawSaysSo) {
  EXPECT_EQ(message(kHead + "</svg>"), "a.svg: nothing in it draws a line: no visible path or shape");
  EXPECT_EQ(message(kHead + "<text>Hi</text></svg>"),
            "a.svg: nothing in it draws a line: no visible path or shape (1 × <text>: text is left out: convert it to paths first)");
}

TEST(SvgHostile, FilesThatAreNot) {
  const auto file_message = [](const std::filesystem::path& file) -> std::string {
    try {
      read_svg(file);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(file_message("/no/such.svg"), "/no/such.svg: no such file");
  EXPECT_EQ(file_message("/tmp"), "/tmp: not a file");
  const std::filesystem::path packed = std::filesystem::temp_directory_path() / "impedraw_packed.svgz";
  std::ofstream(packed, std::ios::binary) << "\x1f\x8b rest";
  EXPECT_EQ(file_message(packed), packed.string() + ": a compressed SVG; unpack it first (gunzip)");
  std::filesystem::remove(packed);
}

TEST(SvgHostile, CoordinatesBeyondReason) {
  EXPECT_NE(message(kHead + "<line x2='1e12' y2='3' stroke='red'/></svg>").find("lies beyond ± 1e+06 mm"), std::string::npos);
  message(kHead + "<path d='M0 0 L 1e400 5 L nan 3' stroke='red'/></svg>");
  message(kHead + "<g transform='scale(1e30)'><g transform='scale(1e30)'>" + kLine + "</g></g></svg>");
  message(kHead + "<circle r='1e30' stroke='red'/></svg>");
}

TEST(SvgHostile, DeepNestingAndLoops) {
  std::string deep = kHead;
  for (int i = 0; i < 200000; ++i) deep += "<g>";
  deep += kLine;
  for (int i = 0; i < 200000; ++i) deep += "</g>";
  EXPECT_NE(message(deep + "</svg>"), "accepted");
  message(kHead + "<g id='a'><use xlink:href='#a'/></g>" + kLine + "</svg>");
  message(kHead + "<g id='a'><use xlink:href='#b'/></g><g id='b'><use xlink:href='#a'/></g>" + kLine + "</svg>");
  // Ten times ten … elements out of a few lines.
  std::string bomb = kHead + "<g id='u0'>" + kLine + "</g>";
  for (int i = 1; i < 12; ++i) {
    bomb += "<g id='u" + std::to_string(i) + "'>";
    for (int k = 0; k < 10; ++k) bomb += "<use xlink:href='#u" + std::to_string(i - 1) + "'/>";
    bomb += "</g>";
  }
  EXPECT_NE(message(bomb + "</svg>"), "accepted");
  std::string entities = "<!DOCTYPE svg [<!ENTITY e0 'aaaaaaaaaa'>";
  for (int i = 1; i < 12; ++i) {
    entities += "<!ENTITY e" + std::to_string(i) + " '";
    for (int k = 0; k < 10; ++k) entities += "&e" + std::to_string(i - 1) + ";";
    entities += "'>";
  }
  EXPECT_NE(message(entities + "]>" + kHead + "<desc>&e11;</desc>" + kLine + "</svg>"), "accepted");
}

TEST(SvgHostile, MutilatedDocumentsNeverCrash) {
  const std::string whole = kHead + "<g transform='rotate(30)' id='x'><path d='M1 2 C 3 4 5 6 7 8 A 3 4 5 0 1 9 9 z' stroke='#123'/>"
                            "<ellipse rx='3' ry='4' style='fill:red'/><use xlink:href='#x'/></g></svg>";
  for (unsigned seed = 0; seed < 3000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::string document = whole;
    for (unsigned i = 0; i <= seed % 4; ++i) {
      const std::size_t at = random() % document.size();
      if (random() % 2) document[at] = static_cast<char>(32 + random() % 95);
      else document.erase(at, random() % 8);
    }
    message(document);
  }
}

}  // namespace
}  // namespace impedraw
