#include "impedraw/drawing/visible.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <utility>

#include "impedraw/drawing/clip_regions.h"
#include "impedraw/drawing/colours.h"
#include "impedraw/drawing/covers.h"
#include "impedraw/drawing/dashes.h"
#include "impedraw/drawing/line_pieces.h"
#include "impedraw/drawing/polyline.h"

namespace impedraw {
namespace {

using Eigen::AlignedBox2d;
using Eigen::Vector2d;
constexpr double kHair = 3e-6;              // width of a border, relative to the drawing's diagonal
constexpr double kCrossing = 1.0 / 300;     // of the diagonal: hidden by a stroke that it crosses
constexpr double kReach = 2.5;              // of a blur, in deviations
constexpr double kSeam = 10;                // hairs beside an edge, where its colours are compared
constexpr double kSameColour = 12.0 / 255;  // change of a channel that is no line
constexpr double kHairline = 30.0 / 255;    // of a screen's hairline between areas side by side
constexpr double kUpright = 1e-4;           // direction of an edge that may lie between pixels
constexpr double kLook = 1.0 / 1000;        // of the diagonal: between places that are compared
constexpr std::size_t kMostCovering = 100'000;    // points of strokes that hide others
constexpr std::size_t kMostCompared = 2'000'000;  // points of strokes over the paints
constexpr std::size_t kMostRims = 64;             // strokes over one paint that leave it a rim
constexpr double kThinRim = 0.02;  // of a stroke's width: what is left of it is too thin to draw

using Shown = ClipRegions::Shown;

class Eye {
 public:
  Eye(std::vector<Paint>& paints, const std::vector<Clip>& clips,
      const std::vector<PaintGroup>& groups, std::vector<Dash>& dashes, const AlignedBox2d& all,
      const AlignedBox2d& ink)
      : paints_(paints),
        dashes_(dashes),
        math_(all),
        clips_(clips, math_),
        hair_(std::max(kHair * ink.diagonal().norm(), all.diagonal().norm() > 1e4 ? 2e-4 : 1e-7)),
        touch_(3 * std::sqrt(hair_ * ink.diagonal().norm())),
        crossing_(kCrossing * ink.diagonal().norm()),
        look_(kLook * ink.diagonal().norm()),
        covers_(ink),
        covering_(ink),
        veils_(hair_, crossing_),
        colours_(paints, groups, clips_, all, crossing_) {
    for (const Paint& paint : paints) {
      beneath_.push_back(beneath_.empty() ? AlignedBox2d() : beneath_.back().merged(boxes_.back()));
      boxes_.push_back(outlines_box(paint.area.outlines).merged(bounds_of(paint.strokes)));
    }
    bool any = false;
    for (std::size_t i = paints.size(); i-- > 0;) {
      if (paints[i].inked && !paints[i].area.outlines.empty()) first_area_ = i;
      if (paints[i].strokes.empty()) continue;
      const std::uint32_t colour = paints[i].strokes.front().colour;
      if (any && colour != first_colour_) first_other_ = i + 1;
      first_colour_ = colour, any = true;
    }
  }

  Hidden look() {
    for (std::size_t i = paints_.size(); i-- > 0;) look_at(i);
    for (auto& [index, edge] : veil_edges_) paints_[index].strokes.push_back(std::move(edge));
    for (std::size_t i = 0; i < paints_.size(); ++i) drop_unseen(i);
    return {std::max(0.0, hidden_),
            in_part_ || offset_ > kMostCovering || compared_ >= kMostCompared};
  }

 private:
  void look_at(std::size_t index) {
    clips_.forget();
    Paint& paint = paints_[index];
    if (paint.soft > 0) spread(paint);
    AlignedBox2d box = paint.soft > 0 ? outlines_box(paint.area.outlines) : boxes_[index];
    const Shown* clip = paint.clip < 0 ? nullptr : &clips_.of(paint.clip);
    // A part that only touches the clip's edge, as much does the page's, is whole, too.
    const Vector2d edge = Vector2d::Constant(hair_).cwiseMin(0.5 * box.sizes());
    if (clip && !box.isEmpty() &&
        holds(clip->region, AlignedBox2d(box.min() + edge, box.max() - edge)))
      clip = nullptr;
    if (clip) box = box.intersection(outlines_box(clip->region));
    std::vector<int> over;
    if (!box.isEmpty()) over = covers_.over(box, index);
    const auto hides_all = [&](int i) { return holds(covers_[i].region, box); };
    if (box.isEmpty() || std::any_of(over.begin(), over.end(), hides_all)) {
      for (const Stroke& stroke : paint.strokes) hidden_ += length(stroke.points);
      paint.strokes.clear();
      paint.area.outlines.clear();
      return;
    }
    covers_.merge(math_, over);
    cover_by(paint, index, clip, clip || !over.empty());
    const std::vector<int> strokes = compared_ < kMostCompared && !box.isEmpty()
                                         ? covering_.over(box, index)
                                         : std::vector<int>{};
    if (paint.veil) return add_veil(paint, clip, over, strokes, box);
    const bool cut = clip || !over.empty() || !strokes.empty();
    Outlines filled;  // what the clip leaves of the area
    const bool hides = paint.hides && box.intersects(beneath_[index]);
    const bool veiled = (paint.inked || (paint.hides && !paint.hides_from)) && veils_.reach(box);
    if (!paint.area.outlines.empty() && (cut || hides || veiled)) filled = math_.region(paint.area);
    const Outlines whole = filled, cover = covers_.united(math_, over, {}, box);
    if (clip && !filled.empty()) filled = math_.common(filled, clip->region);
    std::optional<Outlines> seen;
    if (cut) seen = cut_lines(paint, whole, filled, clip, over, strokes, cover, box);
    if (veiled && !filled.empty()) {
      Stroke line{{}, false, paint.area.layer, -1, true, paint.area.colour};
      for (LinePiece& piece : veils_.take(filled))
        veil_edges_.emplace_back(index, like(line, std::move(piece.points)));
    }
    if (!hides || filled.empty() || (!cover.empty() && math_.without(filled, cover).empty()))
      return;
    covers_.add({std::move(filled), {}, paint.inked, paint.hides_from, 0, std::move(seen)});
  }

  // As far as the blur reaches.
  void spread(Paint& paint) const {
    Outlines reach = math_.region(paint.area);
    for (const auto& outline : paint.area.outlines) {
      for (auto& around : math_.stroked(outline, 2 * kReach * paint.soft, true, true))
        reach.push_back(std::move(around));
    }
    paint.area.outlines = math_.united(reach);
    paint.area.even_odd = false;
  }

  // Keeps the veil's edge, where nothing hides it, for what lies beneath.
  void add_veil(const Paint& paint, const Shown* clip, const std::vector<int>& over,
                const std::vector<int>& strokes, const AlignedBox2d& box) {
    const RegionIndex hidden(covers_.united(math_, over, {}, box));
    const RegionIndex under(beneath(strokes, {}, box));
    std::vector<const RegionIndex*> indices{&hidden};
    if (clip) indices.push_back(&clip->index);
    const auto is_seen = [&](const Spot& spot) {
      return !spot.touches(hidden) && (!clip || spot.within(clip->index));
    };
    for (auto& outline : math_.region(paint.area)) {
      outline.push_back(outline.front());
      Stroke edge{std::move(outline), true};
      std::vector<Stroke> kept;
      keep(edge, uncovered(pieces_of(edge, indices, is_seen), under), kept);
      veils_.add(kept);
    }
  }

  // `whole`: the paint's area; `filled`: what the clip leaves of it; `cover`: all that lies over
  // it. Returns what something white leaves of the area, if there is any.
  std::optional<Outlines> cut_lines(Paint& paint, const Outlines& whole, const Outlines& filled,
                                    const Shown* clip, const std::vector<int>& over,
                                    const std::vector<int>& strokes, const Outlines& cover,
                                    const AlignedBox2d& box) {
    const RegionIndex hidden(cover);
    std::vector<const RegionIndex*> indices{&hidden};
    if (clip) indices.push_back(&clip->index);
    std::vector<Stroke> lines, edges;
    for (Stroke& stroke : paint.strokes)
      (stroke.edge && stroke.closed ? edges : lines).push_back(std::move(stroke));
    paint.strokes.clear();
    const auto own =
        std::find_if(lines.begin(), lines.end(), [](const auto& s) { return !s.edge; });
    Outlines others;
    if (own != lines.end()) others = beneath(strokes, own->colour, box);
    const bool has_edges = !edges.empty() || std::any_of(lines.begin(), lines.end(),
                                                         [](const auto& s) { return s.edge; });
    const RegionIndex under_all(has_edges || paint.inked ? beneath(strokes, {}, box) : Outlines{}),
        under_others(others);
    others.insert(others.end(), cover.begin(), cover.end());
    const RegionIndex hidden_middle(others);
    for (const Stroke& line : lines) {
      std::vector<LinePiece> pieces = pieces_of(line, indices, [&](const Spot& spot) {
        return (!clip || spot.touches(clip->index)) && !spot.within(hidden);
      });
      // A piece that only touches the clip, as a tangent does, is outside.
      std::erase_if(pieces, [&](const LinePiece& piece) {
        const auto within = [&](const Spot& spot) { return spot.within(clip->index); };
        return clip && piece.length > 0 && piece.length < touch_ &&
               visible_pieces(piece.points, hair_, {&clip->index}, within).empty();
      });
      pieces = uncovered(std::move(pieces), line.edge ? under_all : under_others);
      hidden_ += length(line.points) - keep(line, std::move(pieces), paint.strokes);
      const bool many = others.size() > cover.size() + kMostRims;
      draw_rim(line, clip, many ? hidden : hidden_middle, many ? cover : others, paint.strokes);
    }
    if (!paint.inked || whole.empty()) return {};

    const Outlines white = covers_.united(math_, over, false, box),
                   inked = covers_.united(math_, over, true, box);
    Outlines seen = white.empty() ? filled : math_.without(filled, white);
    std::erase_if(seen, [&](const auto& outline) {  // slivers
      return enclosed_area({outline}) < hair_ * length(outline);
    });
    std::optional<Outlines> shown;
    if (!white.empty()) shown = seen;
    // The area gets a new edge where a clip or something white cuts it.
    const RegionIndex core(whole), edged(inked);
    const auto is_new = [&](const Spot& spot) { return spot.within(core); };
    const auto is_seen = [&](const Spot& spot) { return !spot.touches(edged); };
    std::vector<Stroke> outlines;
    bool is_cut = enclosed_area(seen) < 0.999 * enclosed_area(whole);
    for (const auto& outline : seen) {
      outlines.push_back({outline, true, paint.area.layer, -1, true, paint.area.colour});
      outlines.back().points.push_back(outline.front());
      is_cut = is_cut || !pieces_of(outlines.back(), {&core}, is_new).empty();
    }
    for (const Stroke& edge : edges) hidden_ += length(edge.points);
    const bool only_new = !lines.empty() || paint.soft > 0;
    for (const Stroke& edge : !is_cut ? edges : only_new ? std::vector<Stroke>{} : outlines) {
      std::vector<Stroke> kept;
      keep(edge, uncovered(pieces_of(edge, {&edged}, is_seen), under_all), kept);
      for (Stroke& stroke : kept) {
        hidden_ -= length(stroke.points);
        for (const LinePiece& piece : pieces_of(stroke, {&core}, is_new)) hidden_ += piece.length;
        paint.strokes.push_back(std::move(stroke));
      }
    }
    // Beside a stroke of its own, and of what is blurred, only what is new needs an edge.
    if (is_cut && only_new) {
      for (const Stroke& edge : outlines) {
        const auto both = [&](const Spot& spot) { return is_seen(spot) && is_new(spot); };
        keep(edge, uncovered(pieces_of(edge, {&edged, &core}, both), under_all), paint.strokes);
      }
    }
    if (is_cut || !inked.empty()) {
      paint.area.outlines = inked.empty() ? std::move(seen) : math_.without(seen, inked);
      paint.area.even_odd = false;
    }
    return shown;
  }

  // The strokes over a paint that are not of the colour, as far as they reach into the box.
  Outlines beneath(const std::vector<int>& strokes, std::optional<std::uint32_t> colour,
                   const AlignedBox2d& box) {
    Outlines all;
    for (const int i : strokes) {
      if (colour && covering_[i].colour == *colour) continue;
      for (const auto& outline : covering_[i].region) {
        if (!outlines_box({outline}).intersects(box)) continue;
        all.push_back(outline);
        compared_ += outline.size();
      }
    }
    return all;
  }

  // The pieces that strokes leave. One that merely crosses a stroke stays.
  std::vector<LinePiece> uncovered(std::vector<LinePiece> pieces,
                                   const RegionIndex& strokes) const {
    if (strokes.empty()) return pieces;
    std::vector<LinePiece> left;
    for (LinePiece& piece : pieces) {
      const auto is_hidden = [&](const Spot& spot) { return spot.within(strokes); };
      std::vector<LinePiece> hidden = pieces_of({piece.points}, {&strokes}, is_hidden);
      std::erase_if(hidden, [&](const LinePiece& part) { return part.length < crossing_; });
      if (hidden.empty()) {
        left.push_back(std::move(piece));
        continue;
      }
      double from = 0;
      hidden.push_back({{}, piece.length, 0});
      for (const LinePiece& part : hidden) {
        if (part.start > from)
          left.push_back(
              {line_part(piece.points, from, part.start), piece.start + from, part.start - from});
        from = part.start + part.length;
      }
    }
    return left;
  }

  // The area under the paint's strokes hides what lies before, if it is of other colours, and edges
  // of the paint's own.
  void cover_by(const Paint& paint, std::size_t index, const Shown* clip, bool is_cut) {
    if (paint.covers_from > index || compared_ >= kMostCompared || paint.strokes.empty()) return;
    AlignedBox2d reach = boxes_[index];
    for (const Stroke& stroke : paint.strokes) {
      is_cut = is_cut || stroke.edge;
      const Vector2d beside = Vector2d::Constant(kMostReach * stroke.width);
      reach.extend(AlignedBox2d(boxes_[index].min() - beside, boxes_[index].max() + beside));
    }
    is_cut = is_cut || reach.intersects(beneath_[index]);
    for (const Stroke& stroke : paint.strokes) {
      if (stroke.edge || stroke.dash >= 0 || !(stroke.width > 30 * hair_)) continue;
      const bool hides = is_cut && !(first_area_ > index && first_other_ >= index &&
                                     stroke.colour == first_colour_);
      if (!hides) continue;
      offset_ += stroke.points.size();
      if (offset_ > kMostCovering) return;
      Outlines region = math_.stroked(stroke.points, stroke.width, stroke.closed, paint.round);
      if (clip) region = math_.common(region, clip->region);
      if (region.empty()) continue;
      covering_.add({std::move(region), {}, true, paint.covers_from, stroke.colour});
    }
  }

  // Leaves out the parts of edges and strokes beside which the colours are the same.
  void drop_unseen(std::size_t index) {
    clips_.forget();
    std::vector<Stroke> kept;
    for (Stroke& stroke : paints_[index].strokes) {
      if (!stroke.edge && !(stroke.width > 0)) {
        kept.push_back(std::move(stroke));
        continue;
      }
      const int own = stroke.edge ? -1 : static_cast<int>(index);
      const auto at = [&](const Vector2d& p, bool with_own) {
        return colours_.at(p, own, stroke.colour, with_own);
      };
      const double beside = kSeam * hair_ + (stroke.edge ? 0 : stroke.width / 2);
      const auto is_seen = [&](const Vector2d& p, const Vector2d& along) {
        const Vector2d side = beside * Vector2d(-along.y(), along.x());
        const Vector2d near = (kSeam * hair_ / beside) * side;
        auto ink_a = stroke.edge ? std::nullopt : at(p + near, true);
        if (ink_a && colours_.is_unlike_all(*ink_a, stroke.colour, kSameColour)) return true;
        const auto a = at(p + side, false), b = at(p - side, false);
        if (stroke.edge) ink_a = b;
        const auto ink_b = stroke.edge ? a : at(p - near, true);
        if (!a || !b || !ink_a || !ink_b) return in_part_ = true;
        const auto differ = [](const Tint& one, const Tint& other, double least) {
          return ((one - other).abs() >= least).any();
        };
        if (differ(*ink_a, *a, kSameColour) || differ(*ink_b, *b, kSameColour)) return true;
        if (!stroke.edge || along.cwiseAbs().minCoeff() < kUpright) return false;
        const auto between = colours_.at(p, -1, 0, false, 2.5 * side);
        return !between || differ(*between, *a, kHairline);
      };
      hidden_ +=
          length(stroke.points) - keep(stroke, pieces_where(stroke.points, look_, is_seen), kept);
    }
    paints_[index].strokes = std::move(kept);
  }

  // Beside a hidden line, draws the middle of what still shows, as wide as it is painted.
  void draw_rim(const Stroke& line, const Shown* clip, const RegionIndex& hidden,
                const Outlines& cover, std::vector<Stroke>& kept) {
    if (line.dash >= 0 || !(line.width > 30 * hair_)) return;
    const auto is_hidden = [&](const Spot& spot) { return spot.within(hidden); };
    for (const LinePiece& piece : pieces_of(line, {&hidden}, is_hidden)) {
      if (piece.length < std::max(line.width / 10, crossing_)) continue;
      const bool whole = line.closed && piece.length > (1 - 1e-9) * length(line.points);
      Outlines rest = math_.without(math_.stroked(piece.points, line.width, whole), cover);
      if (clip) rest = math_.common(rest, clip->region);
      const double rim = enclosed_area(rest);
      if (rim < kThinRim * line.width * piece.length) continue;
      // The rim's own width is its area over the length of its outer side.
      double wide = 0;
      for (const Stroke& side : sides_of(piece, line, line.width, whole, clip, hidden))
        wide += length(side.points);
      if (!(wide > 0)) continue;
      for (Stroke& side : sides_of(piece, line, line.width - std::min(rim / wide, line.width / 2),
                                   whole, clip, hidden))
        kept.push_back(std::move(side));
    }
  }

  // The lines that run beside the piece, on both sides, half of `width` away, where they show.
  std::vector<Stroke> sides_of(const LinePiece& piece, const Stroke& line, double width, bool whole,
                               const Shown* clip, const RegionIndex& hidden) {
    std::vector<const RegionIndex*> indices{&hidden};
    if (clip) indices.push_back(&clip->index);
    std::vector<Stroke> sides;
    for (auto& ring : math_.stroked(piece.points, width, whole)) {
      const std::size_t n = ring.size();
      const auto ends = [&](std::size_t i) {
        return !whole && is_stroke_end(ring[i], ring[(i + 1) % n], piece.points, width);
      };
      std::size_t first = 0;
      while (first < n && !ends(first)) ++first;
      if (first < n)
        std::rotate(ring.begin(), ring.begin() + static_cast<long>((first + 1) % n), ring.end());
      std::vector<std::vector<Vector2d>> parts{{ring[0]}};
      for (std::size_t i = 0; i < n; ++i) {
        if (ends(i)) parts.push_back({});
        parts.back().push_back(ring[(i + 1) % n]);
      }
      for (auto& points : parts) {
        if (points.size() < 2) continue;
        Stroke side = like(line, std::move(points), first == n);
        const auto shows = [&](const Spot& spot) {
          return !spot.touches(hidden) && (!clip || spot.within(clip->index));
        };
        keep(side, pieces_of(side, indices, shows), sides);
      }
    }
    return sides;
  }

  std::vector<LinePiece> pieces_of(const Stroke& stroke,
                                   const std::vector<const RegionIndex*>& indices,
                                   const std::function<bool(const Spot&)>& visible) const {
    return visible_pieces(stroke.points, hair_, indices, visible);
  }

  // Puts the pieces as strokes; returns their length. Hairs are neither left out nor left.
  double keep(const Stroke& stroke, std::vector<LinePiece> pieces, std::vector<Stroke>& kept) {
    const double whole = length(stroke.points), dust = 30 * hair_;
    if (stroke.points.size() == 1) {
      if (!pieces.empty()) kept.push_back(stroke);
      return 0;
    }
    std::vector<LinePiece> longer;
    for (LinePiece& piece : pieces) {
      const bool goes_on =
          !longer.empty() && piece.start - (longer.back().start + longer.back().length) < dust;
      if (!goes_on) {
        longer.push_back(std::move(piece));
        continue;
      }
      longer.back().length = piece.start + piece.length - longer.back().start;
      longer.back().points.insert(longer.back().points.end(), piece.points.begin(),
                                  piece.points.end());
    }
    std::erase_if(longer, [&](const LinePiece& piece) { return piece.length < dust; });
    if (longer.size() == 1 && longer[0].length > whole - dust) {
      kept.push_back(stroke);
      return whole;
    }
    const bool over_the_start = stroke.closed && stroke.dash < 0 && longer.size() > 1 &&
                                longer.front().start < dust &&
                                longer.back().start + longer.back().length > whole - dust;
    if (over_the_start) {
      longer.back().points.insert(longer.back().points.end(), longer.front().points.begin(),
                                  longer.front().points.end());
      longer.back().length += longer.front().length;
      longer.erase(longer.begin());
    }
    double sum = 0;
    for (LinePiece& piece : longer) {
      sum += piece.length;
      piece.points.erase(std::unique(piece.points.begin(), piece.points.end()), piece.points.end());
      kept.push_back(like(stroke, std::move(piece.points)));
      if (stroke.dash >= 0 && piece.start > 0) {
        kept.back().dash = static_cast<int>(dashes_.size());
        dashes_.push_back(dash_from(dashes_[stroke.dash], stroke.points, piece.start));
      }
    }
    return sum;
  }

  std::vector<Paint>& paints_;
  std::vector<Dash>& dashes_;
  RegionMath math_;
  ClipRegions clips_;
  double hair_;      // half the width of a border [mm]
  double touch_;     // longest part of a tangent to an arc that lies in the border [mm]
  double crossing_;  // longest part beneath a stroke that merely crosses it [mm]
  double look_;      // between places that are compared [mm]
  Covers covers_;
  Covers covering_;  // by strokes
  Veils veils_;
  Colours colours_;  // of what was painted, before anything is cut
  std::vector<std::pair<std::size_t, Stroke>> veil_edges_;  // and the paint that each lies on
  std::size_t offset_ = 0, compared_ = 0;                   // points of strokes
  std::size_t first_area_ = -1, first_other_ = -1;  // paints with ink, and with a second colour
  std::uint32_t first_colour_ = 0;
  std::vector<AlignedBox2d> boxes_, beneath_;  // of each paint, and of all before it
  bool in_part_ = false;
  mutable double hidden_ = 0;
};

}  // namespace

Hidden keep_visible(std::vector<Paint>& paints, const std::vector<Clip>& clips,
                    std::vector<Dash>& dashes, const std::vector<PaintGroup>& groups) {
  AlignedBox2d ink, all;
  for (const Paint& paint : paints) {
    all.extend(outlines_box(paint.area.outlines));
    ink.extend(bounds_of(paint.strokes));
  }
  all.extend(ink);
  for (const Clip& clip : clips) {
    for (const ClipShape& shape : clip.shapes) all.extend(outlines_box(shape.area.outlines));
  }
  return ink.isEmpty() ? Hidden() : Eye(paints, clips, groups, dashes, all, ink).look();
}

}  // namespace impedraw
