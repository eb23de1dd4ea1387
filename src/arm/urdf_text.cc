#include "impedraw/arm/urdf_text.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/input_file.h"

namespace impedraw {
namespace {

constexpr std::size_t kLargest = 4'000'000;  // [bytes]
constexpr std::size_t kDeepest = 16;
constexpr int kMostElements = 20'000;
// A constant of xacro, which some leave in what they ship: nothing reads it.
constexpr std::string_view kUnread = "xacro:property";

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool is_name(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '-' || c == '.' || c == ':' || (c & 0x80);
}

// Stricter than XML: what it accepts, every XML library takes apart in the same way.
class Scan {
 public:
  Scan(std::string_view text, const std::string& name) : all_(text), text_(text), name_(name) {}

  void run() {
    if (text_.size() > kLargest) too_large(text_.size());
    if (text_.find('\0') != std::string_view::npos) fail("not a text");
    if (text_.starts_with("\xef\xbb\xbf")) text_.remove_prefix(3);
    while (!text_.empty()) {
      if (text_.front() != '<') {
        characters();
      } else if (text_.starts_with("<!--")) {
        skip_to("-->", "comment");
      } else if (text_.starts_with("<?")) {
        skip_to("?>", "declaration");
      } else if (text_.starts_with("<![CDATA[") && !open_.empty()) {
        skip_to("]]>", "CDATA section");
      } else if (text_.starts_with("<!")) {
        fail("a document type declaration, which no URDF needs");
      } else if (text_.starts_with("</")) {
        close_tag();
      } else {
        open_tag();
      }
    }
    if (!open_.empty()) fail(fmt::format("the file ends within <{}>", open_.back()));
    if (elements_ == 0) fail("holds no element, must hold a <robot>");
  }

  [[noreturn]] void too_large(std::size_t bytes) const {
    throw InputError(fmt::format("arm description {}: {:.1f} MB, at most {:.0f} MB are read", name_,
                                 1e-6 * static_cast<double>(bytes), 1e-6 * kLargest));
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    const auto line = 1 + std::count(all_.begin(), all_.end() - text_.size(), '\n');
    throw InputError(fmt::format("arm description {}: line {}: {}", name_, line, what));
  }

  [[noreturn]] void not_expanded(std::string_view what) const {
    fail(
        fmt::format("{} is xacro, which a URDF is made from; valid is what xacro makes of it: "
                    "xacro {} > arm.urdf",
                    what, name_));
  }

  void characters() {
    const std::size_t end = std::min(text_.find('<'), text_.size());
    if (open_.empty() && !std::all_of(text_.begin(), text_.begin() + end, is_blank))
      fail("text outside of the root element; a URDF is XML");
    text_.remove_prefix(end);
  }

  void skip_to(std::string_view end, const char* what) {
    const std::size_t at = text_.find(end, 2);
    if (at == std::string_view::npos) fail(fmt::format("a {} that does not end", what));
    text_.remove_prefix(at + end.size());
  }

  std::string_view take_name() {
    std::size_t n = 0;
    while (n < text_.size() && is_name(text_[n])) ++n;
    if (n == 0 || n > 100) fail("not valid XML: a name is expected");
    const std::string_view name = text_.substr(0, n);
    text_.remove_prefix(n);
    return name;
  }

  void skip_blanks() {
    while (!text_.empty() && is_blank(text_.front())) text_.remove_prefix(1);
  }

  void close_tag() {
    text_.remove_prefix(2);
    const std::string_view name = take_name();
    skip_blanks();
    if (!text_.starts_with('>')) fail(fmt::format("not valid XML: </{} does not end", name));
    if (open_.empty() || open_.back() != name)
      fail(open_.empty() ? fmt::format("not valid XML: </{}> without <{}>", name, name)
                         : fmt::format("not valid XML: </{}> closes <{}>", name, open_.back()));
    open_.pop_back();
    text_.remove_prefix(1);
  }

  void open_tag() {
    text_.remove_prefix(1);
    const std::string_view name = take_name();
    enter(name);
    while (true) {
      const bool separated = !text_.empty() && is_blank(text_.front());
      skip_blanks();
      if (text_.starts_with("/>")) {
        text_.remove_prefix(2);
        return;
      }
      if (text_.starts_with('>')) {
        text_.remove_prefix(1);
        open_.push_back(name);
        if (open_.size() > kDeepest) fail(fmt::format("nested deeper than {} elements", kDeepest));
        return;
      }
      if (!separated) fail(fmt::format("not valid XML: <{} does not end", name));
      attribute(name);
    }
  }

  void attribute(std::string_view element) {
    const std::string_view name = take_name();
    skip_blanks();
    if (!text_.starts_with('=')) fail(fmt::format("not valid XML: {} has no value", name));
    text_.remove_prefix(1);
    skip_blanks();
    const char quote = text_.empty() ? '\0' : text_.front();
    const std::size_t end =
        quote == '"' || quote == '\'' ? text_.find(quote, 1) : std::string_view::npos;
    if (end == std::string_view::npos)
      fail(fmt::format("not valid XML: the value of {} must be in quotes", name));
    const std::string_view value = text_.substr(0, end);
    if (value.find('<') != std::string_view::npos)
      fail(fmt::format("not valid XML: '<' in the value of {}", name));
    if (element != kUnread && value.find("${") != std::string_view::npos)
      not_expanded(fmt::format("the value of {}", name));
    text_.remove_prefix(end + 1);
  }

  void enter(std::string_view name) {
    if (open_.empty()) {
      if (elements_ > 0) fail(fmt::format("a second root element, <{}>", name));
      if (name != "robot")
        fail(fmt::format("the root element is <{}>, must be <robot>: not a URDF", name));
    }
    if (name.starts_with("xacro:") && name != kUnread) not_expanded(fmt::format("<{}>", name));
    if (name == "include") fail("<include> is not read; the whole arm must be in one file");
    if (!open_.empty() && open_.back() == "mujoco" && name != "compiler")
      fail(fmt::format("<{}> in <mujoco>; only <compiler> is read there", name));
    const bool below_robot = open_.size() == 1;
    if (below_robot && name == "link" && ++links_ > kMostUrdfLinks)
      fail(fmt::format("more than {} links", kMostUrdfLinks));
    if (below_robot && name == "joint" && ++joints_ > kMostUrdfLinks)
      fail(fmt::format("more than {} joints", kMostUrdfLinks));
    if (++elements_ > kMostElements) fail(fmt::format("more than {} elements", kMostElements));
  }

  std::string_view all_, text_;  // the whole, and what is left of it
  const std::string& name_;
  std::vector<std::string_view> open_;
  int elements_ = 0, links_ = 0, joints_ = 0;
};

}  // namespace

void require_urdf(std::string_view text, const std::string& name) { Scan(text, name).run(); }

void require_urdf_file(const std::filesystem::path& file) {
  const InputFile in(file, "arm description " + file.string());
  if (in.size() > kLargest) Scan("", file.string()).too_large(in.size());
  require_urdf(in.read(kLargest + 1), file.string());
}

}  // namespace impedraw
