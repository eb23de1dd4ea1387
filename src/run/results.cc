#include "impedraw/run/results.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <future>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/experiment/page_context.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/report/report.h"
#include "impedraw/run/tool_judge.h"
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

// The "metrics" of a tool's file; empty without it.
nlohmann::ordered_json judged(const std::filesystem::path& file) {
  std::ifstream in(file);
  const auto whole = nlohmann::ordered_json::parse(in, nullptr, false);
  return whole.is_object() && whole.contains("metrics") ? whole["metrics"]
                                                        : nlohmann::ordered_json::object();
}

// The metrics of a covered area, a groove, a led blade or a jet come first.
void write_metrics(const std::filesystem::path& folder, const Metrics& metrics) {
  nlohmann::ordered_json all = nlohmann::ordered_json::object();
  for (const char* const file : {kCoverFile, kGrooveFile, kBladeFile, kJetFile})
    all.update(judged(folder / file));
  all.update(metrics_json(metrics));
  write_whole(folder / "metrics.json", all.dump(2) + "\n");
}

}  // namespace

std::string tool_figures(const std::filesystem::path& folder) {
  std::string text;
  for (const char* const file : {kGrooveFile, kBladeFile, kJetFile}) {
    const nlohmann::ordered_json figures = judged(folder / file);
    for (const auto& [name, value] : figures.items())
      if (value.is_number())
        text += fmt::format("{}{} {:.3g}", text.empty() ? "  tool        " : ", ", name,
                            value.get<double>());
  }
  return text.empty() ? text : text + "\n";
}

Backdrop backdrop_of(const Scenario& scenario, const PlacedArtwork& artwork,
                     const std::filesystem::path& folder, const TriangleMesh* canvas) {
  Backdrop backdrop{page_context(scenario, artwork, draw_again(folder))};
  if (!canvas) return backdrop;
  backdrop.page.canvas =
      std::make_shared<const PageMesh>(canvas_mesh(canvas->vertices, canvas->triangles));
  backdrop.relief = ink_relief(canvas->vertices, canvas->triangles, artwork.X_WP.R);
  return backdrop;
}

Metrics write_results(const std::filesystem::path& folder, const Scenario& scenario,
                      const PlacedArtwork& artwork, Backdrop backdrop,
                      const std::function<void()>& check, const Canvas* canvas) {
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
  const std::filesystem::path top = folder / "ink_top", page = folder / "ink_page";
  // On the second core while metrics and page are made, and one after the other, as Cairo numbers
  // what it draws. Does not read the log: HDF5 is not for two threads.
  const std::shared_future<std::array<Picture, 2>> drawings = std::async(std::launch::async, [&] {
    PictureSettings picture;
    picture.relief = backdrop.relief;
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
    std::array both{ink_top(run, drawn, picture),
                    ink_page(run, drawn, to_page, artwork.shape.target().page, picture)};
    both[0].write_svg(top);
    both[1].write_svg(page);
    return both;
  });
  std::future<void> pictures = std::async(std::launch::async, [&] {
    drawings.get()[0].write_png(top);
    drawings.get()[1].write_png(page);
  });
  Metrics metrics = compute_metrics(run, drawn, canvas);
  if (std::filesystem::exists(folder / kIncidentFile)) metrics.ending.incident = kIncidentFile;
  // The disk is waited for while the page is made.
  std::future<void> written =
      std::async(std::launch::async, [&] { write_metrics(folder, metrics); });
  step();
  ReportSettings report;
  report.page = std::move(backdrop.page);
  report.page.check = check;
  report.pictures_written = [&] {
    written.get();
    drawings.get();
    if (shows_png(top) || shows_png(page)) pictures.wait();
    step();
  };
  write_report(folder, run, drawn, metrics, report);
  pictures.get();
  return metrics;
}

std::string draw_again(const std::filesystem::path& folder) {
  return as_called("./impedraw draw ") + (folder / "scenario.yaml").string();
}

}  // namespace impedraw
