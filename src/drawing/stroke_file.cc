#include "impedraw/drawing/stroke_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include <fmt/core.h>

#include "impedraw/common/errors.h"
#include "impedraw/common/input_file.h"
#include "impedraw/common/text_fields.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;

bool same_word(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](unsigned char c, unsigned char d) {
    return std::tolower(c) == std::tolower(d);
  });
}

class Reading {
 public:
  Reading(const std::string& name, bool csv, PageUnit unit) : name_(name), csv_(csv), unit_(unit) {
    artwork_.name = name;
  }

  // `closed_by_end`: the text contains an End.
  Artwork read(std::string_view text, bool closed_by_end) {
    page_wanted_ = !csv_ || closed_by_end;
    while (!text.empty()) {
      const std::size_t end = text.find('\n');
      ++line_;
      take(trimmed(text.substr(0, end)));
      text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    }
    if (page_wanted_ && page_.isEmpty()) fail("the file ends before the page's width and height");
    if (!points_.empty() && closed_by_end && stroke_column_ < 0) {
      artwork_.warnings.push_back(
          fmt::format("the last stroke has no End: the file may be cut off after line {}", line_));
    }
    close();
    scale();
    return std::move(artwork_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}: line {}: {}", name_, line_, what));
  }

  void take(std::string_view line) {
    if (line.starts_with('#')) return;
    if (line.empty()) {
      if (csv_) close();
      return;
    }
    const std::vector<std::string_view> fields = fields_of(line);
    if (same_word(fields[0], "end") &&
        std::all_of(fields.begin() + 1, fields.end(), [](auto f) { return f.empty(); })) {
      if (page_wanted_ && page_.isEmpty()) fail("End before the page's width and height");
      if (points_.empty())
        artwork_.warnings.push_back(fmt::format("line {}: End of a stroke without points", line_));
      close();
      return;
    }
    const bool first = rows_++ == 0;
    if (csv_ && first && !number_in(fields[0])) return take_header(fields);
    if (page_wanted_ && page_.isEmpty()) return take_page(fields);
    if (static_cast<int>(fields.size()) != columns_) fail(desired(line));
    if (stroke_column_ >= 0) {
      if (fields[stroke_column_] != stroke_) close();
      stroke_ = fields[stroke_column_];
    }
    const Vector2d point(coordinate(fields[x_column_], line), coordinate(fields[y_column_], line));
    if (++count_ > kMostPoints) fail(fmt::format("more than {} points", kMostPoints));
    if (!points_.empty() && points_.back() == point) return;
    points_.push_back(point);
    if (press_column_ >= 0) press_.push_back(press(fields[press_column_]));
  }

  double press(std::string_view field) const {
    const char* const what = by_force_ ? "force" : "width";
    const double mm = by_force_ ? 1.0 : millimetres(unit_), most = by_force_ ? 1e3 : kFarthest;
    const auto value = number_in(field);
    if (!value || !(*value >= 0 && *value * mm <= most))
      fail(fmt::format("the {} is '{}'; it must be a number from 0 to {:.0e} {}", what, field, most,
                       by_force_ ? "N" : "mm"));
    return *value * mm;
  }

  void take_press_column(int width, int force) {
    if (width >= 0 && force >= 0) fail("both a width and a force: give one of them");
    by_force_ = force >= 0;
    press_column_ = std::max(width, force);
  }

  void take_header(const std::vector<std::string_view>& fields) {
    const auto column = [&](std::string_view name) {
      const auto at = std::find_if(fields.begin(), fields.end(),
                                   [&](std::string_view field) { return same_word(field, name); });
      return at == fields.end() ? -1 : static_cast<int>(at - fields.begin());
    };
    page_wanted_ = false;
    columns_ = static_cast<int>(fields.size());
    x_column_ = column("x");
    y_column_ = column("y");
    stroke_column_ = column("stroke");
    take_press_column(column("width"), column("force"));
    if (x_column_ < 0 || y_column_ < 0)
      fail("the header names no columns x and y (and perhaps stroke)");
    if (stroke_column_ < 0 && column("z") >= 0)
      fail(
          "a column z: a point cloud, not strokes; a canvas is made of a mesh of it (canvas.mesh)");
  }

  void take_page(const std::vector<std::string_view>& fields) {
    const bool is_width = fields.size() == 3 && same_word(fields[2], "width"),
               is_force = fields.size() == 3 && same_word(fields[2], "force");
    const bool fits = fields.size() == 2 || is_width || is_force;
    const auto width = fits ? number_in(fields[0]) : std::nullopt;
    const auto height = fits ? number_in(fields[1]) : std::nullopt;
    if (!width || !height)
      fail("must hold the page's width and height, two numbers, and perhaps 'width' or 'force'");
    take_press_column(is_width ? 2 : -1, is_force ? 2 : -1);
    columns_ += is_width || is_force;
    const double mm = millimetres(unit_);
    if (!(*width > 0 && *width * mm <= kFarthest && *height > 0 && *height * mm <= kFarthest)) {
      fail(fmt::format("the page is {} × {} mm; both must be > 0 and at most {:.0e}", *width * mm,
                       *height * mm, kFarthest));
    }
    page_ = Eigen::AlignedBox2d(Vector2d::Zero(), Vector2d(*width, *height));
  }

  std::string desired(std::string_view line) const {
    const std::string shown =
        line.size() > 40 ? std::string(line.substr(0, 40)) + " …" : std::string(line);
    const std::vector<std::string_view> fields = fields_of(line);
    const bool cloud =
        rows_ == 1 && fields.size() >= 3 &&
        std::all_of(fields.begin(), fields.end(), [](auto f) { return number_in(f).has_value(); });
    return fmt::format("'{}' where {} numbers or End must be{}", shown, columns_,
                       cloud ? ": a point cloud, not strokes?" : "");
  }

  double coordinate(std::string_view field, std::string_view line) const {
    const auto value = number_in(field);
    if (!value) fail(desired(line));
    if (!(std::abs(*value) * millimetres(unit_) <= kFarthest))
      fail(fmt::format("{} is not within ± {:.0e} mm", field, kFarthest));
    return *value;
  }

  void close() {
    if (points_.empty()) return;
    Stroke stroke;
    stroke.closed = points_.size() > 2 && points_.front() == points_.back();
    stroke.points = std::move(points_);
    stroke.press = std::move(press_);
    stroke.by_force = by_force_;
    points_.clear();
    press_.clear();
    artwork_.strokes.push_back(std::move(stroke));
  }

  void scale() {
    const Eigen::AlignedBox2d box = bounds_of(artwork_.strokes);
    if (!artwork_.strokes.empty()) artwork_.layers = {"page"};
    artwork_.page = page_.isEmpty() ? box : page_;
    const bool shares = unit_ == PageUnit::file && !page_.isEmpty() && !box.isEmpty() &&
                        page_.sizes().minCoeff() > 1 && box.min().minCoeff() >= 0 &&
                        box.max().maxCoeff() <= 1;
    if (const double mm = millimetres(unit_); mm != 1) {
      for (Stroke& stroke : artwork_.strokes) {
        for (Vector2d& p : stroke.points) p *= mm;
      }
      artwork_.page = Eigen::AlignedBox2d(mm * artwork_.page.min(), mm * artwork_.page.max());
    }
    if (!shares) return;
    artwork_.warnings.push_back(fmt::format(
        "all coordinates lie between 0 and 1: taken as fractions of the page, {} × {} mm",
        page_.max().x(), page_.max().y()));
    for (Stroke& stroke : artwork_.strokes) {
      for (Vector2d& p : stroke.points) p = p.cwiseProduct(page_.max());
    }
  }

  std::string name_;
  bool csv_;
  PageUnit unit_;
  bool page_wanted_ = true;
  int line_ = 0, rows_ = 0;
  std::size_t count_ = 0;  // of points
  int columns_ = 2, x_column_ = 0, y_column_ = 1, stroke_column_ = -1, press_column_ = -1;
  bool by_force_ = false;      // the column of widths has forces
  std::vector<double> press_;  // [mm] or [N]
  std::string stroke_;         // last value of its column
  Eigen::AlignedBox2d page_;
  std::vector<Vector2d> points_;
  Artwork artwork_;
};

bool has_end(std::string_view text) {
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    const std::vector<std::string_view> fields = fields_of(trimmed(text.substr(0, end)));
    if (!fields.empty() && same_word(fields[0], "end")) return true;
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
  }
  return false;
}

}  // namespace

double millimetres(PageUnit unit) {
  switch (unit) {
    case PageUnit::cm:
      return 10;
    case PageUnit::in:
      return 25.4;
    case PageUnit::m:
      return 1000;
    case PageUnit::px:
      return 25.4 / 96;
    default:
      return 1;
  }
}

Artwork parse_strokes(std::string_view text, const std::string& name, bool csv,
                      const StrokeFileSettings& settings) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  if (text.find('\0') != std::string_view::npos)
    throw InputError(fmt::format("{}: not a text file of strokes", name));
  Artwork artwork = Reading(name, csv, settings.unit).read(text, has_end(text));
  if (artwork.strokes.empty()) {
    if (!settings.may_be_empty) throw InputError(fmt::format("{}: there is no stroke in it", name));
    artwork.warnings.push_back("there is no stroke in it");
  }
  return artwork;
}

Artwork read_strokes(const std::filesystem::path& file, const StrokeFileSettings& settings) {
  const InputFile in(file);
  const double megabytes = static_cast<double>(in.size()) / 1e6;
  if (megabytes > settings.largest_file_mb) {
    throw InputError(fmt::format("{}: {:.0f} MB; strokes may take up to {:.0f} MB", file.string(),
                                 megabytes, settings.largest_file_mb));
  }
  const std::string text = in.read(static_cast<std::size_t>(1e6 * settings.largest_file_mb));
  std::string extension = file.extension().string();
  return parse_strokes(text, file.string(), same_word(extension, ".csv"), settings);
}

}  // namespace impedraw
