#include "impedraw/report/report.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "impedraw/common/errors.h"
#include "impedraw/files/durable_file.h"
#include "impedraw/report/sheet.h"

namespace impedraw {
namespace {

using Json = nlohmann::ordered_json;

// The picture of runs compared: a column for each, on equal axes, with the drawn and the desired
// line seen from above, the normal force, and the tilt.
struct PicturedRun {
  std::string name;
  std::vector<Line2d> target, ink;                 // from above, (−y, x) [mm]
  Envelope force, push, tilt, normal_error;        // [N], [deg]
  std::vector<std::pair<double, double>> strokes;  // [s]
};

// Sizes in the picture [mm].
constexpr double kColumnWide = 140.0, kColumnLeft = 16.0, kPanelGap = 14.0, kPanelHigh = 44.0,
                 kLineTop = 20.0, kLetter = 3.2;
constexpr Colour kLineInk{0.09, 0.24, 0.52}, kLineTarget{0.98, 0.72, 0.38},
    kOther{0.78, 0.27, 0.18}, kDown{0.93, 0.95, 0.97}, kRule{0.88, 0.89, 0.91},
    kWord{0.13, 0.15, 0.18};

// A panel's frame on the picture, and what of its data it shows.
struct PlotFrame {
  Eigen::AlignedBox2d frame, data;
  Eigen::Vector2d at(double x, double y) const {
    const Eigen::Vector2d share = (Eigen::Vector2d(x, y) - data.min()).cwiseQuotient(data.sizes());
    return {frame.min().x() + share.x() * frame.sizes().x(),
            frame.max().y() - share.y() * frame.sizes().y()};
  }
};

std::string minus_text(double value) {
  const std::string text = fmt::format("{:g}", std::abs(value));
  return (value < 0.0 ? "−" : "") + text;
}

// Axes with ticks; x_sign: a tick at x is labelled x_sign · x.
void draw_frame(cairo_t* cr, const PlotFrame& plot, const std::string& title,
                const std::string& x_name, double x_sign = 1.0) {
  const Eigen::Vector2d low = plot.frame.min(), high = plot.frame.max();
  cairo_set_line_width(cr, 0.15);
  for (const double x : ticks(plot.data.min().x(), plot.data.max().x(), plot.data.sizes().x())) {
    const double u = plot.at(x, 0.0).x();
    set_colour(cr, kRule);
    stroke_line(cr, {{u, low.y()}, {u, high.y()}});
    set_colour(cr, kWord);
    show_text(cr, u, high.y() + 4.2, minus_text(x_sign * x), 0.5);
  }
  for (const double y : ticks(plot.data.min().y(), plot.data.max().y(), plot.data.sizes().y())) {
    const double v = plot.at(0.0, y).y();
    set_colour(cr, kRule);
    stroke_line(cr, {{low.x(), v}, {high.x(), v}});
    set_colour(cr, kWord);
    show_text(cr, low.x() - 1.2, v + 1.1, minus_text(y), 1.0);
  }
  set_colour(cr, kWord);
  show_text(cr, low.x(), low.y() - 1.6, title);
  show_text(cr, high.x(), high.y() + 8.2, x_name, 1.0);
}

void draw_curve(cairo_t* cr, const PlotFrame& plot, const Envelope& curve, const Colour& colour,
                bool dashed = false) {
  set_colour(cr, colour);
  cairo_set_line_width(cr, 0.3);
  if (dashed) set_dash(cr, 1.6, 0.9);
  for (std::size_t i = 0; i < curve.t.size(); ++i) {
    if (!std::isfinite(curve.v[i])) {
      cairo_new_sub_path(cr);
      continue;
    }
    const Eigen::Vector2d p = plot.at(curve.t[i], curve.v[i]);
    cairo_line_to(cr, p.x(), p.y());
  }
  cairo_stroke(cr);
  set_dash(cr);
}

void draw_lines(cairo_t* cr, const PlotFrame& plot, const std::vector<Line2d>& lines,
                const Colour& colour, double width) {
  set_colour(cr, colour);
  cairo_set_line_width(cr, width);
  for (Line2d line : lines) {
    for (Eigen::Vector2d& p : line) p = plot.at(p.x(), p.y());
    trace(cr, line);
  }
  cairo_stroke(cr);
}

// Entries of a legend that ends at x.
void draw_keys(cairo_t* cr, double x, double y,
               const std::vector<std::pair<std::string, Colour>>& entries) {
  for (auto entry = entries.rbegin(); entry != entries.rend(); ++entry) {
    set_colour(cr, kWord);
    x -= show_text(cr, x, y, entry->first, 1.0) + 1.5;
    set_colour(cr, entry->second);
    cairo_set_line_width(cr, 0.9);
    stroke_line(cr, {{x - 6.0, y - 1.1}, {x, y - 1.1}});
    x -= 10.0;
  }
}

Line2d seen_from_above(std::span<const Eigen::Vector3d> line) {
  Line2d out;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const Eigen::Vector2d p(-1e3 * line[i].y(), 1e3 * line[i].x());
    if (out.empty() || i + 1 == line.size() || (p - out.back()).norm() >= 0.2) out.push_back(p);
  }
  return out;
}

PicturedRun pictured_run(const std::string& name, const RunData& run, const InkMatch& drawn) {
  constexpr double kDegree = 180.0 / std::numbers::pi;
  constexpr std::size_t kPoints = 3000;
  PicturedRun out;
  out.name = name;
  for (const auto& line : drawn.targets) out.target.push_back(seen_from_above(line));
  for (const InkLine& line : drawn.lines)
    out.ink.push_back(
        seen_from_above(std::span(run.contact_point).subspan(line.begin, line.end - line.begin)));
  decimate_to(out.target, 0.02, 20000);
  decimate_to(out.ink, 0.02, 20000);
  const auto thinned = [&run](const std::vector<double>& v, double scale) {
    return envelope(
        run.time, [&](std::size_t i) { return scale * v[i]; }, kPoints);
  };
  out.force = thinned(run.f, 1.0);
  out.push = thinned(run.push, 1.0);
  out.tilt = thinned(run.tilt, kDegree);
  out.normal_error = thinned(run.normal_error, kDegree);
  for (const StrokeSpan& span : drawn.spans)
    out.strokes.emplace_back(run.time[span.begin], run.time[span.end - 1]);
  return out;
}

void write_comparison_picture(const std::string& title, const std::vector<PicturedRun>& runs,
                              const std::filesystem::path& stem) {
  Eigen::AlignedBox2d lines;
  double last = 1.0, most_force = 1.0, most_tilt = 1.0;
  for (const PicturedRun& run : runs) {
    extend(&lines, run.target);
    extend(&lines, run.ink);
    if (!run.force.t.empty()) last = std::max(last, run.force.t.back());
    const auto highest = [](const Envelope& e, double* most) {
      for (const double v : e.v)
        if (std::isfinite(v)) *most = std::max(*most, 1.05 * v);
    };
    highest(run.force, &most_force);
    highest(run.push, &most_force);
    highest(run.tilt, &most_tilt);
    highest(run.normal_error, &most_tilt);
  }
  if (lines.isEmpty()) lines.extend(Eigen::Vector2d::Zero());
  const double room = 3.0 + 0.04 * lines.sizes().maxCoeff();
  lines.extend(Eigen::Vector2d(lines.min() - Eigen::Vector2d::Constant(room)));
  lines.extend(Eigen::Vector2d(lines.max() + Eigen::Vector2d::Constant(room)));
  // Equal scales in both directions: the frame of the line is as high as its data asks.
  const double high = std::clamp(kColumnWide * lines.sizes().y() / lines.sizes().x(), 40.0, 180.0);
  const double scale = std::max(lines.sizes().x() / kColumnWide, lines.sizes().y() / high);
  const Eigen::Vector2d centre = lines.center(),
                        half(0.5 * scale * kColumnWide, 0.5 * scale * high);
  const Eigen::AlignedBox2d shown(centre - half, centre + half);
  const auto n = static_cast<double>(runs.size());
  const Eigen::Vector2d size(n * (kColumnLeft + kColumnWide) + 6.0,
                             kLineTop + high + 2.0 * (kPanelGap + kPanelHigh) + 4.0 * kLetter);
  write_svg_and_png(stem, size, static_cast<int>(1700.0 * n / 2.0), [&](cairo_t* cr) {
    set_colour(cr, {1.0, 1.0, 1.0});
    cairo_paint(cr);
    round_lines(cr);
    for (std::size_t k = 0; k < runs.size(); ++k) {
      const PicturedRun& run = runs[k];
      const double left = kColumnLeft + static_cast<double>(k) * (kColumnLeft + kColumnWide);
      const auto frame = [&](double top, double height, Eigen::AlignedBox2d data) {
        return PlotFrame{
            {Eigen::Vector2d(left, top), Eigen::Vector2d(left + kColumnWide, top + height)}, data};
      };
      set_colour(cr, kWord);
      write_words(cr, left + kColumnWide / 2, 6.5, run.name, 1.3 * kLetter, true, 0.5);
      set_font(cr, kLetter);
      if (k == 0) show_text(cr, left, 6.5, title);

      const PlotFrame line = frame(kLineTop - 5.0, high, shown);
      draw_frame(cr, line, "x [mm]", "y [mm]", -1.0);
      draw_lines(cr, line, run.target, kLineTarget, 1.1);
      draw_lines(cr, line, run.ink, kLineInk, 0.4);
      draw_keys(cr, left + kColumnWide, kLineTop - 6.6,
                {{"target", kLineTarget}, {"drawn", kLineInk}});

      const double top = kLineTop - 5.0 + high + kPanelGap;
      const PlotFrame force =
          frame(top, kPanelHigh, {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(last, most_force)});
      const PlotFrame tilt = frame(top + kPanelHigh + kPanelGap, kPanelHigh,
                                   {Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(last, most_tilt)});
      for (const PlotFrame* plot : {&force, &tilt}) {
        set_colour(cr, kDown);
        for (const auto& [begin, end] : run.strokes) {
          const Eigen::Vector2d a = plot->at(begin, plot->data.max().y()), b = plot->at(end, 0.0);
          cairo_rectangle(cr, a.x(), a.y(), b.x() - a.x(), b.y() - a.y());
        }
        cairo_fill(cr);
      }
      draw_frame(cr, force, "normal force [N]", "");
      draw_curve(cr, force, run.force, kLineInk);
      draw_curve(cr, force, run.push, kOther, true);
      draw_keys(cr, left + kColumnWide, top - 1.6,
                {{"normal force", kLineInk}, {"desired", kOther}});
      draw_frame(cr, tilt, "tilt [deg]", "time [s]");
      draw_curve(cr, tilt, run.normal_error, kOther);
      draw_curve(cr, tilt, run.tilt, kLineInk);
      draw_keys(cr, left + kColumnWide, top + kPanelHigh + kPanelGap - 1.6,
                {{"pen against true normal", kLineInk}, {"estimated normal", kOther}});
    }
  });
}

std::string title_of(const RunData& run, const std::string& given) {
  const auto scenario = run.attributes.find("scenario");
  const std::string title = !given.empty()                     ? given
                            : scenario == run.attributes.end() ? "impedraw"
                                                               : scenario->second;
  return title + (run.attributes.contains("rehearsal") ? " (rehearsal)" : "");
}

Json limits_json(const std::map<std::string, MetricLimit>& limits) {
  Json out = Json::object();
  for (const auto& [name, limit] : limits) {
    out[name] = Json::object();
    if (limit.least) out[name]["min"] = *limit.least;
    if (limit.most) out[name]["max"] = *limit.most;
  }
  return out;
}

PageRun page_of(const std::filesystem::path& folder, const RunData& run,
                const ReportSettings& settings) {
  PageRun page;
  page.title = title_of(run, settings.title);
  page.log = folder / "run.h5";
  page.scenario_file = folder / "scenario.yaml";
  page.strokes_file = folder / "strokes.json";
  page.pictures = [folder, written = settings.pictures_written]() -> std::vector<PagePicture> {
    if (written) written();
    return {{"Ink against target, seen from above", shown_picture(folder / "ink_top")},
            {"Ink against target, on the page", shown_picture(folder / "ink_page")}};
  };
  page.limits = limits_json(settings.limits).dump();
  return page;
}

std::filesystem::path page_in(const std::filesystem::path& run) {
  std::error_code error;
  if (std::filesystem::is_regular_file(run, error) && run.extension() == ".html") return run;
  for (const char* name : {"report.html", "plan.html", "compare.html"})
    if (std::filesystem::is_regular_file(run / name, error)) return run / name;
  throw InputError(
      fmt::format("{}: has no report.html; name the folder of a run, of a plan or of a comparison, "
                  "or write a run's page with ./impedraw report",
                  run.string()));
}

}  // namespace

bool shows_png(const std::filesystem::path& stem) {
  constexpr std::uintmax_t kLargeSvg = 1'500'000;  // [bytes]
  std::error_code error;
  return !(std::filesystem::file_size(stem.string() + ".svg", error) <= kLargeSvg);
}

std::filesystem::path shown_picture(const std::filesystem::path& stem) {
  const std::filesystem::path svg = stem.string() + ".svg", png = stem.string() + ".png";
  return shows_png(stem) && std::filesystem::exists(png) ? png : svg;
}

void write_report(const std::filesystem::path& folder, const RunData& run, const InkMatch& drawn,
                  const Metrics& metrics, const ReportSettings& settings) {
  const PageRun page = page_of(folder, run, settings);
  write_whole(folder / "report.html",
              page_html(page.title, {make_payload(page, run, drawn, metrics, settings.page)}));
}

void write_comparison(const std::vector<ComparedRun>& runs, const std::filesystem::path& out,
                      const ReportSettings& settings) {
  std::vector<PagePayload> payloads;
  std::vector<PicturedRun> pictured;
  std::string title;
  for (const ComparedRun& compared : runs) {
    const RunData run = read_run(compared.folder / "run.h5");
    const InkMatch drawn = match_ink(run);
    PageRun page = page_of(compared.folder, run, settings);
    if (title.empty()) title = page.title;
    page.name = compared.name;
    payloads.push_back(make_payload(page, run, drawn, compute_metrics(run, drawn), compared.page));
    pictured.push_back(pictured_run(compared.name, run, drawn));
  }
  write_comparison_picture(title, pictured, out / "compare");
  write_whole(out / "compare.html", page_html(title, payloads));
}

int film(const FilmOptions& options) {
  const std::string kind = options.out.extension();
  if (kind != ".webp" && kind != ".mp4" && kind != ".png")
    throw InputError(fmt::format("--out {}: ends in '{}'; valid are .webp, .mp4, .png",
                                 options.out.string(), kind));
  const std::filesystem::path folder = std::filesystem::absolute(options.out).parent_path();
  if (!std::filesystem::is_directory(folder))
    throw InputError(
        fmt::format("--out {}: there is no folder {}", options.out.string(), folder.string()));
  int width = 0, height = 0, read = 0;
  constexpr int kLeast = 64, kMost = 4096;
  if (std::sscanf(options.size.c_str(), "%4dx%4d%n", &width, &height, &read) != 2 ||
      static_cast<std::size_t>(read) != options.size.size() || std::min(width, height) < kLeast ||
      std::max(width, height) > kMost || width % 2 != 0 || height % 2 != 0)
    throw InputError(
        fmt::format("--size {}: must be WIDTHxHEIGHT, even numbers from {} to {}, as in 1280x720",
                    options.size, kLeast, kMost));
  if (options.from && options.to && !(*options.from < *options.to))
    throw InputError(
        fmt::format("--from {} s must lie before --to {} s", *options.from, *options.to));
  nlohmann::json job = {
      {"page", std::filesystem::absolute(page_in(options.run)).lexically_normal().string()},
      {"out", std::filesystem::absolute(options.out).lexically_normal().string()},
      {"web", std::string(IMPEDRAW_ROOT) + "/build/web"},
      {"width", width},
      {"height", height},
      {"fps", options.fps},
      {"speed", options.speed},
      {"view", options.view},
      {"colour", options.colour},
      {"theme", options.theme},
      {"hide", options.hide},
      {"plain", options.plain}};
  if (options.from) job["from"] = *options.from;
  if (options.to) job["to"] = *options.to;
  const std::string program = std::string(IMPEDRAW_ROOT) + "/web/film.mjs", text = job.dump();
  std::fflush(stdout);
  execlp("node", "node", program.c_str(), text.c_str(), static_cast<char*>(nullptr));
  throw InputError(fmt::format("film needs node on PATH: {}", std::strerror(errno)));
}

}  // namespace impedraw
