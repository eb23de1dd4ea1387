// Numbers, strokes and settings.
import { quantile } from "./colours";
import type { Finding, Limit, Part, Run } from "./data";
import { h, numberText, timeText } from "./dom";
import type { LiveNumbers } from "./live";
import { wantsCoarse } from "./software";

export function holds(value: unknown, limit: Limit): boolean {
  return typeof value === "number" && value >= (limit.min ?? -Infinity) && value <= (limit.max ?? Infinity);
}

function limitText(limit: Limit): string {
  if (limit.min !== undefined && limit.max !== undefined) return `${limit.min} … ${limit.max}`;
  return limit.min !== undefined ? `≥ ${limit.min}` : `≤ ${limit.max}`;
}

export function numbers(run: Run): HTMLElement {
  const limited = Object.keys(run.limits).length > 0;
  const reasons = (run.metrics.reasons ?? {}) as Record<string, string>;
  const head = h("tr", {}, h("th", {}, "metric"), h("th", { class: "n" }, "value"), h("th", {}, "unit"),
    limited ? h("th", { class: "n" }, "limit") : null);
  const rows = run.definitions.map((d) => {
    const value = run.metrics[d.name];
    const limit = run.limits[d.name];
    const met = !limit || holds(value, limit);
    const judged = limit ? (met ? "ok" : "bad") : "";
    // Beneath the name: a column of its own is narrow, and stands beyond the edge of a small screen.
    const meaning = reasons[d.name] ? `${d.meaning} (none: ${reasons[d.name]})` : d.meaning;
    return h("tr", {}, h("td", {}, h("code", {}, d.name), h("div", { class: "why" }, meaning)),
      h("td", { class: `n ${judged}` }, numberText(value) + (limit && !met ? " ✗" : limit ? " ✓" : "")),
      h("td", {}, d.unit === "1" ? "" : d.unit),
      limited ? h("td", { class: "n" }, limit ? limitText(limit) : "") : null);
  });
  return h("div", { class: "scroll" }, h("table", { class: "numbers" }, h("thead", {}, head), h("tbody", {}, ...rows)));
}

// The numbers of runs side by side; of two, their difference.
export function comparison(runs: Run[]): HTMLElement {
  const two = runs.length === 2;
  const head = h("tr", {}, h("th", {}, "metric"), ...runs.map((run) => h("th", { class: "n" }, run.name)),
    two ? h("th", { class: "n" }, "difference") : null, h("th", {}, "unit"));
  const rows = runs[0].definitions.map((d) => {
    const values = runs.map((run) => run.metrics[d.name]);
    const reasons = [...new Set(runs.map((run) => ((run.metrics.reasons ?? {}) as Record<string, string>)[d.name]).filter(Boolean))];
    // Beneath the name: in a column of its own it stood beyond the panel's edge.
    const meaning = reasons.length ? `${d.meaning} (none: ${reasons.join("; ")})` : d.meaning;
    return h("tr", {}, h("td", {}, h("code", {}, d.name), h("div", { class: "why" }, meaning)), ...values.map((v) => h("td", { class: "n" }, numberText(v))),
      two ? h("td", { class: "n" }, differenceText(values[0], values[1])) : null,
      h("td", {}, d.unit === "1" ? "" : d.unit));
  });
  return h("div", { class: "scroll" }, h("table", { class: "comparison" }, h("thead", {}, head), h("tbody", {}, ...rows)));
}

// b − a, signed.
export function differenceText(a: unknown, b: unknown): string {
  if (typeof a !== "number" || typeof b !== "number") return "–";
  const d = b - a;
  // What rounding alone makes is no difference.
  if (Math.abs(d) < 1e-9 * Math.max(Math.abs(a), Math.abs(b))) return "0";
  return (d > 0 ? "+" : "") + numberText(d, 3);
}

// What settings differ.
export function changedSettings(runs: Run[]): HTMLElement {
  const names = [...new Set(runs.flatMap((run) => run.settings.map(([name]) => name)))];
  const of = runs.map((run) => new Map(run.settings.map(([name, value]) => [name, value])));
  const rows = names.filter((name) => new Set(of.map((m) => m.get(name))).size > 1)
    .map((name) => h("tr", {}, h("td", {}, h("code", {}, name)), ...of.map((m) => h("td", { class: "n" }, m.get(name) || "–"))));
  if (!rows.length) return h("p", { class: "hint" }, "The runs have the same settings.");
  return h("div", { class: "scroll" }, h("table", { class: "settings" }, h("thead", {}, h("tr", {}, h("th", {}, "setting"),
    ...runs.map((run) => h("th", { class: "n" }, run.name)))), h("tbody", {}, ...rows)));
}

// What a plan leaves out, by its reason.
export function findings(run: Run, problems: string[], colourOf: (k: number) => string, look: (f: Finding) => void): HTMLElement {
  if (!run.findings.length) return h("p", { class: "ok" }, "All of it can be drawn.");
  const box = h("div", { class: "findings" });
  problems.forEach((problem, k) => {
    const list = run.findings.filter((f) => f.problem === problem);
    const length = list.reduce((sum, f) => sum + f.to_mm - f.from_mm, 0);
    const mark = h("i");
    mark.style.setProperty("--key", colourOf(k));
    box.append(h("h3", {}, mark, `${problem.replaceAll("_", " ")}: ${list.length} part${list.length === 1 ? "" : "s"}, ${numberText(length, 3)} mm`));
    box.append(h("div", { class: "scroll" }, h("table", {}, h("tbody", {}, ...list.map((f) => {
      const button = h("button", { type: "button", class: "small", "aria-label": `show what fails on stroke ${f.stroke}, from ${numberText(f.from_mm, 3)} mm` }, "show");
      button.addEventListener("click", () => look(f));
      return h("tr", {}, h("td", {}, button), h("td", {}, `stroke ${f.stroke}`),
        h("td", { class: "n" }, `${numberText(f.from_mm, 3)} to ${numberText(f.to_mm, 3)} mm`), h("td", {}, f.text));
    })))));
  });
  return box;
}

// The numbers of plan.json, but for its list of findings.
export function planNumbers(run: Run): HTMLElement {
  const rows: HTMLElement[] = [];
  const walk = (name: string, value: unknown) => {
    if (name === "not_drawable") return;
    if (Array.isArray(value) || value === null || typeof value !== "object") {
      const text = Array.isArray(value) ? value.map((v) => (typeof v === "number" ? numberText(v) : JSON.stringify(v))).join(", ")
        : typeof value === "number" || value === null ? numberText(value) : String(value);
      rows.push(h("tr", {}, h("td", {}, h("code", {}, name)), h("td", { class: "n" }, text)));
    } else {
      for (const [key, inner] of Object.entries(value)) walk(name ? `${name}.${key}` : key, inner);
    }
  };
  walk("", run.plan);
  return h("div", { class: "scroll" }, h("table", { class: "settings" }, h("tbody", {}, ...rows)));
}

export const tileNames: [string, string][] = [
  ["ink_error_rms", "ink error, RMS"], ["coverage", "of the target covered"], ["contact_fraction", "contact fraction"],
  ["force_mean", "normal force, mean"], ["force_sd", "its standard deviation"], ["tilt_mean", "tilt, mean"],
];

// The numbers so far of a run that goes on.
export function liveTiles(now: LiveNumbers, run: Run, strokeCount: number): HTMLElement {
  const tile = (value: string, label: string) => h("div", {}, h("dd", {}, value), h("dt", {}, label));
  const begun = new Set(run.spans.map(([stroke]) => stroke)).size;
  return h("dl", { class: "tiles" },
    tile(timeText(run.scene.time.at(-1) ?? 0), `of about ${timeText(run.live?.duration ?? 0)}`),
    tile(`${begun} of ${strokeCount}`, "strokes begun"),
    tile(`${numberText(now.error, 3)}\u202fmm`, "ink error so far, RMS"), tile(`${numberText(now.errorMax, 3)}\u202fmm`, "largest"),
    tile(`${numberText(now.force, 3)}\u202fN`, "normal force so far, mean"), tile(`${numberText(now.forceSd, 3)}\u202fN`, "its standard deviation"),
    tile(`${numberText(now.tilt, 3)}\u202f°`, "tilt so far, mean"));
}

export function tiles(run: Run): HTMLElement {
  const units = new Map(run.definitions.map((d) => [d.name, d.unit]));
  return h("dl", { class: "tiles" }, ...tileNames.map(([name, label]) => {
    const unit = units.get(name) ?? "1";
    const value = run.metrics[name];
    return h("div", {}, h("dd", {}, numberText(value, 3) + (unit === "1" || typeof value !== "number" ? "" : `\u202f${unit}`)), h("dt", {}, label));
  }));
}

// The passes over strokes, in the order of time; then what was left out or lacks ink.
// A stroke as it was drawn in a pass.
interface DrawnStroke {
  stroke: number;
  pass: number;
  begin: number;
  end: number;
  ink: number; // [m]; NaN: none
  error: number; // the largest [mm]
  force: number; // median [N]
}

function drawnStrokes(run: Run): DrawnStroke[] {
  const { ink } = run;
  const of = (name: string) => ink.colours.find((c) => c.name === name)?.values ?? new Float64Array(ink.time.length).fill(NaN);
  const [errors, forces] = [of("error"), of("force")];
  const passes = new Map<number, number>();
  return run.spans.map(([stroke, begin, end]) => {
    const pass = (passes.get(stroke) ?? 0) + 1;
    passes.set(stroke, pass);
    const error: number[] = [], force: number[] = [];
    let length = 0;
    for (let i = 0; i < ink.time.length; ++i) {
      if (ink.time[i] < begin || ink.time[i] > end) continue;
      error.push(errors[i]);
      force.push(forces[i]);
      const next = ink.time[i + 1] - ink.time[i];
      if (next > 0 && (next < 0.05 || run.kind === "plan") && ink.time[i + 1] <= end)
        length += Math.hypot(...[0, 1, 2].map((k) => ink.points[k][i + 1] - ink.points[k][i]));
    }
    return { stroke, pass, begin, end, ink: error.length ? length : NaN, error: quantile(error, 1), force: quantile(force, 0.5) };
  });
}

function strokeButton(of: { stroke: number; pass: number; begin: number }, go: (t: number) => void): HTMLElement {
  const button = h("button", { type: "button", class: "small" }, `${of.stroke}${of.pass > 1 ? `, pass ${of.pass}` : ""}`);
  button.setAttribute("aria-label", `go to stroke ${of.stroke}, pass ${of.pass}`);
  button.addEventListener("click", () => go(of.begin));
  return button;
}

const inkText = (ink: number) => (Number.isFinite(ink) ? (1e3 * ink).toFixed(1) : "no ink");
const forceText = (force: number) => (Number.isFinite(force) ? force.toFixed(2) : "–");

// The strokes of runs side by side; the button goes to when the first of them draws it.
export function strokeComparison(runs: Run[], go: (t: number) => void): HTMLElement {
  const keyOf = (s: DrawnStroke) => `${s.stroke}/${s.pass}`;
  const of = runs.map((run) => new Map(drawnStrokes(run).map((s) => [keyOf(s), s])));
  const all = new Map(of.flatMap((strokes) => [...strokes]).reverse());
  const rows = [...all.values()].sort((a, b) => a.begin - b.begin || a.stroke - b.stroke);
  const columns: [string, (s: DrawnStroke) => string][] = [
    ["ink [mm]", (s) => inkText(s.ink)], ["worst error [mm]", (s) => numberText(s.error, 3)], ["force, median [N]", (s) => forceText(s.force)],
  ];
  const head = h("thead", {},
    h("tr", {}, h("th", {}), ...columns.map(([title]) => h("th", { class: "n", colspan: runs.length, scope: "colgroup" }, title))),
    h("tr", {}, h("th", {}, "stroke"), ...columns.flatMap(() => runs.map((run) => h("th", { class: "n" }, run.name)))));
  return h("div", { class: "scroll" }, h("table", { class: "strokes" }, head, h("tbody", {}, ...rows.map((row) =>
    h("tr", { "data-begin": row.begin, "data-end": row.end }, h("td", {}, strokeButton(row, go)),
      ...columns.flatMap(([, text]) => of.map((strokes) => {
        const s = strokes.get(keyOf(row));
        return h("td", { class: "n" }, s ? text(s) : "–");
      })))))));
}

export function strokes(run: Run, go: (t: number) => void, look: (p: number[], part: Part) => void): HTMLElement {
  const rows = drawnStrokes(run).map((s) => h("tr", { "data-begin": s.begin, "data-end": s.end },
    h("td", {}, strokeButton(s, go)), h("td", { class: "n" }, timeText(s.begin)), h("td", { class: "n" }, timeText(s.end - s.begin)),
    h("td", { class: "n" }, inkText(s.ink)), h("td", { class: "n" }, numberText(s.error, 3)), h("td", { class: "n" }, forceText(s.force))));
  const box = h("div", {});
  box.append(h("div", { class: "scroll" }, h("table", { class: "strokes" }, h("thead", {}, h("tr", {},
    h("th", {}, "stroke"), ...["from", "for", "ink [mm]", "worst error [mm]", "force, median [N]"].map((x) => h("th", { class: "n" }, x)))),
    h("tbody", {}, ...rows))));
  const parts = (title: string, list: Part[] | undefined) => {
    if (!list?.length) return;
    box.append(h("h3", {}, title), h("div", { class: "scroll" }, h("table", {}, h("tbody", {}, ...list.map((part) => {
      const span = `${numberText(part.from_mm, 3)} to ${numberText(part.to_mm, 3)} mm`;
      const cell = h("td", {});
      if (part.world_m) {
        const button = h("button", { type: "button", class: "small" }, "show");
        const place = part.world_m;
        button.addEventListener("click", () => look(place, part));
        cell.append(button);
      }
      return h("tr", {}, h("td", {}, `stroke ${part.stroke}`), h("td", {}, span), h("td", {}, part.text ?? part.problem ?? ""), cell);
    })))));
  };
  parts("Left out, because it cannot be drawn", run.strokes.not_drawable);
  parts("Drawn again", run.strokes.drawn_again);
  parts("Without ink", run.strokes.lacking);
  return box;
}

export function settings(run: Run): HTMLElement {
  const search = h("input", { type: "search", placeholder: "search settings", "aria-label": "search settings" });
  const changed = h("input", { type: "checkbox" });
  const body = h("tbody", {});
  const count = h("span", { class: "hint", role: "status" });
  const rows = run.settings.map(([name, value, initial, unit, help]) => {
    const differs = value !== initial;
    const row = h("tr", { class: differs ? "changed" : "" },
      h("td", {}, h("code", {}, name), h("div", { class: "why" }, help)),
      h("td", { class: "n" }, [value || "–", value === "none" ? "" : unit].filter(Boolean).join("\u202f"),
        differs ? h("div", { class: "why" }, `default ${initial || "none"}`) : null));
    return { row, differs, text: `${name} ${value} ${help}`.toLowerCase() };
  });
  body.append(...rows.map((r) => r.row));
  const filter = () => {
    const words = search.value.toLowerCase().split(/\s+/);
    let shown = 0;
    for (const r of rows) {
      r.row.hidden = (changed.checked && !r.differs) || !words.every((w) => r.text.includes(w));
      if (!r.row.hidden) ++shown;
    }
    count.textContent = `${shown} of ${rows.length}`;
  };
  search.addEventListener("input", filter);
  changed.addEventListener("change", filter);
  filter();
  const box = h("div", {});
  if (rows.length)
    box.append(h("div", { class: "bar" }, search, h("label", {}, changed, " changed only"), count),
      h("div", { class: "scroll" }, h("table", { class: "settings" }, body)));
  if (run.scenario) box.append(h("details", {}, h("summary", {}, "scenario.yaml"), h("pre", {}, run.scenario)));
  if (!rows.length && !run.scenario) box.append(h("p", { class: "hint" }, "The run's settings are not known."));
  return box;
}

// How the run ended; empty: not known.
export function endText(run: Run): string {
  const ending = run.metrics?.ending as { end: string; cause: string; incident?: string } | undefined;
  if (!ending || ending.end === "unknown") return "";
  const words = ({ stopped: "halted", interrupted: "stopped by a person" } as Record<string, string>)[ending.end] ?? ending.end.replaceAll("_", " ");
  return words + (ending.cause ? `: ${ending.cause}` : "") + (ending.incident ? ` (${ending.incident})` : "");
}

// What was drawn, in one line; empty: not known.
export function drawnText(run: Run): string {
  const { drawn, length_asked: asked, not_drawn_mm: rest } = (run.metrics ?? {}) as { drawn?: number; length_asked?: number; not_drawn_mm?: Record<string, number> };
  if (typeof drawn !== "number" || typeof asked !== "number") return "";
  const length = (mm: number) => (mm < 1000 ? `${numberText(mm, 3)}\u202fmm` : `${numberText(mm / 1000, 3)}\u202fm`);
  const reasons = Object.entries(rest ?? {}).sort((a, b) => b[1] - a[1]).map(([why, mm]) => `${why === "off_canvas" ? "edge" : why.replaceAll("_", " ")} ${length(mm)}`);
  return `drew ${length(drawn * asked)} of ${length(asked)}, ${Math.floor(100 * drawn + 1e-9)} %${reasons.length ? `; the rest: ${reasons.join(", ")}` : ""}`;
}

export function about(run: Run): HTMLElement {
  const wall = (run.metrics.wall_seconds ?? {}) as Record<string, number | null>;
  const names: Record<string, string> = { start_up: "start-up", loop: "loop", writing: "rest of the log" };
  const times = Object.entries(names).filter(([key]) => typeof wall[key] === "number").map(([key, label]) => `${label} ${(wall[key] as number).toFixed(2)} s`);
  const list = h("dl", { class: "facts" });
  const add = (name: string, value: string) => value && list.append(h("dt", {}, name), h("dd", {}, value));
  add("ended", endText(run));
  if (run.kind !== "live") add("simulated", `${run.duration.toFixed(2)} s`);
  add("wall time", times.join(", "));
  add("impedraw", run.commit ? `${run.version}, commit ${run.commit}` : run.version);
  for (const [key, value] of Object.entries(run.attributes)) add(key, value);
  if (run.command) list.append(h("dt", {}, "again"), h("dd", {}, h("code", {}, run.command)));
  const shown = run.canvas.triangles.length / 3;
  if (shown < run.canvas.of)
    add("canvas shown with", `${shown} of ${run.canvas.of} triangles, off by at most ${run.canvas.error_mm.toFixed(2)} mm`);
  if (wantsCoarse() && (run.canvas.coarse || run.arm.some((link) => link.meshes.some((mesh) => mesh.coarse))))
    add("shapes", "coarser than in the file, as this browser draws without a graphics card");
  const points = run.cloud.points[0].length;
  if (points < run.cloud.of) add("cloud shown with", `${points} of ${run.cloud.of} points`);
  if (run.armNotice)
    list.append(h("dt", {}, "the arm's meshes"), h("dd", {}, h("details", {}, h("summary", {}, "copyright and licence"), h("pre", {}, run.armNotice))));
  return list;
}
