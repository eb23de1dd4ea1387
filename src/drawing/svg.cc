#include "impedraw/drawing/svg.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include <fmt/format.h>

#include "impedraw/common/cross.h"
#include "impedraw/common/errors.h"
#include "impedraw/common/input_file.h"
#include "impedraw/drawing/bounded.h"
#include "impedraw/drawing/doubles.h"
#include "impedraw/drawing/svg_subpaths.h"
#include "impedraw/drawing/usvg/impedraw_usvg.h"
#include "impedraw/drawing/visible.h"

namespace impedraw {
namespace {

using Eigen::Vector2d;
constexpr double kSamePoint = 1e-6;   // [mm]
constexpr double kSameLine = 1e-3;    // distance of lines drawn once, of the drawing's diagonal,
constexpr double kSameLineMm = 0.1;   // and at most
constexpr double kSeconds = 12;       // of CPU time to find what is hidden
constexpr std::size_t kMostPens = 8;  // colours that become layers by themselves
constexpr unsigned kWhite = 250;      // least red, green and blue of white
constexpr double kSamePage = 1e-4;    // of a white page's edge to the page's, of its diagonal

bool has_area(const std::vector<Vector2d>& line) {
  const Vector2d& origin = line.front();
  double longest = 0, widest = 0;
  Vector2d far = origin;
  for (const Vector2d& p : line) {
    if ((p - origin).norm() > longest) longest = (p - origin).norm(), far = p;
  }
  for (const Vector2d& p : line)
    widest = std::max(widest, std::abs(cross(far - origin, p - origin)));
  return widest > 1e-6 * longest * longest;
}

bool is_white(std::uint32_t colour) {
  return (colour >> 16 & 0xff) >= kWhite && (colour >> 8 & 0xff) >= kWhite &&
         (colour & 0xff) >= kWhite;
}

// By what rounding may move a page's edge.
Eigen::AlignedBox2d grown(const Eigen::AlignedBox2d& page) {
  const Vector2d spare = Vector2d::Constant(kSamePage * page.diagonal().norm());
  return {page.min() - spare, page.max() + spare};
}

// True if the path is the page's background: a white rectangle that covers the whole page.
bool is_ground(const std::vector<std::vector<Vector2d>>& lines, const ImpedrawSvgPath& path,
               const Eigen::AlignedBox2d& page) {
  if (!path.filled || !is_white(path.fill) || path.stroked || lines.size() != 1 ||
      lines[0].size() < 4)
    return false;
  Eigen::AlignedBox2d box;
  for (const Vector2d& p : lines[0]) box.extend(p);
  const double hair = kSamePage * page.diagonal().norm();
  if (!grown(box).contains(page)) return false;
  return std::all_of(lines[0].begin(), lines[0].end(), [&](const Vector2d& p) {
    return ((p - box.min()).cwiseAbs().cwiseMin((p - box.max()).cwiseAbs()).array() <= hair).all();
  });
}

std::vector<Vector2d> page_outline(const Eigen::AlignedBox2d& page) {
  return {
      page.min(), {page.max().x(), page.min().y()}, page.max(), {page.min().x(), page.max().y()}};
}

// The fill is no shape of the document's: it is there for what it hides.
bool only_hides(const ImpedrawSvgPath& path) {
  return path.hides == IMPEDRAW_SVG_WHITE_STROKE || path.hides == IMPEDRAW_SVG_VEIL;
}

// Share of a pure ink on white paper that gives the colour: 1 for black, red or dark red, 1/2 for
// a medium grey or a pink.
double ink_share(const Tint& tint) { return tint[3] * (1 - tint.head<3>().minCoeff()); }

Tint tint_of(std::uint32_t colour, double opacity) {
  const auto channel = [&](int shift) { return (colour >> shift & 0xff) / 255.0; };
  return {channel(16), channel(8), channel(0), opacity};
}

// The share of a paint that the groups around it let through.
double opacity_around(const Paint& paint, const std::vector<PaintGroup>& groups) {
  double opacity = 1;
  for (int group = paint.group; group >= 0; group = groups[group].parent)
    opacity *= groups[group].opacity;
  return opacity;
}

// Indices of the layers by colour, in order of appearance; empty: groups are layers.
std::map<std::uint32_t, int> colour_layers(const ImpedrawSvg& svg, LayerSource source) {
  std::map<std::uint32_t, int> layers;
  for (const ImpedrawSvgPath* path = svg.paths; path != svg.paths + svg.path_count; ++path) {
    if (path->shapes > 0 || only_hides(*path)) continue;
    for (const auto& [shows, colour] :
         {std::pair{path->stroked, path->stroke}, {path->filled, path->fill}}) {
      if (shows && !is_white(colour)) layers.emplace(colour, static_cast<int>(layers.size()));
    }
  }
  const bool plain =
      !svg.named && svg.layer_count <= 1 && layers.size() > 1 && layers.size() <= kMostPens;
  if (source == LayerSource::groups || (source == LayerSource::automatic && !plain)) layers.clear();
  return layers;
}

// The subpath as a stroke; without points if nothing is visible.
Stroke stroke_of(const SvgSubpath& subpath, std::vector<Vector2d> line, bool stroked) {
  Stroke stroke;
  stroke.layer = static_cast<int>(subpath.path->layer);
  stroke.edge = !stroked;
  stroke.colour = stroked ? subpath.path->stroke : subpath.path->fill;
  if (stroked) stroke.width = subpath.path->width;
  if (!stroked && !has_area(line)) return stroke;
  const bool closed = subpath.closed || !stroked;
  if (closed) line.push_back(line.front());
  for (const Vector2d& p : line) {
    if (stroke.points.empty() || (p - stroke.points.back()).norm() > kSamePoint)
      stroke.points.push_back(p);
  }
  if (stroke.points.size() == 1) {  // zero length: a dot if the line caps make one
    if (!subpath.path->caps || (subpath.segments.empty() && !subpath.closed)) stroke.points.clear();
    return stroke;
  }
  // Close exactly: rounding may have separated the two ends slightly.
  stroke.closed = closed || stroke.points.front() == stroke.points.back();
  if (closed) stroke.points.back() = stroke.points.front();
  return stroke;
}

// The area that the path fills, with these lines as its subpaths.
Area area_of(const std::vector<std::vector<Vector2d>>& lines, const ImpedrawSvgPath& path) {
  Area area{{}, path.even_odd != 0, static_cast<int>(path.layer), path.fill};
  for (const std::vector<Vector2d>& line : lines) {
    if (path.filled && has_area(line)) area.outlines.push_back(line);
  }
  return area;
}

// Index of the path's dash in `dashes`; −1 if it has none, or if its transform leaves no length
// to measure. A pathLength stretches the dashes (SVG 2, 9.6.1); if it is 0, the line is solid.
int add_dash(const ImpedrawSvgPath& path, const double* lengths,
             const std::vector<std::vector<Vector2d>>& lines, const SvgSubpath* subpaths,
             std::vector<Dash>& dashes) {
  if (path.dash_count == 0 || path.path_length == 0) return -1;
  const double* t = path.transform;
  const Eigen::Matrix2d to_page = (Eigen::Matrix2d() << t[0], t[1], t[2], t[3]).finished();
  if (!(std::abs(to_page.determinant()) > 1e-12 * to_page.squaredNorm())) return -1;
  Dash dash{
      {lengths, lengths + path.dash_count}, path.dash_offset, to_page.inverse(), path.caps != 0};
  if (path.path_length > 0) {
    double length = 0;
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const std::vector<Vector2d>& line = lines[i];
      for (std::size_t k = 1; k < line.size(); ++k)
        length += (dash.to_pattern * (line[k] - line[k - 1])).norm();
      if (subpaths[i].closed) length += (dash.to_pattern * (line.front() - line.back())).norm();
    }
    for (double& entry : dash.lengths) entry *= length / path.path_length;
    dash.offset *= length / path.path_length;
    if (!(length > 0)) return -1;
  }
  dashes.push_back(std::move(dash));
  return static_cast<int>(dashes.size()) - 1;
}

// The painting, and the part that is seen: strokes, areas and lengths [mm].
struct Painting {
  std::vector<Paint> paints;
  std::vector<Clip> clips;
  std::vector<PaintGroup> groups;
  std::vector<Dash> dashes;
  Hidden hidden;
  double doubled_mm = 0;
};

void find_visible(Painting& painting) {
  painting.hidden = keep_visible(painting.paints, painting.clips, painting.dashes, painting.groups);
  std::vector<Stroke> strokes;
  for (Paint& paint : painting.paints) {
    std::move(paint.strokes.begin(), paint.strokes.end(), std::back_inserter(strokes));
    paint.strokes.clear();
  }
  const Eigen::AlignedBox2d ink = bounds_of(strokes);
  if (ink.isEmpty()) return;
  painting.doubled_mm =
      drop_doubles(strokes, std::min(kSameLine * ink.diagonal().norm(), kSameLineMm));
  painting.paints.push_back({std::move(strokes)});
}

// Puts what the eye sees of the painting into the artwork.
void look_at(Painting painting, bool as_painted, Artwork& artwork) {
  const auto shared = std::make_shared<Painting>(std::move(painting));
  try {
    if (as_painted && !done_within(kSeconds, [shared] { find_visible(*shared); }))
      throw InputError(fmt::format("takes longer than {:.0f} s to find", kSeconds));
  } catch (const InputError& error) {
    throw InputError(fmt::format(
        "{}: what its fills, clip paths and masks hide: {}; drawing.visible=all draws it as if "
        "nothing were hidden",
        artwork.name, error.what()));
  }
  for (Paint& paint : shared->paints) {
    std::move(paint.strokes.begin(), paint.strokes.end(), std::back_inserter(artwork.strokes));
    if (paint.inked && !paint.area.outlines.empty()) artwork.areas.push_back(std::move(paint.area));
  }
  artwork.dashes = std::move(shared->dashes);
  artwork.hidden_mm = shared->hidden.length;
  artwork.doubled_mm = shared->doubled_mm;
  if (artwork.doubled_mm >= 0.05) {
    artwork.warnings.push_back(
        fmt::format("{:.1f} mm of lines lie on others: drawn once", artwork.doubled_mm));
  }
  if (artwork.hidden_mm >= 0.05) {
    artwork.warnings.push_back(
        fmt::format("{:.1f} mm of lines are hidden by fills, wide strokes, clip paths, masks or "
                    "the page's edge: left out",
                    artwork.hidden_mm));
  }
  if (shared->hidden.in_part)
    artwork.warnings.push_back(
        "so much lies over one another that some of what is hidden is drawn, too");
  if (!as_painted && shared->clips.size() > 1)
    artwork.warnings.push_back("clip paths and masks are passed over: what they hide is drawn");
}

struct LeftOut {
  std::map<std::string, std::size_t> off;  // strokes, by layer
  std::size_t grounds = 0, flat = 0, white = 0;
  Vector2d first_flat = Vector2d::Zero();
};

void tell_white_and_off(const LeftOut& left_out, Artwork& artwork) {
  if (left_out.white > 0) {
    artwork.warnings.push_back(fmt::format("{} white shape{} left out, as white is the paper",
                                           left_out.white, left_out.white == 1 ? "" : "s"));
  }
  for (const auto& [layer, strokes] : left_out.off)
    artwork.warnings.push_back(fmt::format("the layer '{}' is off (%): {} stroke{} left out", layer,
                                           strokes, strokes == 1 ? "" : "s"));
}

void tell_grounds_and_flat(const LeftOut& left_out, Artwork& artwork) {
  if (left_out.grounds > 0) {
    artwork.warnings.push_back(
        fmt::format("{} white rectangle{} over the whole page: left out, because the page's "
                    "background is not drawn",
                    left_out.grounds, left_out.grounds == 1 ? "" : "s"));
  }
  if (left_out.flat > 0) {
    artwork.warnings.push_back(fmt::format(
        "{} filled shape{} left out, as {} no area (the first at {:.4g}, {:.4g} mm)", left_out.flat,
        left_out.flat == 1 ? "" : "s", left_out.flat == 1 ? "it encloses" : "they enclose",
        left_out.first_flat.x(), left_out.first_flat.y()));
  }
}

void require_strokes(const SvgSettings& settings, Artwork& artwork) {
  const std::string nothing = "has nothing to draw: no visible path or shape";
  if (artwork.strokes.empty() && !settings.may_be_empty) {
    const std::string why = fmt::format("{}", fmt::join(artwork.warnings, "; "));
    throw InputError(
        fmt::format("{}: {}{}", artwork.name, nothing, why.empty() ? why : " (" + why + ")"));
  }
  if (artwork.strokes.empty()) artwork.warnings.push_back(nothing);
}

// Reads a document's paths in the order in which they are painted.
class SvgReading {
 public:
  SvgReading(std::shared_ptr<const ImpedrawSvg> svg, const std::string& name,
             const SvgSettings& settings)
      : svg_(std::move(svg)),
        settings_(settings),
        as_painted_(settings.visible == Visible::as_painted),
        subpaths_(svg_subpaths(*svg_, name)),
        subpath_(subpaths_.data()),
        dash_lengths_(svg_->dashes),
        letters_(settings.single_font),
        by_colour_(colour_layers(*svg_, settings.layers)) {
    artwork_.name = name;
    artwork_.page =
        Eigen::AlignedBox2d(Vector2d::Zero(), Vector2d(svg_->width_mm, svg_->height_mm));
    artwork_.layers.assign(svg_->layers, svg_->layers + svg_->layer_count);
    artwork_.warnings.assign(svg_->warnings, svg_->warnings + svg_->warning_count);
    if (!by_colour_.empty()) {
      artwork_.layers.resize(by_colour_.size());
      for (const auto& [colour, index] : by_colour_) artwork_.layers[index] = colour_name(colour);
    }
    const Eigen::AlignedBox2d painted = painted_box(subpaths_);
    flatten_.turn = settings.turn;
    if (!subpaths_.empty())
      flatten_.tolerance =
          std::min(settings.tolerance_mm,
                   std::max(settings.relative_tolerance * painted.diagonal().norm(), 1e-6));
    fits_ = grown(artwork_.page).contains(painted);
    painting_.paints.resize(svg_->path_count);
    painting_.clips.push_back({-1, false, {{{{page_outline(artwork_.page)}}}}});
    for (std::size_t i = 0; i < svg_->clip_count; ++i)
      painting_.clips.push_back({clip_of(svg_->clips[i].parent), svg_->clips[i].mask != 0, {}});
    for (std::size_t i = 0; i < svg_->group_count; ++i)
      painting_.groups.push_back({static_cast<int>(svg_->groups[i].parent) - 1,
                                  svg_->groups[i].opacity, svg_->groups[i].blend});
  }

  Artwork read() {
    for (std::size_t i = 0; i < svg_->path_count; ++i) take(i);
    look_at(std::move(painting_), as_painted_, artwork_);
    if (const std::string lacking = letters_.lacking(); !lacking.empty())
      artwork_.warnings.push_back(lacking);
    tell_white_and_off(left_out_, artwork_);
    drop_empty_layers(artwork_, true);
    order_layers(artwork_);
    tell_grounds_and_flat(left_out_, artwork_);
    require_strokes(settings_, artwork_);
    return std::move(artwork_);
  }

 private:
  // A path on the page: a line for each of its subpaths, or the lines of its letter.
  struct Outline {
    const ImpedrawSvgPath& path;
    const SvgSubpath* subpaths;
    std::vector<std::vector<Vector2d>> lines;
    int dash;  // index in the painting's, or -1

    const SvgSubpath& subpath(std::size_t line) const {
      return subpaths[path.letter[0] > 0 ? 0 : line];
    }
  };

  // If something reaches beyond the page, the page clips what no other clip does.
  int clip_of(std::uint32_t clip) const { return clip > 0 || !fits_ ? static_cast<int>(clip) : -1; }

  int layer_of(std::uint32_t colour, int group) const {
    const auto found = by_colour_.find(colour);
    return by_colour_.empty() ? group : found == by_colour_.end() ? 0 : found->second;
  }

  // The outline of the next path of the document.
  Outline next_outline(const ImpedrawSvgPath& path) {
    Outline outline{path, subpath_, {}, -1};
    for (; subpath_ != subpaths_.data() + subpaths_.size() && subpath_->path == &path; ++subpath_) {
      if (path.letter[0] > 0)
        outline.lines = letters_.strokes_of(*subpath_);
      else
        outline.lines.push_back(flatten(*subpath_, flatten_, artwork_.name));
    }
    outline.dash = add_dash(path, dash_lengths_, outline.lines, outline.subpaths, painting_.dashes);
    dash_lengths_ += path.dash_count;
    return outline;
  }

  void take(std::size_t index) {
    const ImpedrawSvgPath& path = svg_->paths[index];
    const Outline outline = next_outline(path);
    if (path.shapes > 0) {
      painting_.clips[path.shapes].shapes.push_back(
          {area_of(outline.lines, path), path.clip > 0 ? static_cast<int>(path.clip) : -1,
           path.value, path.alpha});
      return;
    }
    const std::string group = svg_->layers[path.layer];
    if (layer_marks(group).off) {
      left_out_.off[group] += outline.lines.size();
      return;
    }
    const bool strokes = path.stroked && !(as_painted_ && is_white(path.stroke)),
               fills = path.filled && !is_white(path.fill), eraser = only_hides(path);
    Paint& paint = painting_.paints[index] = paint_of(outline, index);
    paint.inked = fills;
    if (strokes && path.covers) paint.covers_from = path.covers_from;
    const bool ground = !eraser && is_ground(outline.lines, path, artwork_.page);
    left_out_.grounds += ground;
    if (eraser || ground || paint.soft > 0) return;
    if (as_painted_ && !strokes && !fills)
      ++left_out_.white;
    else
      add_strokes(outline, strokes, strokes && fills, paint);
  }

  // The area that the path fills and covers, without its strokes.
  Paint paint_of(const Outline& outline, std::size_t index) const {
    const ImpedrawSvgPath& path = outline.path;
    Paint paint;
    paint.area = area_of(outline.lines, path);
    paint.veil = path.hides == IMPEDRAW_SVG_VEIL;
    paint.hides = path.hides != IMPEDRAW_SVG_NOTHING && !paint.veil;
    paint.hides_from = path.hides_from;
    paint.clip = clip_of(path.clip);
    paint.round = path.caps;
    paint.soft = path.soft;
    paint.opacity = path.opacity, paint.stroke_opacity = path.stroke_opacity;
    paint.group = static_cast<int>(path.group) - 1;
    paint.shaded = path.shaded[0], paint.shaded_strokes = path.shaded[1];
    if (paint.shaded || paint.shaded_strokes) {
      paint.shade = [svg = svg_, index](const Vector2d& p, bool of_stroke) {
        float rgba[4];
        impedraw_svg_shade(svg.get(), index, of_stroke, p.x(), p.y(), rgba);
        return Tint(rgba[0], rgba[1], rgba[2], rgba[3]);
      };
    }
    const double around = opacity_around(paint, painting_.groups);
    paint.area.tone = around * ink_share(tint_of(path.fill, paint.opacity));
    if (paint.shaded)
      paint.area.tone_at = [shade = paint.shade, around](const Vector2d& p) {
        return around * ink_share(shade(p, false));
      };
    paint.area.layer = layer_of(path.fill, paint.area.layer);
    return paint;
  }

  void add_strokes(const Outline& outline, bool strokes, bool on_a_fill, Paint& paint) {
    for (std::size_t i = 0; i < outline.lines.size(); ++i) {
      const SvgSubpath& subpath = outline.subpath(i);
      Stroke stroke = stroke_of(subpath, outline.lines[i], strokes);
      if (!outline.path.stroked && stroke.points.empty() && !subpath.segments.empty() &&
          left_out_.flat++ == 0)
        left_out_.first_flat = subpath.start;
      stroke.dash = outline.dash;
      stroke.layer = layer_of(stroke.colour, stroke.layer);
      points_ += stroke.points.size();
      require_few_points(points_, flatten_, artwork_.name);
      stroke.points.shrink_to_fit();
      const bool is_line = stroke.points.size() > 2;
      if (!stroke.points.empty()) paint.strokes.push_back(std::move(stroke));
      if (as_painted_ && on_a_fill && is_line) add_open_side(outline, i, paint);
    }
  }

  // A stroke leaves the side of a fill open that closes it.
  void add_open_side(const Outline& outline, std::size_t i, Paint& paint) const {
    const std::vector<Vector2d>& line = outline.lines[i];
    if (outline.subpath(i).closed || line.size() <= 2 || line.front() == line.back()) return;
    if (outline.path.fill == outline.path.stroke && outline.dash < 0) {
      Stroke& stroke = paint.strokes.back();
      stroke.points.push_back(stroke.points.front());
      stroke.closed = true;
      return;
    }
    Stroke side = stroke_of(outline.subpath(i), {line.back(), line.front()}, true);
    side.edge = true, side.width = 0, side.colour = outline.path.fill, side.closed = false;
    side.layer = layer_of(side.colour, side.layer);
    if (side.points.size() == 2) paint.strokes.push_back(std::move(side));
  }

  const std::shared_ptr<const ImpedrawSvg> svg_;
  const SvgSettings& settings_;
  const bool as_painted_;
  const std::vector<SvgSubpath> subpaths_;
  const SvgSubpath* subpath_;   // the first of the next path
  const double* dash_lengths_;  // of the next path
  SvgLetters letters_;
  const std::map<std::uint32_t, int> by_colour_;
  FlattenSettings flatten_;
  bool fits_ = true;  // nothing reaches beyond the page
  std::size_t points_ = 0;
  Artwork artwork_;
  Painting painting_;
  LeftOut left_out_;
};

}  // namespace

Artwork parse_svg(std::string_view document, const std::string& name, const SvgSettings& settings) {
  if (!(settings.tolerance_mm > 0) || !(settings.relative_tolerance > 0) || !(settings.turn > 0)) {
    throw InputError(
        fmt::format("svg tolerance: {} mm, {} of the diagonal and {} rad; all must be > 0",
                    settings.tolerance_mm, settings.relative_tolerance, settings.turn));
  }
  const std::shared_ptr<const ImpedrawSvg> svg(
      (settings.single_font.empty() ? impedraw_svg_read : impedraw_svg_letters)(
          reinterpret_cast<const std::uint8_t*>(document.data()), document.size()),
      [](const ImpedrawSvg* read) { impedraw_svg_free(read); });
  if (svg->error) throw InputError(fmt::format("{}: cannot be read as SVG: {}", name, svg->error));
  return SvgReading(svg, name, settings).read();
}

Artwork read_svg(const std::filesystem::path& file, const SvgSettings& settings) {
  const InputFile in(file);
  const double megabytes = static_cast<double>(in.size()) / 1e6;
  if (megabytes > settings.largest_file_mb) {
    throw InputError(fmt::format("{}: {:.0f} MB; an SVG may have up to {:.0f} MB", file.string(),
                                 megabytes, settings.largest_file_mb));
  }
  const std::string text = in.read(static_cast<std::size_t>(1e6 * settings.largest_file_mb));
  if (text.starts_with("\x1f\x8b"))
    throw InputError(fmt::format("{}: a compressed SVG; unpack it first (gunzip)", file.string()));
  return parse_svg(text, file.string(), settings);
}

}  // namespace impedraw
