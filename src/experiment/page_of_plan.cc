#include "impedraw/experiment/page_of_plan.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include <fmt/format.h>

#include "impedraw/common/rotations.h"
#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/plan_summary.h"
#include "impedraw/planning/preflight/posture_check.h"
#include "impedraw/planning/stroke_ruler.h"

namespace impedraw {
namespace {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();
constexpr double kPerRadian = 180.0 / std::numbers::pi;
constexpr double kRowStep = 0.02;  // [s]
constexpr double kMostRows = 6000.0;
constexpr double kInkSpacing = 0.6e-3;      // [m]
constexpr std::size_t kMostPostures = 300;  // of findings

double finite_or_none(double x) { return std::isfinite(x) ? x : kNoValue; }

void add_maps(const PlannedDrawing& e, PlanPage* page) {
  const Pose X_PW = e.artwork.X_WP.inverse();
  const auto on_surface = [surface = e.surface(), X_PW](const Eigen::Vector3d& p_W) {
    const Eigen::Vector3d p_P = X_PW * p_W;
    return surface(p_P.x(), p_P.y());
  };
  page->maps.push_back({"slope", "slope against the drawing plane", "deg", 0.05,
                        [on_surface](const Eigen::Vector3d& p_W) {
                          const auto sample = on_surface(p_W);
                          return sample ? kPerRadian *
                                              angle_between(sample->n_P, Eigen::Vector3d::UnitZ())
                                        : kNoValue;
                        }});
  if (e.belief.perception)
    page->maps.push_back({"normal_error", "expected error of the seen normal", "deg", 0.01,
                          [seen = e.belief.perception](const Eigen::Vector3d& p_W) {
                            return kPerRadian * finite_or_none(seen->roughness(p_W).slope);
                          }});
  page->maps.push_back({"projected", "distortion of lengths, projected", "%", 0.05,
                        [on_surface](const Eigen::Vector3d& p_W) {
                          const auto sample = on_surface(p_W);
                          return sample ? 100.0 * stretch_of_projection(*sample).length_error()
                                        : kNoValue;
                        }});
  if (e.plan.wrap)
    page->maps.push_back({"wrapped", "distortion of lengths, wrapped", "%", 0.05,
                          [on_surface, chart = &e.plan.wrap->chart()](const Eigen::Vector3d& p_W) {
                            const auto sample = on_surface(p_W);
                            return sample && chart->to_flat(sample->p_P.head<2>())
                                       ? 100.0 * stretch_of_wrap(*sample, *chart).length_error()
                                       : kNoValue;
                          }});
}

// The rows of the path, and its strokes.
class PathRows {
 public:
  PathRows(const PlannedDrawing& e, PostureCheck& check, PlanPage* page)
      : e_(e), check_(check), page_(*page) {
    page_.mode_names = {"travel", "approach", "draw", "lift", "done"};
    const auto add = [this](const char* name, const char* label, const char* unit, double quantum) {
      page_.series.push_back({name, label, unit, quantum, {}});
      return page_.series.size() - 1;
    };
    speed_ = add("speed", "speed of the tip", "mm/s", 0.01);
    joint_ = add("joint_margin", "distance to the nearest joint limit", "rad", 1e-3);
    torque_ = add("torque", "largest joint torque at rest", "% of its limit", 0.01);
    mass_ = add("effective_mass", "the tip's greatest effective mass", "kg", 0.01);
    gap_ = add("clearance", "arm to canvas or table, at most 30 mm", "mm", 0.05);
    rough_ = add("normal_error", "expected error of the seen normal", "deg", 1e-2);
    turn_ = page_.series.size();
    for (const std::string& name : page_.joint_names)
      add(("velocity_" + std::to_string(page_.series.size() - turn_)).c_str(), name.c_str(),
          "rad/s", 2e-4);
    for (const std::size_t of : {speed_, joint_, torque_, mass_, gap_, rough_}) {
      PageSeries colour = page_.series[of];
      if (of == rough_ && !e_.belief.perception) continue;
      colours_.push_back(of);
      page_.colours.push_back(std::move(colour));
    }
  }

  void still() {
    const Pose X_WE = ArmModel(e_.belief.arm).tip_pose(e_.belief.start_q);
    add_row(0.0, e_.belief.start_q, X_WE.p, X_WE.R.col(2), -X_WE.R.col(2), Phase::done, -1, 0.0,
            nullptr);
  }

  void walk(const std::function<void(double)>& progress) {
    const TipPath& path = e_.plan.path;
    const double step = std::max(kRowStep, path.duration() / kMostRows);
    const auto rows = static_cast<std::size_t>(std::ceil(path.duration() / step));
    std::optional<Posture> last;
    Eigen::Vector3d before = Eigen::Vector3d::Zero();
    for (std::size_t i = 0; i <= rows; ++i) {
      const double t = std::min(path.duration(), static_cast<double>(i) * step);
      const PathSample sample = path.at(t);
      const TipReference& at = sample.reference;
      const PenPlacement pen{at.p_WD, -at.n_WD};
      check_.asked.torque = sample.phase == Phase::draw;
      Posture posture = last ? check_.follow(pen, *last, (at.p_WD - before).norm())
                             : check_.enter(pen, e_.belief.start_q);
      if (last && last->reached && !posture.reached) {
        Posture anew = check_.enter(pen, e_.belief.start_q);
        if (anew.reached) posture = std::move(anew);
      }
      add_row(t, posture.q, at.p_WD, pen.z_WE, at.n_WD, sample.phase, sample.stroke, at.v_WD.norm(),
              &posture.margins);
      for (double u = t; u < std::min(t + step, path.duration()) - 1e-9;
           u += std::min(step, kRowStep))
        add_ink(u);
      last = std::move(posture);
      before = at.p_WD;
      if (progress && i % 64 == 0) progress(static_cast<double>(i) / static_cast<double>(rows + 1));
    }
    for (const StrokeTimes& s : path.strokes())
      page_.spans.push_back({static_cast<double>(s.number), s.start, s.end});
  }

 private:
  void add_row(double t, const JointVector& q, const Eigen::Vector3d& tip,
               const Eigen::Vector3d& axis, const Eigen::Vector3d& normal, Phase phase, int stroke,
               double speed, const PreflightMargins* margins) {
    for (std::size_t j = 0; j < page_.joint_names.size(); ++j) {
      const auto k = static_cast<Eigen::Index>(j);
      const double dt = page_.time.empty() ? 0.0 : t - page_.time.back();
      page_.series[turn_ + j].values.push_back(dt > 0.0 ? (q[k] - page_.q.back()[k]) / dt : 0.0);
    }
    page_.time.push_back(t);
    page_.q.emplace_back(q);
    page_.tip_W.push_back(tip);
    page_.pen_axis_W.push_back(axis);
    page_.normal_W.push_back(normal);
    page_.phase.push_back(static_cast<double>(phase));
    page_.stroke.push_back(stroke);
    const auto put = [this](std::size_t series, double value) {
      page_.series[series].values.push_back(finite_or_none(value));
    };
    const bool down = phase == Phase::draw;
    put(speed_, 1e3 * speed);
    put(joint_, margins ? margins->joint : kNoValue);
    put(torque_, margins && down ? 100.0 * margins->torque_share : kNoValue);
    put(mass_, margins ? margins->effective_mass : kNoValue);
    put(gap_, margins ? 1e3 * margins->clearance : kNoValue);
    put(rough_, e_.belief.perception && down
                    ? kPerRadian * e_.belief.perception->roughness(tip).slope
                    : kNoValue);
  }

  void add_ink(double t) {
    const PathSample sample = e_.plan.path.at(t);
    if (sample.stroke < 0) {
      stroke_ = -1;
      return;
    }
    const Eigen::Vector3d& p = sample.reference.p_WD;
    if (sample.stroke != stroke_) {
      stroke_ = sample.stroke;
      page_.ink_begins.push_back(static_cast<double>(page_.ink_W.size()));
      page_.ink_strokes.push_back(stroke_);
    } else if ((p - page_.ink_W.back()).norm() < kInkSpacing) {
      return;
    }
    page_.ink_W.push_back(p);
    page_.ink_time.push_back(t);
    for (std::size_t c = 0; c < colours_.size(); ++c)
      page_.colours[c].values.push_back(page_.series[colours_[c]].values.back());
  }

  const PlannedDrawing& e_;
  PostureCheck& check_;
  PlanPage& page_;
  std::size_t speed_ = 0, joint_ = 0, torque_ = 0, mass_ = 0, gap_ = 0, rough_ = 0, turn_ = 0;
  std::vector<std::size_t> colours_;  // series of each colour
  int stroke_ = -1;
};

void add_findings(const PlannedDrawing& e, const PlanPicture& picture, PostureCheck& check,
                  PlanPage* page) {
  const Pose &X_WP = e.artwork.X_WP, X_PW = X_WP.inverse();
  const SurfaceHeight& surface = e.surface();
  const bool vertical = !e.belief.perception;
  check.asked = {};
  std::size_t line = e.plan.strokes.size();  // the picture's lines of findings follow
  for (const Finding& f : e.plan.preflight.findings) {
    PageFinding found{f.part.stroke,
                      1e3 * f.part.from,
                      1e3 * f.part.to,
                      name_of(f.problem),
                      f.text,
                      f.p_W,
                      {},
                      {}};
    if (line < picture.lines.size())
      for (const Eigen::Vector3d& p_P : picture.lines[line++].points)
        found.line_W.push_back(X_WP * p_P);
    if (page->findings.size() < kMostPostures) {
      const Eigen::Vector3d p_P = X_PW * f.p_W;
      const auto sample = surface(p_P.x(), p_P.y());
      const Eigen::Vector3d n_W =
          X_WP.R * (sample && !vertical ? sample->n_P : Eigen::Vector3d::UnitZ());
      found.q = check.enter({f.p_W, -n_W}, e.belief.start_q).q;
    }
    page->findings.push_back(std::move(found));
  }
}

}  // namespace

PlanPage page_of_plan(const PlannedDrawing& e, const PlanPicture& picture,
                      const std::function<void(double)>& progress) {
  PlanPage page;
  page.title = e.scenario.name + (is_rehearsal(e.scenario) ? " (rehearsal)" : "");
  const ArmLimits& limits = e.belief.arm.limits();
  page.joint_names = e.belief.arm.joint_names();
  page.joint_lower = limits.lower;
  page.joint_upper = limits.upper;
  page.joint_speed_limit = limits.speed;
  page.torque_limit = limits.torque;
  for (const Eigen::Vector3d& p_P : picture.canvas_vertices)
    page.canvas_vertices.push_back(e.artwork.X_WP * p_P);
  page.canvas_triangles = picture.canvas_triangles;
  if (e.belief.perception) {
    page.cloud_points = e.belief.perception->cloud().points;
    page.cloud_colour = packed_colours(e.belief.perception->cloud());
  }
  add_maps(e, &page);
  const Canvas* obstacle = e.belief.height_unknown() ? nullptr : e.belief.obstacle.get();
  PostureCheck check(e.belief.arm, obstacle, e.belief.start_q,
                     preflight_settings(e.scenario, e.artwork.X_WP, e.belief.perception != nullptr,
                                        e.plan.rest_q));
  check.asked.pen = false;  // the tip touches the surface
  PathRows rows(e, check, &page);
  if (e.plan.path.duration() > 0.0)
    rows.walk(progress);
  else
    rows.still();
  add_findings(e, picture, check, &page);
  return page;
}

namespace {

// "off canvas", for a legend.
std::string words_of(Problem problem) {
  std::string words = name_of(problem);
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

// Each part of a stroke where it lies on the surface, in P.
PlanLine plan_line(const PlacedStroke& stroke, const SurfaceHeight& surface, double z,
                   const std::string& problem) {
  PlanLine line{{}, problem};
  SurfaceHeight::Sample found;
  const auto add = [&](const Eigen::Vector2d& p) {
    const auto sample = surface(p.x(), p.y(), found);
    line.points.push_back(sample ? sample->p_P : Eigen::Vector3d(p.x(), p.y(), z));
  };
  const std::vector<Eigen::Vector2d>& corners = stroke.p_P;
  add(corners.front());
  Eigen::Vector2d last = corners.front();
  for (std::size_t k = 1; k < corners.size(); ++k) {
    const Eigen::Vector2d way = corners[k] - last;
    if (way.norm() < kPictureDetail && k + 1 < corners.size()) continue;
    const int pieces = std::max(1, static_cast<int>(std::ceil(way.norm() / kPictureSpacing)));
    for (int i = 1; i <= pieces; ++i) add(last + way * i / pieces);
    last = corners[k];
  }
  return line;
}

// The surface as the plan knows it: with cameras, that of the cloud, on a grid.
void add_surface(const PlannedDrawing& e, PlanPicture* picture) {
  const Pose X_PW = e.artwork.X_WP.inverse();
  if (!e.belief.perception) {
    if (e.belief.height_unknown()) return;
    for (const Eigen::Vector3d& v_W : e.belief.obstacle->mesh().vertices)
      picture->canvas_vertices.push_back(X_PW * v_W);
    picture->canvas_triangles = e.belief.obstacle->mesh().triangles;
    return;
  }
  TriangleMesh grid = surface_grid(e.surface(), e.belief.perception->cloud(), X_PW);
  picture->canvas_vertices = std::move(grid.vertices);
  picture->canvas_triangles = std::move(grid.triangles);
}

}  // namespace

std::vector<PlanLine> lines_of_findings(const PlannedDrawing& e, const SurfaceHeight& surface) {
  const Pose X_PW = e.artwork.X_WP.inverse();
  std::vector<PlanLine> lines;
  std::optional<StrokeRuler> ruler;
  for (const Finding& f : e.plan.preflight.findings) {
    const PlacedStroke& whole = e.artwork.strokes[static_cast<std::size_t>(f.part.stroke)];
    if (!ruler || &ruler->stroke() != &whole) ruler.emplace(whole);
    PlacedStroke part = ruler->part(f.part.from, f.part.to);
    if (e.plan.wrap)
      if (auto laid = e.plan.wrap->wrap({part}).strokes; !laid.empty()) part = std::move(laid[0]);
    lines.push_back(plan_line(part, surface, (X_PW * f.p_W).z(), words_of(f.problem)));
  }
  return lines;
}

PlanPicture picture_of_plan(const PlannedDrawing& e, const SurfaceHeight& surface) {
  PlanPicture picture;
  picture.title = e.scenario.name;
  picture.subtitle =
      fmt::format("{} strokes, {:.2f} m; {}", e.plan.source.size(), e.plan.path.pen_down_length(),
                  e.plan.preflight.findings.empty()
                      ? "all can be drawn"
                      : fmt::format("{:.0f} mm cannot be drawn", 1e3 * length_not_drawable(e)));
  add_surface(e, &picture);
  for (std::size_t i = 0; i < e.plan.strokes.size(); ++i) {
    picture.lines.push_back(plan_line(e.plan.strokes[i], surface, 0.0, ""));
    if (e.plan.pens) picture.lines.back().pen = e.plan.pens->number_of(static_cast<int>(i));
  }
  if (e.plan.pens && e.plan.pens->pens.size() > 1) {
    const std::vector<PenSum> sums = sums_of(*e.plan.pens, e.plan.strokes, e.plan.path);
    for (std::size_t k = 0; k < sums.size(); ++k) {
      const DrawnPen& pen = e.plan.pens->pens[k];
      picture.pens.push_back({pen_text(pen, sums[k]), pen.colour.value_or(0), pen.line.width});
    }
  }
  for (PlanLine& line : lines_of_findings(e, surface)) picture.lines.push_back(std::move(line));
  // The map of roughness: a dot for each point of the cloud.
  if (e.belief.perception) {
    const Pose X_PW = e.artwork.X_WP.inverse();
    PlanLine dot{{Eigen::Vector3d::Zero()}, "rougher than the cameras resolve"};
    for (const Eigen::Vector3d& p_W : e.belief.perception->cloud().points) {
      if (!is_unresolved(e.belief.perception->roughness(p_W))) continue;
      dot.points.front() = X_PW * p_W;
      picture.lines.push_back(dot);
    }
  }
  return picture;
}

namespace {

PreviewLine line_of(const Stroke& stroke, const Placement& placement, double width) {
  PreviewLine line;
  for (const Eigen::Vector2d& p : stroke.points)
    line.points.push_back(placement.scale() * (p - placement.origin_mm));
  line.width.assign(line.points.size(), width);
  return line;
}

// The width that the pen draws at each point [mm].
std::vector<double> drawn_widths(const PlacedStroke& stroke, const PenSettings& pen, double force) {
  std::vector<double> widths(stroke.page.size(), pen.width_at(force));
  for (std::size_t i = 0; i < stroke.force.size(); ++i) widths[i] = pen.width_at(stroke.force[i]);
  return widths;
}

}  // namespace

std::vector<PenSum> sums_of(const DrawnPens& pens, const std::vector<PlacedStroke>& strokes,
                            const TipPath& path) {
  std::vector<PenSum> sums(pens.pens.size());
  double before = 0.0;
  for (const StrokeTimes& times : path.strokes()) {
    PenSum& sum = sums[static_cast<std::size_t>(pens.number_of(times.number))];
    ++sum.strokes;
    sum.length += 1e3 * plane_length(strokes[static_cast<std::size_t>(times.number)]);
    sum.time += times.end - std::exchange(before, times.end);
  }
  return sums;
}

std::string pen_text(const DrawnPen& pen, const PenSum& sum) {
  return fmt::format("{}: {} stroke{}, {:.0f} mm, {:.0f} s", pen.name.empty() ? "pen" : pen.name,
                     sum.strokes, sum.strokes == 1 ? "" : "s", sum.length, sum.time);
}

std::string ink_text(const DrawnPen& pen, const PenSum& sum) {
  return fmt::format(
      "{}; {}, {:.3g} mm wide at {:.3g} N{}", pen_text(pen, sum),
      colour_name(pen.colour.value_or(0)), pen.line.width, pen.line.nominal_force,
      pen.line.presses() ? fmt::format(", {:+.3g} mm/N", pen.line.width_per_newton) : "");
}

PreviewPicture preview_of(const Scenario& s, const SettingErrors& setting_errors,
                          const PlacedArtwork& artwork, const std::vector<DrawnPen>& pens,
                          const std::vector<PenSum>& sums) {
  const Artwork& drawn = artwork.shape.drawn;
  PreviewPicture picture;
  picture.title = s.name;
  Eigen::AlignedBox2d box;
  for (std::size_t i = 0; i < drawn.strokes.size(); ++i) {
    const Stroke& stroke = drawn.strokes[i];
    PreviewLine& line = picture.lines.emplace_back(line_of(stroke, artwork.placement, 1.0));
    line.pen = pens.size() > 1 ? stroke.layer : 0;
    line.width = drawn_widths(artwork.strokes[i], pens[static_cast<std::size_t>(line.pen)].line,
                              s.control.normal_force);
    for (const Eigen::Vector2d& p : line.points) box.extend(p);
  }
  if (drawn.hidden_mm > 0.0) {
    DrawingSettings all = s.drawing;
    all.visible = Visible::all;
    all.hatch = {};
    for (const Stroke& stroke : make_artwork(all, setting_errors).drawn.strokes) {
      const auto pen = std::min(static_cast<std::size_t>(stroke.layer), pens.size() - 1);
      picture.whole.push_back(line_of(stroke, artwork.placement, pens[pen].line.width));
    }
  }
  for (std::size_t k = 0; k < pens.size(); ++k)
    picture.pens.push_back(
        {pen_text(pens[k], sums[k]), pens[k].colour.value_or(0), pens[k].line.width});
  if (box.isEmpty()) box.extend(Eigen::Vector2d::Zero());
  picture.subtitle = fmt::format("{:.1f} × {:.1f} mm as drawn", box.sizes().x(), box.sizes().y());
  return picture;
}

}  // namespace impedraw
