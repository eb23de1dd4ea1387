#include "impedraw/page/page.h"

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string_view>
#include <utility>

#include <zlib.h>

#include "impedraw/common/in_parallel.h"

// The program of the page, made by web/build.mjs, and the commit.
extern "C" {
extern const char impedraw_page_begin[];
extern const char impedraw_page_end[];
extern const char impedraw_commit_begin[];
extern const char impedraw_place_page_begin[];
}
__asm__(
    ".section .rodata\n"
    ".global impedraw_page_begin\n"
    ".global impedraw_page_end\n"
    "impedraw_page_begin:\n"
    ".incbin \"" IMPEDRAW_PAGE
    "\"\n"
    "impedraw_page_end:\n"
    ".byte 0\n"
    ".global impedraw_place_page_begin\n"
    "impedraw_place_page_begin:\n"
    ".incbin \"" IMPEDRAW_PLACE_PAGE
    "\"\n"
    ".byte 0\n"
    ".global impedraw_commit_begin\n"
    "impedraw_commit_begin:\n"
    ".incbin \"" IMPEDRAW_COMMIT
    "\"\n"
    ".byte 0\n"
    ".previous\n");

namespace impedraw {

std::string commit();  // page_json.h, which brings nlohmann's names

namespace {

// One stream (zlib's format) of two halves that are made at once: the first ends on a whole byte.
std::string deflated(std::string_view bytes) {
  constexpr int kLevel = 4;  // 6 takes twice as long, and makes the data 3 % smaller
  constexpr int kRaw = -15;  // without the format's head and sum
  const std::array<std::string_view, 2> halves{bytes.substr(0, bytes.size() / 2),
                                               bytes.substr(bytes.size() / 2)};
  std::array<std::string, 2> out;
  std::array<uLong, 2> sums{};
  in_parallel(2, [&](int i) {
    const auto size = static_cast<uInt>(halves[i].size());
    const auto* const data = reinterpret_cast<const Bytef*>(halves[i].data());
    sums[i] = adler32(adler32(0, nullptr, 0), data, size);
    z_stream z{};
    if (deflateInit2(&z, kLevel, Z_DEFLATED, kRaw, 8, Z_DEFAULT_STRATEGY) != Z_OK)
      throw std::runtime_error("the page's data cannot be compressed: no memory");
    out[i].resize(deflateBound(&z, size) + 16);  // and the flush
    z.next_in = const_cast<Bytef*>(data);
    z.avail_in = size;
    z.next_out = reinterpret_cast<Bytef*>(out[i].data());
    z.avail_out = static_cast<uInt>(out[i].size());
    deflate(&z, i == 0 ? Z_FULL_FLUSH : Z_FINISH);
    out[i].resize(z.total_out);
    deflateEnd(&z);
  });
  const uLong sum = adler32_combine(sums[0], sums[1], static_cast<z_off_t>(halves[1].size()));
  std::string all = "\x78\x5e" + out[0] + out[1];
  for (int shift = 24; shift >= 0; shift -= 8) all += static_cast<char>((sum >> shift) & 0xff);
  return all;
}

std::string base64(std::string_view bytes) {
  static constexpr char kDigits[] =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) -> std::uint32_t {
      return k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0u;
    };
    const std::uint32_t three = byte(i) << 16 | byte(i + 1) << 8 | byte(i + 2);
    for (int k = 0; k < 4; ++k)
      out += i + k > bytes.size() ? '=' : kDigits[(three >> (18 - 6 * k)) & 63];
  }
  return out;
}

std::string escaped(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

}  // namespace

std::string commit() {
  const std::string_view line = impedraw_commit_begin;
  return std::string(line.substr(0, line.find('\n')));
}

std::string place_page_html() { return impedraw_place_page_begin; }

std::string page_html(const std::string& title, const std::vector<PagePayload>& payloads,
                      const std::string& socket) {
  std::string all;
  for (const PagePayload& payload : payloads) {
    std::string data;
    for (int shift = 0; shift < 32; shift += 8)
      data += static_cast<char>((payload.json.size() >> shift) & 0xff);
    data += payload.json;
    data += payload.columns;
    if (!all.empty()) all += ',';
    all += base64(deflated(data));
  }

  std::string_view page(impedraw_page_begin,
                        static_cast<std::size_t>(impedraw_page_end - impedraw_page_begin));
  std::string out;
  for (const auto& [mark, text] :
       {std::pair<std::string_view, std::string>{
            "@CONNECT@", socket.empty() ? std::string() : "; connect-src " + escaped(socket)},
        {"@TITLE@", escaped(title)},
        {"@DATA@", std::move(all)}}) {
    const std::size_t at = page.find(mark);
    if (at == std::string_view::npos) throw std::logic_error("the page's template lacks a mark");
    out += page.substr(0, at);
    out += text;
    page.remove_prefix(at + mark.size());
  }
  out += page;
  return out;
}

}  // namespace impedraw
