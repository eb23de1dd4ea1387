#include "impedraw/app/commands.h"

#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/canvas/mesh_file.h"
#include "impedraw/common/errors.h"
#include "impedraw/experiment/artwork.h"
#include "impedraw/experiment/cover.h"
#include "impedraw/experiment/experiment.h"
#include "impedraw/experiment/height_sources.h"
#include "impedraw/experiment/prepare.h"
#include "impedraw/files/data_folder.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/log/run_rows.h"
#include "impedraw/planning/cover/even_forces.h"
#include "impedraw/report/cover_picture.h"
#include "impedraw/run/results.h"
#include "impedraw/run/run_folder.h"
#include "impedraw/run/simulated_arm.h"
#include "impedraw/run/treatment.h"
#include "impedraw/terminal/clock.h"
#include "impedraw/terminal/progress.h"
#include "impedraw/terminal/say.h"

namespace impedraw {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

// Lines that keep within the arm's reach treat more evenly, but are not to promise less than this
// share of what the lines do that are cut where the reach ends.
constexpr double kOfDraft = 0.93;
// The number of times that lines are laid anew which left the reach again, elsewhere.
constexpr int kRelaid = 1;

// Both maps of a run, fed row by row.
class Judge {
 public:
  Judge(const Experiment& e, const CoverPlan& plan, const TrueCover& truth)
      : X_PW_(e.artwork.X_WP.inverse()),
        force_(e.scenario.control.normal_force),
        jet_(e.scenario.tool.kind == ToolKind::nozzle),
        by_tone_(e.scenario.cover.dose == CoverDose::by_tone),
        rigid_(e.scenario.tool.joints == 0),
        model_(e.belief.arm),
        truth_(truth.grid, *covering(e.scenario), e.scenario.control.normal_force,
               e.scenario.path.draw_speed),
        arm_(plan.grid, *covering(e.scenario), e.scenario.control.normal_force,
             e.scenario.path.draw_speed, kDoubt) {}

  // A canvas that moves is seen from its own frame, by the arm as it believes that this lies.
  void add(const LogRow& row) {
    const double dt = row.time - time_;
    time_ = row.time;
    if (!(dt > 0.0 && dt < kLongest)) return;
    const Pose X_WE{row.tip_position, row.tip_orientation.toRotationMatrix()};
    const double share = by_tone_ ? row.push / force_ : 1.0;
    const Pose seen = X_PW_ * row.canvas_pose.inverse() * X_WE;
    if (jet_) {
      if (row.stroke < 0) return;  // it is shut
      truth_.press(seen, force_, seen.R.col(0), row.time, dt);
    } else if (row.contact_force.allFinite() && row.contact_normal.allFinite())
      press(&truth_, seen, &seen_, row.contact_normal_W().dot(row.contact_force), row.time, dt,
            row.stroke >= 0, share);
    // The arm knows its own joints and its own wrench.
    if (!row.surface_normal.allFinite()) return;
    const Pose X_WE_own = model_.tip_pose(row.measured_position);
    const Pose own = X_PW_ * row.estimated_canvas_pose.inverse() * X_WE_own;
    if (jet_) return arm_.press(own, force_, own.R.col(0), row.time, dt);
    // The pressure on a rigid disc acts along its axis.
    const Eigen::Vector3d along = rigid_ ? -X_WE_own.R.col(2) : row.surface_normal;
    press(&arm_, own, &own_, along.dot(row.wrench_measured.head<3>()), row.time, dt, true, share);
  }

  const TreatmentMap& truth() const { return truth_; }
  const TreatmentMap& arm() const { return arm_; }

 private:
  static constexpr double kLongest = 0.05;  // between two rows of a log [s]
  static constexpr double kDoubt = 0.03;    // of a wrench sensor: drift and the pad's own weight

  static void press(TreatmentMap* map, const Pose& X_PE, Eigen::Vector3d* before, double force,
                    double time, double dt, bool on_line, double share) {
    const Eigen::Vector3d velocity = (X_PE.p - *before) / dt;
    *before = X_PE.p;
    if (force > 0.0 && velocity.norm() < kFastest)
      map->press(X_PE, force, velocity, time, dt, on_line, share);
  }
  static constexpr double kFastest = 10.0;  // beyond, the place before is not known [m/s]

  Pose X_PW_;
  double force_;  // asked for; of a jet, which coats evenly in time: any [N]
  bool jet_, by_tone_, rigid_;
  ArmModel model_;
  TreatmentMap truth_, arm_;
  double time_ = -1.0;
  Eigen::Vector3d seen_ = Eigen::Vector3d::Constant(1e9), own_ = seen_;  // E in P, before
};

const char* name_of_dose(const Scenario& s) {
  return s.tool.kind == ToolKind::nozzle ? "coat" : "removal";
}

std::vector<char> promised_places(const Experiment& e, const CoverPlan& plan) {
  PlaneLines lines;
  for (const PlacedStroke& stroke : e.plan.strokes) lines.push_back(stroke.p_P);
  return surely_pressed(plan.grid, lines, plan.centres.feet);
}

// The share of the most that a place is to get.
double share_at(const CoverPlan& plan, std::size_t v) {
  return plan.wish.share.empty() ? 1.0 : plan.wish.share[v];
}

struct Results {
  std::vector<char> places;         // that are promised
  TreatmentShares promised, inner;  // of these, and of those a radius inside
  Json metrics, whole;
  std::vector<MissedPatch> arm_missed;
  double unsaid = 0.0;  // [m²]
};

Results results_of(const Experiment& e, const CoverPlan& plan, const TrueCover& truth,
                   const Judge& judge) {
  const SurfaceGrid& g = truth.grid;
  const double r = plan.wish.footprint.radius;
  const std::vector<char> promised = promised_places(e, plan);
  const std::vector<char> inner = inside_by(g, promised, r);
  std::vector<char> reachable_places = truth.reachable;
  for (std::size_t v = 0; v < g.size(); ++v) reachable_places[v] |= promised[v];
  const double reachable = area_of(g, reachable_places);
  Results out;
  out.places = promised;
  out.promised = shares_of(judge.truth(), promised, plan.wish.share);
  out.inner = shares_of(judge.truth(), inner, plan.wish.share);
  const TreatmentShares known = shares_of(judge.arm(), promised);
  out.arm_missed = missed(judge.arm(), promised);
  // The maps agree on what is evenly done where their doses, over their means, do.
  double off = 0.0, of = 0.0;
  for (std::size_t v = 0; v < g.size(); ++v) {
    if (promised[v] && !judge.truth().treated(v) && judge.arm().treated(v)) out.unsaid += g.area[v];
    if (!inner[v] || !(out.inner.dose_mean > 0.0)) continue;
    const double d =
        (judge.arm().dose(v) - judge.truth().dose(v)) / (share_at(plan, v) * out.inner.dose_mean);
    off += g.area[v] * d * d;
    of += g.area[v];
  }
  const auto share = [](double part, double whole) { return whole > 0.0 ? part / whole : 0.0; };
  out.metrics["treated_share"] = share(out.promised.treated, out.promised.area);
  out.metrics["promised_share"] = share(out.promised.area, reachable);
  const std::string dose = name_of_dose(e.scenario);
  if (e.scenario.tool.kind == ToolKind::pad) {
    out.metrics["pressure_mean"] = judge.truth().pressure_mean();
    out.metrics["pressure_sd"] = judge.truth().pressure_sd();
  }
  const auto if_any = [](bool any, double value) { return any ? Json(value) : Json(); };
  out.metrics[dose + "_cv"] = if_any(out.inner.area > 0.0, out.inner.dose_cv);
  out.metrics[dose + "_cv_to_edge"] = out.promised.dose_cv;
  out.metrics[dose + "_map_error"] = if_any(of > 0.0, std::sqrt(off / of));
  out.metrics["treated_share_known"] = share(known.treated, known.area);
  out.metrics["unsaid_share"] = share(out.unsaid, out.promised.area);
  out.whole = {{"metrics", out.metrics},
               {"areas_cm2",
                {{"reachable", 1e4 * reachable},
                 {"promised", 1e4 * out.promised.area},
                 {"treated", 1e4 * out.promised.treated},
                 {"twice", 1e4 * out.promised.twice}}},
               {"spacing_mm", 1e3 * plan.wish.spacing},
               {"passes", e.plan.strokes.size()},
               {"rows", plan.lines.rows},
               {"not_covered", plan.notes}};
  out.whole["lacking"] = nlohmann::ordered_json::array();
  for (const MissedPatch& patch : out.arm_missed) {
    const Eigen::Vector3d p_W = e.artwork.X_WP * patch.middle_P;
    out.whole["lacking"].push_back(
        {{"area_cm2", 1e4 * patch.area}, {"middle_m", {p_W.x(), p_W.y(), p_W.z()}}});
  }
  return out;
}

// The coefficient of variation without the rim, if there is a place a radius inside.
std::string evenness(const Results& r) {
  const bool inside = r.inner.area > 0.0;
  return fmt::format("{:.1f} % (CV){}", 100.0 * (inside ? r.inner : r.promised).dose_cv,
                     inside ? "" : " with the rim of one radius, which is all");
}

CoverPicture picture_of(const Scenario& s, const CoverPlan& plan, const TrueCover& truth,
                        const Judge& judge, const Results& results) {
  const SurfaceGrid& g = truth.grid;
  CoverPicture picture{
      .title = s.name,
      .subtitle = fmt::format("{:.2f} % of {:.0f} cm² treated, {} even to {}",
                              100.0 * results.promised.treated / results.promised.area,
                              1e4 * results.promised.area, name_of_dose(s), evenness(results)),
      .nx = g.nx,
      .ny = g.ny,
      .step = g.step,
      .treated = std::vector<Treated>(g.size(), Treated::outside),
      .dose = std::vector<double>(g.size(), std::numeric_limits<double>::quiet_NaN()),
      .dose_is =
          std::string(s.tool.kind == ToolKind::pad ? "pressure × way" : "time under the jet") +
          (plan.wish.share.empty() ? "" : ", over the tone")};
  for (std::size_t v = 0; v < g.size(); ++v) {
    if (results.places[v])
      picture.treated[v] = !judge.truth().treated(v)     ? Treated::missed
                           : judge.truth().visits(v) > 1 ? Treated::twice
                                                         : Treated::once;
    else if (truth.reachable[v])
      picture.treated[v] = Treated::not_promised;
    if (results.places[v] && results.inner.dose_mean > 0.0)
      picture.dose[v] = judge.truth().dose(v) / (share_at(plan, v) * results.inner.dose_mean);
  }
  return picture;
}

void say_results(const Scenario& s, const Results& r, const Metrics& metrics) {
  const auto percent = [&](const std::string& name) {
    return 100.0 * r.metrics[name].get<double>();
  };
  say(stdout,
      "  treated     {:.2f} % of {:.1f} cm² promised, {:.1f} % of what a perfect planner reaches\n",
      percent("treated_share"), 1e4 * r.promised.area, percent("promised_share"));
  if (r.metrics.contains("pressure_mean"))
    say(stdout, "  pressure    {:.2f} ± {:.2f} kPa\n",
        1e-3 * r.metrics["pressure_mean"].get<double>(),
        1e-3 * r.metrics["pressure_sd"].get<double>());
  say(stdout, "  {:<11} even to {}{}\n", name_of_dose(s), evenness(r),
      r.inner.area > 0.0
          ? fmt::format(", {:.1f} % with the rim of one radius", 100.0 * r.promised.dose_cv)
          : "");
  say(stdout, "{}",
      metrics_summary(metrics, s.tool.kind == ToolKind::pad ? Trace::area : Trace::none));
  double lacking = 0.0;
  for (const MissedPatch& patch : r.arm_missed) lacking += patch.area;
  if (lacking > 0.0)
    say(stdout, "  lacking     {:.2f} cm² in {} places, by what the arm knows; in cover.json\n",
        1e4 * lacking, r.arm_missed.size());
}

// Tells of a drawing's settings that are given for `cover`, by --set or beside a region that they
// do not place, and that have no effect on it.
void note_unused(const Scenario& s, const Places& places) {
  const fs::path& region = s.cover.region;
  const auto file_of = [](const std::string& place) { return place.substr(0, place.rfind(':')); };
  const auto note = [&](const char* name, bool in_file, const char* why) {
    const std::string place = places.of(name);
    const bool beside = in_file && file_of(place) == file_of(places.of("cover.region"));
    if (place.starts_with("--set") || beside)
      say(stderr, "note: {}: {} has no effect on cover: {}\n", place, name, why);
  };
  for (const char* name : {"drawing.svg", "drawing.text", "drawing.shape"})
    note(name, false, "cover.region is what it covers");
  if (!region.empty() && !is_mesh_file(region)) return;
  for (const char* name : {"drawing.placement", "drawing.layer"})
    note(name, true,
         region.empty() ? "cover.region is not given"
                        : "cover.region is a mesh, which canvas.mesh and canvas.move place");
}

std::string text_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Throws unless the run in `folder` was begun with these settings but for what its lines completed,
// and with the same files.
void require_begun_with(Scenario s, const fs::path& folder) {
  Places places;
  const Scenario then = recorded_scenario(folder, &places);
  s.drawing.svg = then.drawing.svg;
  s.arm.start_p_WE = then.arm.start_p_WE;
  s.control.pen_axis = then.control.pen_axis;
  s.control.normal_error_deg = then.control.normal_error_deg;
  s.control.felt_normal.share = then.control.felt_normal.share;
  require_same_settings(s, folder);
  s.drawing.svg.clear();
  find_inputs(&s, folder, InputsFrom::originals);
}

}  // namespace

int cover(const DrawOptions& given, const fs::path& region, bool table) {
  const auto start = Clock::now();
  DrawOptions options = given;
  if (options.scenario.empty()) options.built_in = data_folder() / "scenarios/cover-dome.yaml";
  Places places;
  Scenario scenario = resolve(options, &places);
  if (!region.empty()) {
    scenario.cover.region = fs::absolute(region);
    places.put("cover.region", "--region " + region.string());
  }
  scenario = with_cover_defaults(scenario, places);
  note_unused(scenario, places);
  const fs::path folder = options.out.empty() ? fs::path("runs") / scenario.name : options.out;
  require_run_folder(folder);
  const bool begun = options.resume && is_own_file(folder / "run.h5");
  // A run that was killed before its first line begins anew, as with draw.
  const bool named = !options.scenario.empty() || !region.empty() || !options.assignments.empty();
  if (options.resume && !begun && !named && !fs::exists(folder))
    throw InputError(fmt::format(
        "--resume: {} contains no run to resume; name its folder with --out", folder.string()));
  if (!options.out.empty() && !begun && !options.overwrite) require_no_finished_run(folder);

  const SettingErrors errors(places);
  const Pose X_WP = drawing_frame(scenario.drawing);
  SceneCache scenes(1);
  std::optional<ProgressLine> line(std::in_place);
  line->update("looking at the canvas", 0.0);
  Scene scene = scenes.take(scenario, X_WP, errors);
  CoverPlan plan = plan_cover(scenario, scene.belief, X_WP, errors, [&](double share) {
    line->update("covering the surface", 0.1 + 0.2 * share);
  });
  const TrueCover truth = true_cover(scenario, scene, X_WP, plan);
  // The planner's own surface ends where a tip must not go: beside steps, and on rough ground.
  scene.belief.surface = perceived_height(scene.belief.perception, X_WP);
  if (scenario.tool.kind == ToolKind::pad)
    scene.belief.surface =
        with_normals_of(plan.centres.feet, plan.grid, std::move(scene.belief.surface));
  scenes.give_back(std::move(scene));
  make_folder(folder);
  const FolderLock lock(folder);
  const fs::path strokes = fs::absolute(folder / kCoverLines),
                 draft = fs::absolute(folder / "cover-draft.csv");
  const std::string begun_along = begun ? text_of(strokes) : "";
  // A resumed run keeps its lines until the same have been found again.
  const fs::path& laid_in = begun ? draft : strokes;
  std::optional<Prepared> laid;
  const auto lay = [&](const CoverPlan& along, const fs::path& file, double from) {
    if (laid) scenes.give_back(scene_of(std::move(*laid)));
    write_whole(file, cover_strokes(along, scenario));
    laid.emplace(prepare(
        drawing_of_cover(scenario, file), places, Unreachable::refuse,
        [&](const char* what, double share) { line->update(what, from + 0.2 * share); }, &scenes));
  };
  lay(plan, laid_in, 0.3);
  CoverPlan within = plan;
  bool beyond = keep_within_reach(scenario, *laid, &within);
  bool cut = keep_drawn(scenario, *laid, Barred::tried_again, &plan);
  if (beyond) {
    for (int round = 0; beyond; ++round) {
      lay(within, laid_in, 0.5);
      beyond = round < kRelaid && keep_within_reach(scenario, *laid, &within);
    }
    const bool cut_within = keep_drawn(scenario, *laid, Barred::tried_again, &within);
    if (within.promised_area >= kOfDraft * plan.promised_area) {
      plan = std::move(within);
      cut = cut_within;
    } else {
      cut = true;  // what is laid are the other lines
    }
  }
  for (int round = 0; cut; ++round) {
    lay(plan, laid_in, 0.7);
    cut = round < kRelaid && keep_drawn(scenario, *laid, Barred::lost, &plan);
  }
  fs::remove(draft);
  if (begun && has_steps(folder / "run.h5")) require_begun_with(laid->scenario, folder);
  if (begun && begun_along != cover_strokes(plan, scenario))
    throw InputError(
        fmt::format("--resume: the area in {} was begun along other lines; use the same settings",
                    folder.string()));
  if (begun) lay(plan, strokes, 0.7);
  for (const std::string& what : plan.left_out) say(stderr, "note: cover.region: {}\n", what);
  for (const std::string& note : plan.notes) say(stderr, "note: {}\n", note);
  line.reset();
  Prepared& experiment = *laid;
  print_notes(experiment);

  Judge judge(experiment, plan, truth);
  if (begun) {
    recover_log(folder / "run.h5");
    visit_rows(folder / "run.h5", [&judge](const LogRow& row) { judge.add(row); });
  }
  RunHooks hooks;
  hooks.row = [&judge](const LogRow& row) { judge.add(row); };
  Results results;
  hooks.ended = [&] {
    results = results_of(experiment, plan, truth, judge);
    write_whole(folder / kCoverFile, results.whole.dump(2) + "\n");
  };
  const Drawing drawing =
      draw_into(folder, experiment, seconds_since(start), begun, hooks, {}, &lock);
  write_cover(picture_of(scenario, plan, truth, judge, results), folder / "cover");
  say(stdout, "{}: {:.2f} s simulated in {:.2f} s\n", scenario.name, drawing.outcome.simulated,
      drawing.outcome.wall.loop);
  say(stdout, "{}", ink_lines(experiment, drawing.outcome));
  say_results(scenario, results, drawing.metrics);
  if (table) say(stdout, "{}", metrics_table(drawing.metrics));
  say(stdout, "picture  {}\nreport   {}\n",
      fs::absolute(folder / "cover.png").lexically_normal().string(),
      fs::absolute(folder / "report.html").lexically_normal().string());
  return exit_code(drawing);
}

}  // namespace impedraw
