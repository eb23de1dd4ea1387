#include "impedraw/run/results.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <future>

#include <nlohmann/json.hpp>

#include "impedraw/experiment/page_context.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/report/report.h"
#include "impedraw/terminal/say.h"

namespace impedraw {
namespace {

// The lines of what the plan left out, as strokes.json has them; none where it cannot be read.
std::vector<std::vector<Eigen::Vector3d>> left_out_in(const std::filesystem::path& file) {
  std::vector<std::vector<Eigen::Vector3d>> lines;
  std::ifstream in(file);
  const auto json = nlohmann::json::parse(in, nullptr, false);
  try {
    for (const auto& part : json.at("not_drawable")) {
      const auto flat = part.at("line_m").get<std::vector<double>>();
      auto& line = lines.emplace_back();
      for (std::size_t i = 0; i + 2 < flat.size(); i += 3)
        line.emplace_back(flat[i], flat[i + 1], flat[i + 2]);
    }
  } catch (const nlohmann::json::exception&) {
  }
  return lines;
}

// Where an area was covered or a groove cut, the metrics of its file come first.
void write_metrics(const std::filesystem::path& folder, const Metrics& metrics) {
  nlohmann::ordered_json all = nlohmann::ordered_json::object();
  for (const char* const file : {kCoverFile, kGrooveFile}) {
    std::ifstream in(folder / file);
    const auto judged = nlohmann::ordered_json::parse(in, nullptr, false);
    if (judged.is_object() && judged.contains("metrics")) all.update(judged["metrics"]);
  }
  all.update(metrics_json(metrics));
  write_whole(folder / "metrics.json", all.dump(2) + "\n");
}

}  // namespace

Metrics write_results(const std::filesystem::path& folder, const Scenario& scenario,
                      const PlacedArtwork& artwork, const std::function<void()>& check,
                      const Canvas* canvas) {
  const auto step = [&check] {
    if (check) check();
  };
  const RunData run = read_run(folder / "run.h5");
  if (run.cut_short)
    say(stderr, "note: {}: is cut short; results are of the run up to {:.2f} s\n",
        (folder / "run.h5").string(), run.time.empty() ? 0.0 : run.time.back());
  step();
  const InkMatch drawn = match_ink(run);
  step();
  const auto to_page = [&placement = artwork.placement, X_PW = artwork.X_WP.inverse()](
                           const Eigen::Vector3d& p_W) -> Eigen::Vector2d {
    return placement.to_page((X_PW * p_W).head<2>());
  };
  // On the second core while metrics and page are made. Does not read the log: HDF5 is not for two
  // threads.
  std::future<void> pictures = std::async(std::launch::async, [&] {
    PictureSettings picture;
    picture.pen = scenario.pen;
    picture.pens = read_pens(run.attributes);
    // Wide enough to be seen beside the ink, and no wider than ink that swells or other pens draw.
    double thinnest = scenario.pen.thinnest();
    if (picture.pens)
      for (const DrawnPen& pen : picture.pens->pens)
        thinnest = std::min(thinnest, pen.line.thinnest());
    picture.target_width = 2.6 * thinnest;
    picture.R_WP = artwork.X_WP.R;
    picture.left_out = left_out_in(folder / "strokes.json");
    write_ink_top(run, drawn, folder / "ink_top", picture);
    write_ink_page(run, drawn, to_page, artwork.shape.target.page, folder / "ink_page", picture);
  });
  Metrics metrics = compute_metrics(run, drawn, canvas);
  if (std::filesystem::exists(folder / kIncidentFile)) metrics.ending.incident = kIncidentFile;
  write_metrics(folder, metrics);
  step();
  ReportSettings report;
  report.page = page_context(scenario, artwork, draw_again(folder));
  report.page.check = check;
  report.pictures_written = [&] {
    pictures.get();
    step();
  };
  write_report(folder, run, drawn, metrics, report);
  return metrics;
}

std::string draw_again(const std::filesystem::path& folder) {
  return as_called("./impedraw draw ") + (folder / "scenario.yaml").string();
}

GrooveJudge::GrooveJudge(const Experiment& e)
    : lines_(
          std::max(1, static_cast<int>(e.plan.strokes.size() / depths_of(e.scenario.tool).size()))),
      asked_(e.scenario.tool.depth),
      depth_(static_cast<std::size_t>(lines_)) {
  for (const PlacedStroke& stroke : e.plan.strokes) {
    std::vector<double>& line = depth_[static_cast<std::size_t>(stroke.number % lines_)];
    const double end = stroke.start + plane_length(stroke);
    if (line.empty()) line.resize(static_cast<std::size_t>(stroke.start / kBin), LogRow::kNone);
    line.resize(std::max(line.size(), static_cast<std::size_t>(std::ceil(end / kBin))), 0.0);
  }
}

void GrooveJudge::add(const LogRow& row) {
  if (row.stroke < 0 || !row.contact_point.allFinite() || !std::isfinite(row.stroke_along)) return;
  std::vector<double>& line = depth_[static_cast<std::size_t>(row.stroke % lines_)];
  const auto bin = static_cast<std::size_t>(std::max(0.0, row.stroke_along) / kBin);
  const Eigen::Vector3d to_surface = row.contact_point_W() - row.tip_position;
  if (bin < line.size()) line[bin] = std::max(line[bin], row.contact_normal_W().dot(to_surface));
}

nlohmann::ordered_json GrooveJudge::results() const {
  double count = 0.0, sum = 0.0, square = 0.0, most = 0.0;
  for (const std::vector<double>& line : depth_)
    for (const double depth : line) {
      if (!std::isfinite(depth)) continue;
      count += 1.0;
      sum += depth;
      square += (depth - asked_) * (depth - asked_);
      most = std::max(most, std::abs(depth - asked_));
    }
  nlohmann::ordered_json out;
  for (const char* name : {"depth_error_rms", "depth_error_max", "depth_mean"})
    out["metrics"][name] = nullptr;
  if (count > 0.0)
    out["metrics"] = {{"depth_error_rms", 1e3 * std::sqrt(square / count)},
                      {"depth_error_max", 1e3 * most},
                      {"depth_mean", 1e3 * sum / count}};
  out["depth_asked_mm"] = 1e3 * asked_;
  return out;
}

}  // namespace impedraw
