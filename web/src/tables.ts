// Numbers, strokes and settings.
import { quantile } from "./colours";
import type { Limit, Part, Run } from "./data";
import { h, numberText, timeText } from "./dom";

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
    limited ? h("th", { class: "n" }, "limit") : null, h("th", {}, "meaning"));
  const rows = run.definitions.map((d) => {
    const value = run.metrics[d.name];
    const limit = run.limits[d.name];
    const met = !limit || holds(value, limit);
    const judged = limit ? (met ? "ok" : "bad") : "";
    const meaning = h("td", {}, d.meaning);
    if (reasons[d.name]) meaning.append(h("span", { class: "why" }, ` (none: ${reasons[d.name]})`));
    return h("tr", {}, h("td", {}, h("code", {}, d.name)),
      h("td", { class: `n ${judged}` }, numberText(value) + (limit && !met ? " ✗" : limit ? " ✓" : "")),
      h("td", {}, d.unit === "1" ? "" : d.unit),
      limited ? h("td", { class: "n" }, limit ? limitText(limit) : "") : null, meaning);
  });
  return h("div", { class: "scroll" }, h("table", {}, h("thead", {}, head), h("tbody", {}, ...rows)));
}

export const tileNames: [string, string][] = [
  ["ink_error_rms", "ink error, RMS"], ["coverage", "of the target covered"], ["contact_fraction", "contact fraction"],
  ["force_mean", "normal force, mean"], ["force_sd", "its standard deviation"], ["tilt_mean", "tilt, mean"],
];

export function tiles(run: Run): HTMLElement {
  const units = new Map(run.definitions.map((d) => [d.name, d.unit]));
  return h("dl", { class: "tiles" }, ...tileNames.map(([name, label]) => {
    const unit = units.get(name) ?? "1";
    const value = run.metrics[name];
    return h("div", {}, h("dd", {}, numberText(value, 3) + (unit === "1" || typeof value !== "number" ? "" : `\u202f${unit}`)), h("dt", {}, label));
  }));
}

// The passes over strokes, in the order of time; then what was left out or lacks ink.
export function strokes(run: Run, go: (t: number) => void, look: (p: number[], part: Part) => void): HTMLElement {
  const { ink } = run;
  const passes = new Map<number, number>();
  const rows = run.spans.map(([stroke, begin, end]) => {
    const pass = (passes.get(stroke) ?? 0) + 1;
    passes.set(stroke, pass);
    const error: number[] = [], force: number[] = [];
    let length = 0;
    for (let i = 0; i < ink.time.length; ++i) {
      if (ink.time[i] < begin || ink.time[i] > end) continue;
      error.push(ink.error[i]);
      force.push(ink.force[i]);
      const next = ink.time[i + 1] - ink.time[i];
      if (next > 0 && next < 0.05)
        length += Math.hypot(...[0, 1, 2].map((k) => ink.points[k][i + 1] - ink.points[k][i]));
    }
    const button = h("button", { type: "button", class: "small" }, `${stroke}${pass > 1 ? `, pass ${pass}` : ""}`);
    button.setAttribute("aria-label", `go to stroke ${stroke}, pass ${pass}`);
    button.addEventListener("click", () => go(begin));
    const row = h("tr", { "data-begin": begin, "data-end": end },
      h("td", {}, button), h("td", { class: "n" }, timeText(begin)), h("td", { class: "n" }, timeText(end - begin)),
      h("td", { class: "n" }, error.length ? (1e3 * length).toFixed(1) : "no ink"), h("td", { class: "n" }, numberText(quantile(error, 1), 3)),
      h("td", { class: "n" }, numberText(quantile(force, 0.5), 3)));
    return row;
  });
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

export function about(run: Run): HTMLElement {
  const wall = (run.metrics.wall_seconds ?? {}) as Record<string, number | null>;
  const names: Record<string, string> = { start_up: "start-up", loop: "loop", writing: "rest of the log" };
  const times = Object.entries(names).filter(([key]) => typeof wall[key] === "number").map(([key, label]) => `${label} ${(wall[key] as number).toFixed(2)} s`);
  const list = h("dl", { class: "facts" });
  const add = (name: string, value: string) => value && list.append(h("dt", {}, name), h("dd", {}, value));
  add("simulated", `${run.duration.toFixed(2)} s`);
  add("wall time", times.join(", "));
  add("impedraw", run.version);
  for (const [key, value] of Object.entries(run.attributes)) add(key, value);
  if (run.command) list.append(h("dt", {}, "again"), h("dd", {}, h("code", {}, run.command)));
  const shown = run.canvas.triangles.length / 3;
  if (shown < run.canvas.of)
    add("canvas shown with", `${shown} of ${run.canvas.of} triangles, off by at most ${run.canvas.error_mm.toFixed(2)} mm`);
  const points = run.cloud.points[0].length;
  if (points < run.cloud.of) add("cloud shown with", `${points} of ${run.cloud.of} points`);
  return list;
}
