#include "impedraw/capture/capture.h"

#include <algorithm>
#include <cmath>
#include <csetjmp>
#include <cstring>
#include <limits>
#include <set>

#include <fmt/format.h>
#include <png.h>
#include <nlohmann/json.hpp>

#include "impedraw/common/errors.h"
#include "impedraw/common/input_file.h"
#include "impedraw/common/range_check.h"

namespace impedraw {
namespace {

constexpr png_uint_32 kMostSide = 8192;            // [px]
constexpr std::size_t kMostPngBytes = 512u << 20;  // of a file

// libpng reports errors by longjmp: no object with a destructor may live in the function that it
// jumps out of, so that what is read stands here.
struct PngReading {
  std::string content;
  std::size_t at = 0;
  std::string error;
  png_structp png = nullptr;
  png_infop info = nullptr;
  std::vector<png_byte> rows;
  std::vector<png_bytep> row_starts;

  ~PngReading() { png_destroy_read_struct(&png, &info, nullptr); }
};

void png_failed(png_structp png, png_const_charp message) {
  static_cast<PngReading*>(png_get_error_ptr(png))->error = message;
  longjmp(png_jmpbuf(png), 1);
}

void png_warned(png_structp, png_const_charp) {}

void png_wants(png_structp png, png_bytep to, std::size_t count) {
  auto* reading = static_cast<PngReading*>(png_get_io_ptr(png));
  if (count > reading->content.size() - reading->at) png_error(png, "the file ends too early");
  std::memcpy(to, reading->content.data() + reading->at, count);
  reading->at += count;
}

// Reads rows of `bytes` a pixel. Returns false, with reading->error, if the file is damaged.
bool read_rows(PngReading* r, bool grey) {
  if (setjmp(png_jmpbuf(r->png))) return false;
  png_set_user_limits(r->png, kMostSide, kMostSide);
  png_set_read_fn(r->png, r, png_wants);
  png_read_info(r->png, r->info);
  const int depth = png_get_bit_depth(r->png, r->info);
  const int kind = png_get_color_type(r->png, r->info);
  if (grey) {
    if (kind != PNG_COLOR_TYPE_GRAY || depth != 16) png_error(r->png, "is no 16-bit grey image");
    png_set_swap(r->png);  // PNG is big-endian
  } else {
    png_set_expand(r->png);
    png_set_strip_16(r->png);
    png_set_strip_alpha(r->png);
    png_set_gray_to_rgb(r->png);
  }
  png_set_interlace_handling(r->png);
  png_read_update_info(r->png, r->info);
  const std::size_t row = png_get_rowbytes(r->png, r->info);
  const png_uint_32 height = png_get_image_height(r->png, r->info);
  r->rows.resize(row * height);
  r->row_starts.resize(height);
  for (png_uint_32 i = 0; i < height; ++i) r->row_starts[i] = r->rows.data() + i * row;
  png_read_image(r->png, r->row_starts.data());
  png_read_end(r->png, nullptr);
  return true;
}

void read_png(const std::filesystem::path& file, bool grey, PngReading* reading) {
  const InputFile input(file);
  if (input.size() > kMostPngBytes)
    throw InputError(fmt::format("{}: has {} bytes, at most {} are read", file.string(),
                                 input.size(), kMostPngBytes));
  reading->content = input.read(kMostPngBytes);
  const auto* start = reinterpret_cast<png_const_bytep>(reading->content.data());
  if (reading->content.size() < 8 || png_sig_cmp(start, 0, 8) != 0)
    throw InputError(file.string() + ": is no PNG image");
  reading->png = png_create_read_struct(PNG_LIBPNG_VER_STRING, reading, png_failed, png_warned);
  reading->info = reading->png ? png_create_info_struct(reading->png) : nullptr;
  if (!reading->info) throw std::bad_alloc();
  if (!read_rows(reading, grey))
    throw InputError(fmt::format("{}: {}", file.string(), reading->error));
}

}  // namespace

GreyImage read_grey_png(const std::filesystem::path& file) {
  PngReading reading;
  read_png(file, true, &reading);
  GreyImage image{static_cast<int>(png_get_image_width(reading.png, reading.info)),
                  static_cast<int>(png_get_image_height(reading.png, reading.info)),
                  {}};
  image.values.resize(reading.rows.size() / 2);
  std::memcpy(image.values.data(), reading.rows.data(), reading.rows.size());
  return image;
}

ColourImage read_colour_png(const std::filesystem::path& file) {
  PngReading reading;
  read_png(file, false, &reading);
  return {static_cast<int>(png_get_image_width(reading.png, reading.info)),
          static_cast<int>(png_get_image_height(reading.png, reading.info)),
          std::move(reading.rows)};
}

namespace {

using CaptureJson = nlohmann::json;

constexpr std::size_t kMostCaptureJson = 16u << 20;  // [bytes]
constexpr double kUnitLength = 1e-3;                 // of a quaternion's norm from 1

// Reads the values of one JSON object. Errors name the object and the key.
class CaptureObject {
 public:
  CaptureObject(const CaptureJson& json, std::string where)
      : json_(json), where_(std::move(where)) {
    if (!json_.is_object()) fail("must be an object { … }");
  }

  [[noreturn]] void fail(const std::string& why) const { throw InputError(where_ + ": " + why); }

  bool has(const char* key) {
    used_.insert(key);
    return json_.contains(key) && !json_[key].is_null();
  }

  const CaptureJson& value(const char* key) {
    if (!has(key)) fail(fmt::format("'{}' is missing", key));
    return json_[key];
  }

  double number(const char* key) { return number_of(value(key), key); }

  double number(const char* key, double without) { return has(key) ? number(key) : without; }

  int whole(const char* key, const Limit& limit) {
    const double x = number(key);
    require_in_range(where_ + "." + key, x, limit.range, limit.unit);
    if (x != std::floor(x)) fail(fmt::format("'{}' must be a whole number", key));
    return static_cast<int>(x);
  }

  std::string text(const char* key) {
    if (!value(key).is_string()) fail(fmt::format("'{}' must be a text", key));
    return json_[key].get<std::string>();
  }

  std::vector<double> numbers(const char* key) {
    const CaptureJson& list = value(key);
    if (!list.is_array()) fail(fmt::format("'{}' must be a list of numbers", key));
    std::vector<double> x;
    for (const CaptureJson& item : list) x.push_back(number_of(item, key));
    return x;
  }

  std::vector<double> numbers(const char* key, std::size_t count) {
    std::vector<double> x = numbers(key);
    if (x.size() != count)
      fail(fmt::format("'{}' has {} numbers, must have {}", key, x.size(), count));
    return x;
  }

  CaptureObject object(const char* key) { return {value(key), where_ + "." + key}; }

  void note_unknown(std::vector<std::string>* notes) const {
    for (const auto& [key, unused] : json_.items())
      if (!used_.contains(key)) notes->push_back(fmt::format("{}: '{}' is not read", where_, key));
  }

  const std::string& where() const { return where_; }

 private:
  double number_of(const CaptureJson& item, const char* key) const {
    const double x =
        item.is_number() ? item.get<double>() : std::numeric_limits<double>::quiet_NaN();
    if (!std::isfinite(x)) fail(fmt::format("'{}' must be a finite number", key));
    return x;
  }

  const CaptureJson& json_;
  std::string where_;
  std::set<std::string, std::less<>> used_;
};

// An image of the folder itself: a capture of somebody else's names no other file of this machine.
std::filesystem::path image_in(const std::filesystem::path& folder, CaptureObject& view,
                               const char* key) {
  const std::filesystem::path name = view.text(key);
  const bool leaves = name.is_absolute() || std::find(name.begin(), name.end(), "..") != name.end();
  if (name.empty() || leaves)
    view.fail(fmt::format("'{}' must be the name of a file in the capture's folder", key));
  return folder / name;
}

Pose pose_in(CaptureObject& view, const char* key, std::vector<std::string>* notes) {
  CaptureObject object = view.object(key);
  const std::vector<double> p = object.numbers("p", 3), q = object.numbers("q_wxyz", 4);
  const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  if (std::abs(rotation.norm() - 1) > kUnitLength)
    object.fail(fmt::format("'q_wxyz' has length {:.4f}, must have 1", rotation.norm()));
  object.note_unknown(notes);
  return {{p[0], p[1], p[2]}, rotation.normalized().toRotationMatrix()};
}

void read_distortion(CaptureObject object, Lens* lens, std::vector<std::string>* notes) {
  const std::string model = object.text("model");
  if (model == "none") {
    lens->model = Lens::Model::none;
  } else if (model == "brown_conrady" || model == "inverse_brown_conrady") {
    lens->model =
        model == "brown_conrady" ? Lens::Model::brown_conrady : Lens::Model::inverse_brown_conrady;
    const std::vector<double> k = object.numbers("coefficients", lens->k.size());
    std::copy(k.begin(), k.end(), lens->k.begin());
  } else {
    object.fail(fmt::format(
        "'model' is '{}'; valid are none, brown_conrady and inverse_brown_conrady", model));
  }
  object.has("coefficients");
  object.note_unknown(notes);
}

CapturedView read_view(const std::filesystem::path& folder, const CaptureJson& json, int index,
                       const TipPose& tip_pose, bool played_back, double* pixels,
                       std::vector<std::string>* notes) {
  CaptureObject object(json,
                       fmt::format("{}: views[{}]", (folder / "capture.json").string(), index));
  CapturedView view;
  view.lens.width = object.whole("width", Lens::Limits::size);
  view.lens.height = object.whole("height", Lens::Limits::size);
  view.lens.fx = object.number("fx");
  view.lens.fy = object.number("fy");
  for (const double f : {view.lens.fx, view.lens.fy})
    require_in_range(object.where() + ": fx or fy", f, Lens::Limits::focal_length.range, "px");
  view.lens.cx = object.number("cx");
  view.lens.cy = object.number("cy");
  if (object.has("distortion")) read_distortion(object.object("distortion"), &view.lens, notes);
  if (object.has("joints")) view.joints = object.numbers("joints");
  if (object.has("time")) view.time = object.number("time");
  if (object.has("noise")) {
    CaptureObject noise = object.object("noise");
    view.sigma_at_1m = noise.number("sigma_at_1m", 0.0);
    require_in_range(noise.where() + ".sigma_at_1m", view.sigma_at_1m,
                     DepthNoise::Limits::sigma_at_1m.range, "m");
    noise.note_unknown(notes);
  }
  if (object.has("X_WC") == object.has("X_EC"))
    object.fail("one of 'X_WC' and 'X_EC' must be there, and not both");
  if (object.has("X_WC")) {
    view.X_WC = pose_in(object, "X_WC", notes);
  } else {
    if (view.joints.empty()) object.fail("'X_EC' needs 'joints', the arm's at the exposure");
    const Pose X_EC = pose_in(object, "X_EC", notes);
    try {
      view.X_WC = tip_pose(view.joints) * X_EC;
    } catch (const InputError& e) {
      object.fail(e.what());
    }
  }
  view.file = image_in(folder, object, "depth");
  view.name = view.file.filename().string();
  view.quantum = object.number("depth_scale", 0.001);
  require_in_range(object.where() + ".depth_scale", view.quantum, Range::positive_to(1.0), "m");
  if (played_back && view.time.value_or(0.0) > 0.0) {
    object.has("color");
    object.note_unknown(notes);
    return view;
  }
  *pixels += static_cast<double>(view.lens.width) * view.lens.height;
  if (*pixels > Capture::Limits::pixels)
    object.fail(fmt::format("the views have more than {:.0f} million pixels, the most that is read",
                            Capture::Limits::pixels / 1e6));
  try {
    read_depth(&view);
  } catch (const InputError& e) {
    object.fail(e.what());
  }
  if (object.has("color")) {
    ColourImage image = read_colour_png(image_in(folder, object, "color"));
    if (image.width != view.lens.width || image.height != view.lens.height)
      object.fail(fmt::format("its colours have {} × {} px, its depths {} × {}", image.width,
                              image.height, view.lens.width, view.lens.height));
    view.rgb = std::move(image.rgb);
  }
  object.note_unknown(notes);
  return view;
}

}  // namespace

void read_depth(CapturedView* view) {
  const GreyImage image = read_grey_png(view->file);
  if (image.width != view->lens.width || image.height != view->lens.height)
    throw InputError(fmt::format("{} has {} × {} px, the view {} × {}", view->name, image.width,
                                 image.height, view->lens.width, view->lens.height));
  view->depth.width = image.width;
  view->depth.height = image.height;
  view->depth.depth.resize(image.values.size());
  std::transform(image.values.begin(), image.values.end(), view->depth.depth.begin(),
                 [scale = view->quantum](std::uint16_t value) {
                   return value ? value * scale : std::numeric_limits<double>::quiet_NaN();
                 });
}

Capture read_capture(const std::filesystem::path& folder, const TipPose& tip_pose,
                     bool played_back) {
  const std::filesystem::path file = folder / "capture.json";
  if (!std::filesystem::is_directory(folder))
    throw InputError(folder.string() + ": is no folder; a capture is a folder with capture.json");
  const CaptureJson json =
      CaptureJson::parse(InputFile(file).read(kMostCaptureJson), nullptr, false);
  if (json.is_discarded()) throw InputError(file.string() + ": is no valid JSON");
  CaptureObject object(json, file.string());
  if (object.text("format") != "impedraw-capture") object.fail("'format' must be impedraw-capture");
  if (object.number("version") != 1) object.fail("'version' must be 1");
  const CaptureJson& views = object.value("views");
  if (!views.is_array() || views.empty()) object.fail("'views' must be a list with a view or more");
  const int most = played_back ? Capture::Limits::played : Capture::Limits::views;
  if (views.size() > static_cast<std::size_t>(most))
    object.fail(fmt::format("has {} views, at most {} are read", views.size(), most));
  Capture capture;
  double pixels = 0;
  for (std::size_t i = 0; i < views.size(); ++i) {
    CapturedView view = read_view(folder, views[i], static_cast<int>(i), tip_pose, played_back,
                                  &pixels, &capture.notes);
    (view.depth.depth.empty() ? capture.played : capture.views).push_back(std::move(view));
  }
  std::stable_sort(capture.played.begin(), capture.played.end(),
                   [](const CapturedView& a, const CapturedView& b) { return *a.time < *b.time; });
  if (capture.views.empty())
    object.fail("has no view at time 0 or before, which shows the canvas before it moves");
  object.note_unknown(&capture.notes);
  return capture;
}

}  // namespace impedraw
