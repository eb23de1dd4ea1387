#include "impedraw/judge/force_results.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace impedraw {
namespace {

using Json = nlohmann::ordered_json;

Json number(const std::optional<double>& value) { return value ? Json(*value) : Json(nullptr); }

std::string name_of(ForceController controller) {
  return std::string(kForceControllerNames[static_cast<int>(controller)]);
}

// A figure that is there is better than none.
bool better(int metric, const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b) return a.has_value();
  return greater_is_better(metric) ? *a > *b : std::abs(*a) < std::abs(*b);
}

Json json_of(const JudgedController& judged) {
  Json runs = Json::array(), mean, worst;
  for (const JudgedRun& run : judged.runs) {
    Json one = {{"seed", run.seed}};
    for (int m = 0; m < kForceMetrics; ++m)
      one[std::string(kForceMetricNames[m])] = number(run.metrics.value[m]);
    if (!run.run.ended.empty()) one["ended"] = run.run.ended;
    runs.push_back(std::move(one));
  }
  for (int m = 0; m < kForceMetrics; ++m) {
    const ForceSummary summary = judged.summary(m);
    mean[std::string(kForceMetricNames[m])] = number(summary.mean);
    worst[std::string(kForceMetricNames[m])] = number(summary.worst);
  }
  return {{"controller", name_of(judged.controller)},
          {"runs", std::move(runs)},
          {"mean", std::move(mean)},
          {"worst", std::move(worst)}};
}

}  // namespace

ForceSummary JudgedController::summary(int metric) const {
  ForceSummary found;
  double sum = 0.0;
  for (const JudgedRun& run : runs) {
    const std::optional<double>& value = run.metrics.value[metric];
    sum += value.value_or(0.0);
    if (!value)
      ++found.lacking;
    else if (better(metric, found.worst, value) || !found.worst)
      found.worst = value;
  }
  if (found.lacking > 0)
    found.worst.reset();
  else if (!runs.empty())
    found.mean = sum / static_cast<double>(runs.size());
  return found;
}

std::vector<ForceBehind> behind(const ForceResults& results) {
  std::vector<ForceBehind> found;
  for (int m = 0; m < kForceMetrics; ++m)
    for (const JudgedCase& c : results.cases) {
      const auto ours = std::find_if(
          c.controllers.begin(), c.controllers.end(),
          [](const JudgedController& j) { return j.controller == ForceController::ours; });
      if (ours == c.controllers.end() || ours->runs.empty()) continue;
      const std::optional<double> own = ours->summary(m).mean;
      std::optional<ForceBehind> most;  // behind the better peer
      for (const JudgedController& peer : c.controllers) {
        const std::optional<double> other = peer.summary(m).mean;
        if (&peer == &*ours || !other) continue;
        if (better(m, other, own) && (!most || better(m, other, most->theirs)))
          most = ForceBehind{c.what.name, m, peer.controller, own, other};
      }
      if (most) found.push_back(*most);
    }
  return found;
}

std::string shown_metric(int metric, const std::optional<double>& value) {
  if (!value) return "–";
  switch (metric) {
    case kSettlingTime:
      return fmt::format("{:.2f} s", *value);
    case kOvershoot:
      return fmt::format("{:.0f} %", 100.0 * *value);
    case kBandwidth:
      return fmt::format("{:.1f} Hz", *value);
    case kWorkLost:
      return fmt::format("{:.1f} mJ", 1e3 * *value);
    default:
      return fmt::format("{:.2f} N", *value);
  }
}

std::string force_json(const ForceResults& results) {
  Json cases = Json::array(), lines = Json::array();
  for (const JudgedCase& c : results.cases) {
    Json controllers = Json::array();
    for (const JudgedController& judged : c.controllers) controllers.push_back(json_of(judged));
    cases.push_back(
        {{"case", c.what.name}, {"text", c.what.text}, {"controllers", std::move(controllers)}});
  }
  for (const ForceBehind& b : behind(results))
    lines.push_back({{"case", b.name},
                     {"metric", kForceMetricNames[b.metric]},
                     {"peer", name_of(b.peer)},
                     {"ours", number(b.ours)},
                     {"theirs", number(b.theirs)}});
  const Json units = {{"settling_time", "s"},
                      {"overshoot", "share of the change"},
                      {"steady_error", "N"},
                      {"rms", "N"},
                      {"sd", "N"},
                      {"bandwidth", "Hz"},
                      {"work_lost", "J"}};
  Json all = {{"simulated", results.simulated},
              {"arm", results.arm},
              {"driver", results.driver},
              {"command", results.again},
              {"runs", results.runs},
              {"seconds", results.seconds},
              {"units", units},
              {"cases", std::move(cases)},
              {"behind", std::move(lines)},
              {"left_out", results.left_out}};
  if (!results.ended.empty()) all["ended"] = results.ended;
  return all.dump(1) + "\n";
}

// The page and the table of the force benchmark.

namespace {

constexpr double kWidth = 250.0, kHeight = 90.0;  // of a plot [px]
constexpr int kBuckets = 150;                     // of a curve, each with its least and greatest

constexpr const char* kHead = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>Force benchmark</title><style>
:root{color-scheme:light dark;--text:#1c1c1e;--back:#fff;--line:#d8d8dc;--soft:#6b6b70;
--c0:#0a66c2;--c1:#c2571a;--c2:#3d8b40;--asked:#9a9aa0}
@media(prefers-color-scheme:dark){:root{--text:#e8e8ea;--back:#161618;--line:#3a3a3e;
--soft:#a0a0a6;--c0:#64a8f0;--c1:#f09a5c;--c2:#7cc47f;--asked:#77777d}}
body{font:15px/1.45 system-ui,sans-serif;color:var(--text);background:var(--back);margin:0 auto;
padding:1.2rem;max-width:1240px}
h1{font-size:1.5rem;margin:.2rem 0}h2{font-size:1.1rem;margin:1.6rem 0 .4rem}p,li{max-width:75ch}
code{font-size:.9em;overflow-wrap:anywhere}
.wide{overflow-x:auto}table{border-collapse:collapse;font-variant-numeric:tabular-nums;width:100%}
th,td{padding:.15rem .35rem;text-align:right;white-space:nowrap}th{font-weight:600;
color:var(--soft)}
th.case,td.case{text-align:left;vertical-align:top;white-space:normal;min-width:250px}
td.who{text-align:left}
tbody{border-top:1px solid var(--line)}td small,.soft{color:var(--soft)}td.best{font-weight:650}
.k0{color:var(--c0)}.k1{color:var(--c1)}.k2{color:var(--c2)}svg{display:block;margin:.2rem 0;
max-width:100%}
@media(max-width:700px){th.case,td.case{min-width:8.5rem;max-width:8.5rem}svg{width:8.5rem}}
polyline{fill:none;stroke-width:1.2}.p0{stroke:var(--c0)}.p1{stroke:var(--c1)}
.p2{stroke:var(--c2)}.asked{stroke:var(--asked);stroke-dasharray:3 2}
svg text{font-size:10px;fill:var(--soft)}svg line{stroke:var(--line)}
</style></head><body>
)";

std::string escaped(const std::string& text) {
  std::string safe;
  for (const char c : text) safe += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
  return safe;
}

// The range of a plot: the time judged and a little before, and the forces up to `most`.
struct Frame {
  double from, to, most;

  double x(double t) const { return 24.0 + (kWidth - 26.0) * (t - from) / (to - from); }
  double y(double f) const {
    return kHeight - 14.0 - (kHeight - 18.0) * std::clamp(f / most, 0.0, 1.0);
  }
};

// Least and greatest value of each bucket, so that a peak stays visible.
template <typename Value>
std::string curve(const std::vector<JudgedSample>& record, const Frame& frame, const char* kind,
                  double shift, Value value) {
  std::string points;
  int bucket = -1;
  double least = 0.0, greatest = 0.0, at = 0.0;
  const auto put = [&] {
    if (bucket < 0) return;
    points += fmt::format("{:.1f},{:.1f} ", frame.x(at), frame.y(least));
    if (greatest > least) points += fmt::format("{:.1f},{:.1f} ", frame.x(at), frame.y(greatest));
  };
  for (const JudgedSample& s : record) {
    const double t = s.time - shift;
    if (t < frame.from || t > frame.to) continue;
    const int now = static_cast<int>(kBuckets * (t - frame.from) / (frame.to - frame.from));
    if (now != bucket) {
      put();
      bucket = now;
      least = greatest = value(s);
      at = t;
    }
    least = std::min(least, value(s));
    greatest = std::max(greatest, value(s));
  }
  put();
  return fmt::format("<polyline class=\"{}\" points=\"{}\"/>", kind, points);
}

// The first run of each controller. Contacts are drawn from their touch on.
std::string plot(const JudgedCase& c) {
  Frame frame{0.0, 0.0, 0.0};
  const ForceRun* any = nullptr;
  for (const JudgedController& judged : c.controllers) {
    const ForceRun& run = judged.runs.front().run;
    if (!(run.question.to > run.question.from)) continue;
    if (!any) any = &run;
    const double before = c.what.judge_contact ? 0.05 : 0.2;
    frame.from = -before;
    frame.to = std::max(frame.to, run.question.to - run.question.from);
    for (const JudgedSample& s : run.record)
      if (s.time >= run.question.from && s.time <= run.question.to)
        frame.most = std::max({frame.most, s.asked, std::min(s.force, 4.0 * s.asked)});
  }
  if (!any) return {};
  frame.most = std::max(1.0, 1.05 * frame.most);
  std::string svg = fmt::format(
      "<svg width=\"{0}\" height=\"{1}\" viewBox=\"0 0 {0} {1}\" role=\"img\" aria-label=\"force "
      "over time\"><line x1=\"24\" x2=\"{2}\" y1=\"{3}\" y2=\"{3}\"/><text x=\"0\" "
      "y=\"{3}\">0</text><text x=\"0\" y=\"10\">{4:.0f} N</text><text x=\"{2}\" y=\"{5}\" "
      "text-anchor=\"end\">{6:.1f} s</text>",
      kWidth, kHeight, kWidth - 2.0, kHeight - 14.0, frame.most, kHeight - 2.0, frame.to);
  svg += curve(any->record, frame, "asked", any->question.from,
               [](const JudgedSample& s) { return s.asked; });
  for (auto judged = c.controllers.rbegin(); judged != c.controllers.rend(); ++judged)
    svg += curve(judged->runs.front().run.record, frame,
                 fmt::format("p{}", static_cast<int>(judged->controller)).c_str(),
                 judged->runs.front().run.question.from,
                 [](const JudgedSample& s) { return s.force; });
  return svg + "</svg>";
}

// Without the unit, which stands in the table's head.
std::string number(int metric, const std::optional<double>& value) {
  const std::string text = shown_metric(metric, value);
  return text.substr(0, text.find(' '));
}

bool best_of(const JudgedCase& c, const JudgedController& judged, int metric) {
  const std::optional<double> own = judged.summary(metric).mean;
  return own && c.controllers.size() > 1 &&
         std::none_of(c.controllers.begin(), c.controllers.end(), [&](const JudgedController& o) {
           return better(metric, o.summary(metric).mean, own);
         });
}

std::string unit(int metric) {
  const std::string text = shown_metric(metric, 0.0);
  return text.substr(text.find(' ') + 1);
}

bool asked_for(const JudgedCase& c, int metric) {
  return std::any_of(c.controllers.begin(), c.controllers.end(), [&](const JudgedController& j) {
    return std::any_of(j.runs.begin(), j.runs.end(),
                       [&](const JudgedRun& run) { return run.metrics.value[metric]; });
  });
}

std::string rows(const JudgedCase& c) {
  std::string html = "<tbody>";
  for (const JudgedController& judged : c.controllers) {
    const int who = static_cast<int>(judged.controller);
    html += "<tr>";
    if (&judged == &c.controllers.front())
      html += fmt::format("<td class=\"case\" rowspan=\"{}\"><b>{}</b> {}{}</td>",
                          c.controllers.size(), c.what.name, escaped(c.what.text), plot(c));
    html += fmt::format("<td class=\"who k{}\">{}</td>", who, kForceControllerNames[who]);
    for (int m = 0; m < kForceMetrics; ++m) {
      const ForceSummary summary = judged.summary(m);
      if (summary.mean)
        html += fmt::format("<td{}>{} <small>({})</small></td>",
                            best_of(c, judged, m) ? " class=\"best\"" : "", number(m, summary.mean),
                            number(m, summary.worst));
      else if (asked_for(c, m))
        html += fmt::format("<td>– <small>({} of {})</small></td>", summary.lacking,
                            judged.runs.size());
      else
        html += "<td></td>";
    }
    html += "</tr>";
    const auto failed = std::find_if(judged.runs.begin(), judged.runs.end(),
                                     [](const JudgedRun& run) { return !run.run.ended.empty(); });
    if (failed != judged.runs.end())
      html += fmt::format("<!-- {} seed {}: {} -->", kForceControllerNames[who], failed->seed,
                          escaped(failed->run.ended));
  }
  return html + "</tbody>\n";
}

std::string behind_list(const ForceResults& results) {
  const std::vector<ForceBehind> list = behind(results);
  if (list.empty()) return "<p>Nowhere, by the means over the runs.</p>\n";
  std::string html = "<ul>";
  for (int m = 0; m < kForceMetrics; ++m) {
    std::string line;
    for (const ForceBehind& b : list)
      if (b.metric == m)
        line += fmt::format("{}{}: {}, {} has {}", line.empty() ? "" : "; ", b.name,
                            shown_metric(m, b.ours), name_of(b.peer), shown_metric(m, b.theirs));
    if (!line.empty())
      html += fmt::format("<li><b>{}</b> {}</li>", kForceMetricNames[m], escaped(line));
  }
  return html + "</ul>\n";
}

std::string ended_list(const ForceResults& results) {
  std::string html;
  for (const JudgedCase& c : results.cases)
    for (const JudgedController& judged : c.controllers)
      for (const JudgedRun& run : judged.runs)
        if (!run.run.ended.empty())
          html += fmt::format("<li>{}, {}, seed {}: {}</li>", c.what.name,
                              name_of(judged.controller), run.seed, escaped(run.run.ended));
  return html.empty() ? html : "<h2>Runs that ended early</h2><ul>" + html + "</ul>\n";
}

constexpr const char* kTerms = R"(<h2>Terms</h2>
<p>Each cell: mean over the runs, and the worst in brackets; –: so many runs lack it. Bold: the
best mean of a case. The
plot shows the first run of each controller; the dashed line is the command.</p>
<ul><li><b>settling_time</b> from the end of a change, or from the touch, until the force stays
within 5 % of the change, and at least 0.1 N, of the command.</li>
<li><b>overshoot</b> greatest excess over the command after a change, as a share of the
change.</li>
<li><b>steady_error</b>, <b>sd</b> mean and standard deviation of force less command: the last
0.4 s of a plateau, or the whole of a holding or a path.</li>
<li><b>rms</b> of force less command, over all that is judged.</li>
<li><b>bandwidth</b> where the amplitude of force over command has fallen to 1/√2; the sweep's
end at most.</li>
<li><b>work_lost</b> force that lacks, times the way along the surface.</li></ul>
<p>Of several changes in a run, the worst counts. The force is what a sensor under the workpiece
feels: the contact force along the surface's normal. Every controller gets the same path, the
same command and the same wrong belief of where the workpiece is (0.5 mm, 0.5°, standard
deviations), and nobody is told how it moves.</p>
<p>Peers: the laws are written here from their papers, with the gains that their authors or
makers propose; they are not the peers' programs, and nobody tuned them for these cases. Both
keep a spring along the normal and measure no force.</p>
<p>Scenarios after Gadringer, Gattringer and Mueller, Mech. Sci. 13, 361–370, 2022; names of the
metrics after NISTIR 8097. Their figures of a UR10e and an active contact flange are not beside
these: only the abstract of the one and the contents of the other could be read where this page
was made.</p>
)";

}  // namespace

std::string force_page(const ForceResults& results) {
  std::string html = kHead;
  html += fmt::format("<h1>Force benchmark, {}</h1>\n<p>{}, {}{}. {} runs of each case",
                      results.simulated ? "simulated" : "measured", escaped(results.arm),
                      results.driver == "sim" ? "this program's simulator"
                      : results.simulated     ? "a simulator behind "
                                              : "an arm behind ",
                      results.driver == "sim" ? "" : results.driver, results.runs);
  html += fmt::format(" took {:.0f} s. Again: <code>{}</code></p>\n", results.seconds,
                      escaped(results.again));
  if (!results.ended.empty())
    html += fmt::format("<p><b>Not all of it:</b> {}.</p>\n", escaped(results.ended));
  html += "<p>";
  for (int i = 0; i < 3; ++i)
    html += fmt::format("<span class=\"k{0}\">■ {1}</span>: {2}{3}", i, kForceControllerNames[i],
                        kForceControllerTitles[i], i < 2 ? ", " : ".</p>\n");
  html += "<div class=\"wide\"><table><thead><tr><th class=\"case\">case</th><th></th>";
  for (int m = 0; m < kForceMetrics; ++m)
    html += fmt::format("<th>{}<br>[{}]</th>", kForceMetricNames[m], unit(m));
  html += "</tr></thead>\n";
  for (const JudgedCase& c : results.cases) html += rows(c);
  html += "</table></div>\n<h2>Where this program's controller is behind</h2>\n";
  html += behind_list(results) + ended_list(results);
  if (!results.left_out.empty()) {
    html += "<h2>Left out</h2><p>They need a workpiece that this arm's simulator does not have: ";
    for (const std::string& name : results.left_out)
      html += (&name == &results.left_out.front() ? "" : ", ") + name;
    html += ".</p>\n";
  }
  return html + kTerms + "</body></html>\n";
}

std::string force_markdown(const ForceResults& results) {
  std::string text = "| case | controller |";
  for (const std::string_view name : kForceMetricNames) text += fmt::format(" {} |", name);
  text += "\n|" + std::string(" --- |") + " --- |";
  for (int m = 0; m < kForceMetrics; ++m) text += " --- |";
  text += "\n";
  for (const JudgedCase& c : results.cases)
    for (const JudgedController& judged : c.controllers) {
      const bool first = &judged == &c.controllers.front();
      text += fmt::format("| {} | {} |", first ? c.what.name : "", name_of(judged.controller));
      for (int m = 0; m < kForceMetrics; ++m) {
        const ForceSummary summary = judged.summary(m);
        const std::string mean = shown_metric(m, summary.mean);
        text += !asked_for(c, m)        ? " |"
                : best_of(c, judged, m) ? fmt::format(" **{}** |", mean)
                                        : fmt::format(" {} |", mean);
      }
      text += "\n";
    }
  return text;
}

}  // namespace impedraw
