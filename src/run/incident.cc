#include "impedraw/run/incident.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include <fmt/format.h>

#include "impedraw/files/durable_file.h"

namespace impedraw {
namespace {

constexpr double kWidth = 820.0, kHeight = 120.0, kLeft = 60.0,
                 kRight = 10.0;  // plot size and margins [px]

std::string html_text(const std::string& text) {
  std::string out;
  for (const char c : text)
    out += c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '&' ? "&amp;" : std::string(1, c);
  return out;
}

// One plot over the time before the end; NaN leaves a gap.
std::string plot(const std::vector<IncidentRow>& rows, const char* name,
                 const std::function<double(const IncidentRow&)>& value) {
  double most = 0.0;
  int known = 0;
  for (const IncidentRow& row : rows)
    if (const double y = value(row); std::isfinite(y)) {
      most = std::max(most, y);
      ++known;
    }
  if (known == 0) return fmt::format("<h2>{}</h2>\n<p>Not known in this run.</p>\n", name);
  const double top = most > 0.0 ? 1.05 * most : 1.0, end = rows.back().time;
  std::string path;
  bool pen = false;
  for (const IncidentRow& row : rows) {
    const double y = value(row);
    if (!std::isfinite(y)) {
      pen = false;
      continue;
    }
    path +=
        fmt::format("{}{:.1f} {:.1f}", pen ? "L" : "M",
                    kWidth - kRight - (end - row.time) / kIncidentTime * (kWidth - kLeft - kRight),
                    kHeight * (1.0 - y / top));
    pen = true;
  }
  std::string lines;
  for (int i = 0; i <= 4; ++i) {
    const double x = kWidth - kRight - 0.25 * i * (kWidth - kLeft - kRight);
    lines += fmt::format(R"(<line x1="{0:.1f}" y1="0" x2="{0:.1f}" y2="{1}"/>)"
                         R"(<text x="{0:.1f}" y="{2}">{3:.4g} s</text>)",
                         x, kHeight, kHeight + 14, end - 0.25 * i * kIncidentTime);
  }
  return fmt::format(
      R"(<h2>{0}</h2>
<svg viewBox="0 0 {1} {2}" role="img" aria-label="{0}, at most {3:.4g}">{4}
<text x="{5}" y="10">{3:.3g}</text><text x="{5}" y="{6}">0</text><path d="{7}"/></svg>
)",
      name, kWidth, kHeight + 18, most, lines, kLeft - 6, kHeight, path);
}

}  // namespace

LastSeconds::LastSeconds(double period, const ArmModel& arm)
    : limits_(arm.limits()),
      ring_(static_cast<std::size_t>(std::max(1.0, std::ceil(kIncidentTime / period)))) {}

void LastSeconds::add(const LogRow& row, const Cycle& cycle) noexcept {
  IncidentRow& out = ring_[count_++ % ring_.size()];
  const double measured = cycle.F_ext.head<3>().norm();
  out.time = row.time;
  // A simulator's own contact first; the log's is NaN where nobody knows it.
  out.force = row.contact_force.allFinite() ? row.contact_force.norm()
              : measured > 0.0              ? measured
                                            : LogRow::kNone;
  out.speed = cycle.arm.V_WE.head<3>().norm();
  out.joint_speed = (cycle.arm.v.array().abs() / limits_.speed.array()).maxCoeff();
  out.torque = (row.joint_torque.array().abs() / limits_.torque.array()).maxCoeff();
  out.state_age = cycle.state_age;
  out.step_time = row.step_time;
}

std::vector<IncidentRow> LastSeconds::rows() const {
  std::vector<IncidentRow> rows;
  const std::size_t n = std::min(count_, ring_.size());
  for (std::size_t i = count_ - n; i < count_; ++i) rows.push_back(ring_[i % ring_.size()]);
  return rows;
}

void write_incident(const std::filesystem::path& folder, const Scenario& scenario,
                    const RunOutcome& outcome) {
  const std::vector<IncidentRow>& rows = outcome.last;
  std::string page = fmt::format(
      R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Incident: {0}</title>
<style>
body {{ font: 14px/1.4 sans-serif; max-width: 840px; margin: 1.5em auto; color: #222 }}
h1 {{ font-size: 1.3em }} h2 {{ font-size: 1em; margin: 0.8em 0 0.2em }}
svg {{ width: 100%; display: block }} path {{ fill: none; stroke: #1f5fa8; stroke-width: 1.2 }}
line {{ stroke: #ddd }} text {{ font-size: 11px; fill: #555; text-anchor: end }}
</style></head><body>
<h1>{0} was stopped</h1>
<p><strong>{1}</strong></p>
)",
      html_text(scenario.name), html_text(outcome.cause));
  if (rows.empty()) {
    page += "<p>No control step was made.</p>\n";
  } else {
    page += fmt::format(
        "<p>The last {:.2f} s, {} control steps, up to t = {:.3f} s of the run's log (run.h5). The "
        "controller's step is {:.3g} ms.</p>\n",
        rows.back().time - rows.front().time, rows.size(), rows.back().time,
        1e3 * scenario.world.dt);
    page += plot(rows, "Force on the tip [N]", [](const IncidentRow& r) { return r.force; });
    page +=
        plot(rows, "Speed of the tip [mm/s]", [](const IncidentRow& r) { return 1e3 * r.speed; });
    page += plot(rows, "Fastest joint [% of its limit]",
                 [](const IncidentRow& r) { return 1e2 * r.joint_speed; });
    page += plot(rows, "Largest joint torque [% of its limit]",
                 [](const IncidentRow& r) { return 1e2 * r.torque; });
    page += plot(rows, "Lag: age of the joint state [ms]",
                 [](const IncidentRow& r) { return 1e3 * r.state_age; });
    page += plot(rows, "Lag: duration of the control step [ms]",
                 [](const IncidentRow& r) { return 1e3 * r.step_time; });
  }
  write_whole(folder / kIncidentFile, page + "</body></html>\n");
}

}  // namespace impedraw
