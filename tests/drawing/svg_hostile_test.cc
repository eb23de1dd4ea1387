// Input that is broken or meant to break: one line, no crash, no long wait.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <random>

#include <gtest/gtest.h>

#include "impedraw/common/errors.h"
#include "impedraw/drawing/svg.h"

namespace impedraw {
namespace {

const std::string kHead =
    "<svg xmlns='http://www.w3.org/2000/svg' xmlns:xlink='http://www.w3.org/1999/xlink' viewBox='0 "
    "0 100 100'>";
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
  EXPECT_EQ(message(""), "a.svg: cannot be read as SVG: the document does not have a root node");
  EXPECT_EQ(message("hello").find("a.svg: cannot be read as SVG: "), 0u);
  EXPECT_EQ(message("<html/>"),
            "a.svg: cannot be read as SVG: the root element is <html>, not <svg>");
  EXPECT_EQ(message(kHead + "<g>" + kLine),
            "a.svg: cannot be read as SVG: the root node was opened but never closed");
  EXPECT_EQ(message("<svg>\xff</svg>"), "a.svg: cannot be read as SVG: not a UTF-8 text");
  EXPECT_NE(
      message("<svg xmlns='http://www.w3.org/2000/svg' width='0' height='10'>" + kLine + "</svg>")
          .find("size"),
      std::string::npos);
}

TEST(SvgHostile, NothingToDrawSaysSo) {
  EXPECT_EQ(message(kHead + "</svg>"), "a.svg: has nothing to draw: no visible path or shape");
  EXPECT_EQ(message(kHead + "<image/></svg>"),
            "a.svg: has nothing to draw: no visible path or shape (1 × <image>: pictures are "
            "left out: only paths and shapes are read)");
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
  EXPECT_EQ(file_message("/tmp"), "/tmp: is a folder, must be a regular file");
  const std::filesystem::path packed =
      std::filesystem::temp_directory_path() / "impedraw_packed.svgz";
  std::ofstream(packed, std::ios::binary) << "\x1f\x8b rest";
  EXPECT_EQ(file_message(packed), packed.string() + ": a compressed SVG; unpack it first (gunzip)");
  std::filesystem::remove(packed);
}

TEST(SvgHostile, CoordinatesBeyondReason) {
  EXPECT_NE(
      message(kHead + "<line x2='1e12' y2='3' stroke='red'/></svg>").find("lies beyond ± 1e+06 mm"),
      std::string::npos);
  const auto number = [](const std::string& body) {
    return message(kHead + kLine + "\n" + body + "</svg>");
  };
  const std::string read = "a.svg: cannot be read as SVG: ";
  EXPECT_EQ(number("<path d='M0 0 L 3 NaN' stroke='red'/>"),
            read + "line 2: <path> d: holds what is not a finite number");
  EXPECT_EQ(number("<circle r='nan'/>"),
            read + "line 2: <circle> r: holds what is not a finite number");
  EXPECT_EQ(number("<g transform='translate(-Infinity 3)'/>"),
            read + "line 2: <g> transform: holds what is not a finite number");
  EXPECT_EQ(number("<path d='M0 0 L 1e400 5' stroke='red'/>"),
            read + "line 2: <path> d: holds 1e400, beyond ± 1e30");
  message(kHead + "<g transform='scale(1e30)'><g transform='scale(1e30)'>" + kLine +
          "</g></g></svg>");
  message(kHead + "<circle r='1e30' stroke='red'/></svg>");
}

// Result of reading a document, in a separate process.
struct Cost {
  std::string message;
  double megabytes;
};

Cost cost(const std::string& document) {
  int ends[2];
  EXPECT_EQ(pipe(ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    // Far more than any of them needs: a signal ends a reader that hangs.
    const rlimit processor_seconds{120, 120};
    setrlimit(RLIMIT_CPU, &processor_seconds);
    const std::string said = message(document);
    _exit(write(ends[1], said.data(), said.size()) == static_cast<ssize_t>(said.size()) ? 0 : 1);
  }
  close(ends[1]);
  std::string said;
  char buffer[4096];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;)
    said.append(buffer, static_cast<std::size_t>(n));
  close(ends[0]);
  rusage usage{};
  int status = 0;
  wait4(child, &status, 0, &usage);
  EXPECT_EQ(status, 0) << "ended by a signal";
  return {said, 1e-3 * static_cast<double>(usage.ru_maxrss)};
}

std::string repeated(const std::string& text, int times) {
  std::string all;
  for (int i = 0; i < times; ++i) all += text;
  return all;
}

// The address sanitizer puts room about each of millions of small blocks.
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define IMPEDRAW_ADDRESS_SANITIZER
#endif
#endif
#ifdef IMPEDRAW_ADDRESS_SANITIZER
constexpr double kMostMegabytes = 2048;
#else
constexpr double kMostMegabytes = 1024;
#endif

constexpr const char* kTooSlow = "it takes longer than";

// `or_why`: another reason that is right too. Of two bounds, which is reached first can depend on
// how fast the machine is.
void expect_refused(const std::string& document, const std::string& why,
                    const char* or_why = nullptr) {
  SCOPED_TRACE(document.substr(0, 200));
  const Cost c = cost(document);
  EXPECT_TRUE(c.message.find(why) != std::string::npos ||
              (or_why && c.message.find(or_why) != std::string::npos))
      << c.message << "\nexpected: " << why;
  EXPECT_LT(c.megabytes, kMostMegabytes);
}

std::string with_entities(const std::string& first, const std::string& quote) {
  std::string entities = "<!DOCTYPE svg [<!ENTITY e0 " + quote + first + quote + ">";
  for (int i = 1; i < 12; ++i) {
    entities += "<!ENTITY e" + std::to_string(i) + " '" +
                repeated("&e" + std::to_string(i - 1) + ";", 10) + "'>";
  }
  return entities + "]>" + kHead;
}

TEST(SvgHostile, DeepNesting) {
  for (const int depth : {20000, 200000}) {
    expect_refused(kHead + repeated("<g>", depth) + kLine + repeated("</g>", depth) + "</svg>",
                   "line 1: nested more than 1000 elements deep");
  }
  EXPECT_EQ(message(kHead + repeated("<g>", 900) + kLine + repeated("</g>", 900) + "</svg>"),
            "accepted");
}

TEST(SvgHostile, UsesWithoutEnd) {
  const std::string back = "line 1: a <use> leads back to the element that it stands in";
  expect_refused(kHead + "<g id='a'><use xlink:href='#a'/></g>" + kLine + "</svg>", back);
  expect_refused(kHead + "<g id='a'><use href='#b'/></g><g id='b'><use xlink:href='#a'/></g>" +
                     kLine + "</svg>",
                 back);
  expect_refused(kHead + "<use id='a' href='#a'/>" + kLine + "</svg>", back);
  EXPECT_EQ(message(kHead + "<g id='a'><use href='#b'/></g><g id='b'>" + kLine +
                    "</g><use href='#a'/><use href='#b'/></svg>"),
            "accepted");
  std::string chain = kHead + "<g id='u3000'>" + kLine + "</g>",
              bomb = kHead + "<g id='u0'>" + kLine + "</g>";
  for (int i = 0; i < 3000; ++i)
    chain += "<g id='u" + std::to_string(i) + "'><use href='#u" + std::to_string(i + 1) + "'/></g>";
  for (int i = 1; i < 12; ++i) {
    bomb += "<g id='u" + std::to_string(i) + "'>" +
            repeated("<use href='#u" + std::to_string(i - 1) + "'/>", 10) + "</g>";
  }
  expect_refused(chain + "</svg>", "too many within one another");
  expect_refused(bomb + "</svg>", "more than 1,000,000 elements, all uses counted", kTooSlow);
}

TEST(SvgHostile, Entities) {
  expect_refused(with_entities("aaaaaaaaaa", "'") + "<desc>&e11;</desc>" + kLine + "</svg>",
                 "entity reference loop");
  expect_refused(with_entities(kLine, "\"") + "&e11;</svg>", "entity reference loop");
  expect_refused(
      "<!DOCTYPE svg [<!ENTITY x SYSTEM 'file:///etc/passwd'>]>" + kHead + "<text>&x;</text></svg>",
      "unknown entity reference 'x'");
  // Long and repeated, but not nested.
  const std::string long_one = "<!DOCTYPE svg [<!ENTITY a '" + repeated("a", 100000) + "'>]>";
  expect_refused(long_one + kHead + "<desc>" + repeated("&a;", 20000) + "</desc></svg>",
                 "it takes ");
}

// A machine that is busy with something else makes no document a bad one: the reader is stopped for
// longer than it may take, as a scheduler would.
TEST(SvgHostile, TimeNotSpentReadingDoesNotCount) {
  const std::string document =
      kHead + repeated("<path stroke='red' d='M0 0C10 20 30 40 50 60'/>", 1000) + "</svg>";
  const pid_t reader = fork();
  if (reader == 0) _exit(message(document) == "accepted" ? 0 : 1);
  usleep(30'000);
  kill(reader, SIGSTOP);
  usleep(4'500'000);
  kill(reader, SIGCONT);
  int status = 0;
  waitpid(reader, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
}

TEST(SvgHostile, TooMuchOfAnything) {
  std::string attributes;
  for (int i = 0; i < 200000; ++i) attributes += " a" + std::to_string(i) + "='1'";
  expect_refused(kHead + "<g" + attributes + ">" + kLine + "</g></svg>", kTooSlow);
  const std::string rules = "<style>" + repeated(".a{fill:red}", 200000) + "</style>";
  expect_refused(kHead + rules + repeated("<path class='a' d='M0 0H1V1'/>", 2000) + "</svg>",
                 "it takes ");
  expect_refused(kHead + repeated("<g/>", 3000000) + "</svg>", "nodes limit", kTooSlow);
  expect_refused(kHead + "<path stroke='red' d='M0 0" +
                     repeated("C 1e5 -1e5 -1e5 1e5 5 5", 200000) + "'/></svg>",
                 "its curves take more than", kTooSlow);
}

TEST(SvgHostile, TenThousandSubpathsAreRead) {
  std::string d;
  for (int i = 0; i < 10000; ++i)
    d += "M" + std::to_string(i % 100) + " " + std::to_string(i / 100) + "c.5 0 0 .5 .3 .3z";
  EXPECT_EQ(parse_svg(kHead + "<path stroke='red' d='" + d + "'/></svg>", "a.svg").strokes.size(),
            10000u);
}

TEST(SvgHostile, MutilatedDocumentsNeverCrash) {
  const std::string whole =
      kHead +
      "<g transform='rotate(30)' id='x'><path d='M1 2 C 3 4 5 6 7 8 A 3 4 5 0 1 9 9 z' "
      "stroke='#123'/>"
      "<ellipse rx='3' ry='4' style='fill:red'/><use xlink:href='#x'/></g></svg>";
  for (unsigned seed = 0; seed < 3000; ++seed) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    std::string document = whole;
    for (unsigned i = 0; i <= seed % 4; ++i) {
      const std::size_t at = random() % document.size();
      if (random() % 2)
        document[at] = static_cast<char>(32 + random() % 95);
      else
        document.erase(at, random() % 8);
    }
    message(document);
  }
}

}  // namespace
}  // namespace impedraw
