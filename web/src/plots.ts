// Plots over time, linked: one cursor, one range of time, and the instant that the scene shows.
import uPlot from "uplot";
import { kinds, quantile, runColour } from "./colours";
import type { Run, Series } from "./data";
import { h, save } from "./dom";
import { Pyramid } from "./pyramid";
import { withPlainCanvases } from "./software";

interface Curve {
  series: Series;
  label: string;
  colour: string;
  scale?: (v: number) => number;
  dash?: number[];
  steps?: boolean;
}

interface Panel {
  title: string;
  unit: string;
  curves: () => Curve[];
  limits?: () => (number | null)[]; // drawn as lines
  fromZero?: boolean;
  words?: string[]; // names of the values 0, 1, 2, …
  joint?: boolean; // has curves of the chosen joint
}

interface Made {
  panel: Panel;
  chart: uPlot;
  now: HTMLElement;
  body: HTMLElement;
  values: HTMLElement;
  curves: Curve[];
}

const heightOf = (panel: Panel) => (panel.words ? 110 : 132); // [px]

export interface PlotsHooks {
  seek(t: number): void;
}

export class Plots {
  readonly element = h("div", { class: "plots" });
  private range: [number, number];
  private made: Made[] = [];
  private pending = new Map<Element, () => void>();
  private pyramids = new Map<Series, Pyramid>();
  private shownEnd = 0; // of a run that goes on
  private joint: number; // −1: all
  private t = 0;
  private run: Run;

  // Of several runs, each is a curve of each plot.
  constructor(private runs: Run[], private hooks: PlotsHooks) {
    this.run = runs[0];
    this.joint = runs.length > 1 ? 0 : -1;
    this.range = this.wholeRange();
    this.shownEnd = this.range[1];
    const watch = new IntersectionObserver((entries) => {
      for (const entry of entries) {
        if (!entry.isIntersecting) continue;
        watch.unobserve(entry.target);
        const make = this.pending.get(entry.target);
        this.pending.delete(entry.target);
        make?.();
      }
    }, { rootMargin: "200px" });
    const bar = h("div", { class: "bar" });
    const whole = h("button", { type: "button", class: "small" }, this.run.kind === "plan" ? "whole path" : "whole run");
    whole.addEventListener("click", () => this.zoom(...this.wholeRange()));
    bar.append(h("span", { class: "hint" }, "Drag to zoom in time, click to go there."), whole);
    this.element.append(bar);
    for (const panel of this.panels()) {
      if (panel.joint && panel.title === "joint position") this.element.append(this.jointChoice());
      this.add(panel, watch);
    }
    const steps = this.stepTimes();
    if (steps) this.element.append(steps);
    new ResizeObserver(() => {
      for (const { chart, body } of this.made)
        if (body.clientWidth > 0 && body.clientWidth !== chart.width)
          chart.setSize({ width: body.clientWidth, height: chart.height });
    }).observe(this.element);
  }

  private wholeRange(): [number, number] {
    const begin = Math.min(...this.runs.map((run) => run.scene.time[0] ?? 0));
    return [begin, Math.max(begin + 1e-3, ...this.runs.map((run) => run.scene.time.at(-1) ?? 0))];
  }

  private curve(name: string, label: string, k: number, more: Partial<Curve> = {}): Curve[] {
    const several = this.runs.length > 1;
    return this.runs.flatMap((run, r) => {
      const series = run.series.get(name);
      if (!series || !(run.kind === "live" || series.low.some(Number.isFinite))) return [];
      // Of what is asked for, one curve tells enough.
      if (several && more.dash && r > 0) return [];
      if (!several) return [{ series, label, colour: kinds[k % kinds.length], ...more }];
      return [{ series, label: more.dash ? label : run.name, colour: more.dash ? kinds[7] : runColour(r), ...more }];
    });
  }

  private panels(): Panel[] {
    const { joints } = this.run;
    const ofJoints = (kind: string, share: (j: number) => (v: number) => number) => () =>
      joints.names.flatMap((name, j) =>
        this.joint < 0 ? this.curve(`${kind}_${j}`, name, j, { scale: share(j) })
          : this.joint === j ? this.curve(`${kind}_${j}`, name, j) : []);
    const inRange = (j: number) => (v: number) => {
      const low = joints.lower[j], high = joints.upper[j];
      return low === null || high === null ? NaN : (200 * (v - low)) / (high - low) - 100;
    };
    const of = (limits: (number | null)[]) => (j: number) => (v: number) => (limits[j] === null ? NaN : (100 * v) / (limits[j] as number));
    const unit = (raw: string) => raw;
    const panels: Panel[] = [
      { title: "normal force", unit: "N", fromZero: true,
        curves: () => [...this.curve("force", "force", 0), ...this.curve("push", "asked for", 1, { dash: [5, 3] })] },
      { title: "ink error", unit: "mm", fromZero: true, curves: () => this.curve("ink_error", "to the target", 0) },
      { title: "tilt", unit: "deg", fromZero: true,
        curves: () => [...this.curve("tilt", "pen against true normal", 0),
          ...(this.runs.length > 1 || this.run.kind === "plan" ? [] : this.curve("normal_error", "estimated normal", 1))] },
      { title: this.run.kind === "plan" ? "speed of the tip" : "speed of the contact point", unit: "mm/s", fromZero: true, curves: () => this.curve("speed", "speed", 0) },
      { title: "distance to the nearest joint limit", unit: "rad", fromZero: true, curves: () => this.curve("joint_margin", "distance", 0) },
      { title: "arm to canvas or table, at most 30 mm", unit: "mm", curves: () => this.curve("clearance", "clearance", 0) },
      { title: "the tip's greatest effective mass", unit: "kg", fromZero: true, curves: () => this.curve("effective_mass", "mass", 0) },
      ...(this.run.kind === "plan" ? [{ title: "expected error of the seen normal", unit: "deg", fromZero: true,
        curves: () => this.curve("normal_error", "error", 0) }] : []),
      { title: this.run.kind === "plan" ? "phase" : "contact state", unit: "", words: this.run.modes, curves: () => this.curve("mode", "state", 0, { steps: true }) },
      { title: "perception: tip to estimated surface", unit: "mm", curves: () => this.curve("surface_distance", "distance", 2) },
      { title: "largest joint torque", unit: "% of its limit", fromZero: true, curves: () => this.curve("torque", "torque", 0) },
    ];
    // Of several runs one coordinate would be enough for nobody: their error tells more.
    const canvas = this.runs.length > 1 ? [] : ["x", "y", "z"];
    panels.push(
      { title: "canvas: motion of its centre", unit: "mm",
        curves: () => canvas.flatMap((axis, k) => [...this.curve(`canvas_${axis}`, axis, k), ...this.curve(`estimated_canvas_${axis}`, `${axis}, estimated`, k, { dash: [5, 3] })]) },
      { title: "canvas: turn", unit: "deg", fromZero: true,
        curves: () => (canvas.length ? [...this.curve("canvas_turn", "true", 0), ...this.curve("estimated_canvas_turn", "estimated", 1, { dash: [5, 3] })] : []) },
      { title: "canvas: error of its estimated place, at the tip", unit: "mm", fromZero: true, curves: () => this.curve("canvas_error", "error", 0) });
    const clock = this.run.series.get("time_scale");
    if (clock && (this.run.kind === "live" || quantile(clock.low, 0) < 0.999))
      panels.push({ title: "speed of the plan's clock", unit: "1 = as planned", fromZero: true, curves: () => this.curve("time_scale", "clock", 0) });
    const both = (x: number | null) => (x === null ? [null] : [-x, x]);
    panels.push(
      { title: "joint position", unit: unit("rad"), joint: true, curves: ofJoints("position", inRange),
        limits: () => (this.joint < 0 ? [-100, 100] : [joints.lower[this.joint], joints.upper[this.joint]]) },
      { title: "joint speed", unit: unit("rad/s"), joint: true, curves: ofJoints("velocity", of(joints.speed)),
        limits: () => (this.joint < 0 ? [] : both(joints.speed[this.joint] ?? null)) },
      { title: "joint torque", unit: unit("Nm"), joint: true, curves: ofJoints("torque", of(joints.torque)),
        limits: () => (this.joint < 0 ? [] : both(joints.torque[this.joint] ?? null)) },
      // Of several runs, each term is a plot; of one, they share it.
      ...(this.runs.length > 1 ? this.run.terms : []).map((term) => ({ title: `torque term: ${term.replaceAll("_", " ")}`, unit: unit("Nm"), joint: true,
        curves: () => this.curve(`${term}_${this.joint}`, term, 0) })),
      { title: "torque terms", unit: "Nm", joint: true,
        curves: () => (this.runs.length > 1 ? [] : this.run.terms).flatMap((term, k) => this.curve(`${term}_${Math.max(0, this.joint)}`, term.replaceAll("_", " "), k)) },
    );
    return panels;
  }

  private jointChoice(): HTMLElement {
    const choice = h("select", { "aria-label": "joint" });
    if (this.runs.length === 1) choice.append(h("option", { value: "-1" }, "all, as share of their limits"));
    this.run.joints.names.forEach((name, j) => choice.append(h("option", { value: j }, name)));
    choice.addEventListener("change", () => {
      this.joint = Number(choice.value);
      for (const made of this.made) if (made.panel.joint) this.remake(made);
    });
    return h("label", { class: "bar" }, "Joints: ", choice);
  }

  private titleOf(panel: Panel): string {
    if (panel.title === "torque terms") return `torque terms of ${this.run.joints.names[Math.max(0, this.joint)] ?? ""} [Nm]`;
    const unit = panel.joint && this.joint < 0 ? (panel.title === "joint position" ? "% of its range" : "% of its limit") : panel.unit;
    return unit ? `${panel.title} [${unit}]` : panel.title;
  }

  private add(panel: Panel, watch: IntersectionObserver): void {
    const curves = panel.curves();
    if (curves.length === 0) return;
    const title = h("h3", {}, this.titleOf(panel));
    const body = h("div"), values = h("div", { class: "values", "aria-hidden": "true" });
    const csv = h("button", { type: "button", class: "small", "aria-label": `${panel.title}: save as CSV` }, "CSV");
    const png = h("button", { type: "button", class: "small", "aria-label": `${panel.title}: save as PNG` }, "PNG");
    csv.addEventListener("click", () => this.saveCsv(panel));
    png.addEventListener("click", () => this.savePng(panel));
    const figure = h("section", { class: "panel", "aria-label": panel.title }, h("header", {}, title, h("span", { class: "tools" }, csv, png)), h("div", { class: "plot" }, body, values));
    this.element.append(figure);
    // A plot that is made when it comes into sight moves nothing: what is clicked stays under the mouse.
    body.style.minHeight = `${heightOf(panel)}px`;
    this.legend(values, curves);
    this.pending.set(figure, () => this.make(panel, body, values));
    watch.observe(figure);
  }

  private make(panel: Panel, body: HTMLElement, values: HTMLElement): void {
    const style = getComputedStyle(document.documentElement);
    const text = style.getPropertyValue("--soft").trim();
    const grid = style.getPropertyValue("--line").trim();
    const shade = style.getPropertyValue("--stroke-shade").trim();
    const curves = panel.curves();
    const heading = body.closest(".panel")?.querySelector("h3");
    if (heading) heading.textContent = this.titleOf(panel);
    const series: uPlot.Series[] = [{}];
    const bands: uPlot.Band[] = [];
    curves.forEach((curve, k) => {
      const paths = curve.steps && this.runs.length === 1 ? uPlot.paths.stepped?.({ align: 1 }) : undefined;
      const one = { stroke: curve.colour, width: 1.2, dash: curve.dash, points: { show: false }, paths, spanGaps: false };
      series.push({ ...one, label: curve.label }, { ...one, label: `${curve.label}, largest` });
      bands.push({ series: [2 * k + 2, 2 * k + 1], fill: `${curve.colour}40` });
    });
    const axis = { stroke: text, font: "11px system-ui, sans-serif", grid: { stroke: grid, width: 1 }, ticks: { show: false } };
    const words = panel.words;
    const now = h("div", { class: "instant" });
    const chart = withPlainCanvases(() => new uPlot({
      width: Math.max(200, body.clientWidth), height: heightOf(panel), padding: [6, 8, 0, 0],
      legend: { show: false }, series, bands,
      cursor: {
        sync: { key: "time", setSeries: false }, points: { show: false }, y: false,
        drag: { x: true, y: false, setScale: false },
      },
      scales: {
        x: { time: false, range: () => this.range },
        y: {
          range: (_, low, high) => {
            if (words) return [-0.4, words.length - 0.6];
            const limits = (panel.limits?.() ?? []).filter((x): x is number => x !== null && Number.isFinite(x));
            const a = Math.min(panel.fromZero ? 0 : Infinity, low ?? 0, ...limits);
            const b = Math.max(high ?? 1, ...limits);
            const room = 0.06 * Math.max(b - a, 1e-6);
            return [panel.fromZero && a === 0 ? 0 : a - room, b + room];
          },
        },
      },
      axes: [
        { ...axis, size: 20, space: 60 },
        words
          ? { ...axis, size: 66, splits: () => words.map((_, i) => i), values: () => words, gap: 4 }
          : { ...axis, size: 46, space: 28, gap: 4 },
      ],
      hooks: {
        drawClear: [(u) => {
          u.ctx.fillStyle = shade;
          for (const [, begin, end] of this.runs.length > 1 ? [] : this.run.spans) {
            const left = Math.max(u.valToPos(begin, "x", true), u.bbox.left);
            const right = Math.min(u.valToPos(end, "x", true), u.bbox.left + u.bbox.width);
            if (right > left) u.ctx.fillRect(left, u.bbox.top, right - left, u.bbox.height);
          }
          u.ctx.strokeStyle = kinds[1];
          u.ctx.setLineDash([2, 4]);
          for (const limit of panel.limits?.() ?? []) {
            if (limit === null) continue;
            const y = u.valToPos(limit, "y", true);
            u.ctx.beginPath();
            u.ctx.moveTo(u.bbox.left, y);
            u.ctx.lineTo(u.bbox.left + u.bbox.width, y);
            u.ctx.stroke();
          }
          u.ctx.setLineDash([]);
        }],
        draw: [(u) => this.place(u, now)],
        setSelect: [(u) => {
          if (u.select.width > 4)
            this.zoom(u.posToVal(u.select.left, "x"), u.posToVal(u.select.left + u.select.width, "x"));
          u.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
        }],
        setCursor: [(u) => this.showValues(values, curves, u, words)],
      },
    }, this.data(curves, body.clientWidth), body));
    chart.over.append(now);
    this.legend(values, curves);
    chart.over.addEventListener("click", (event) => {
      const left = event.clientX - chart.over.getBoundingClientRect().left;
      if (!this.dragged(event)) this.hooks.seek(chart.posToVal(left, "x"));
    });
    chart.over.addEventListener("mousedown", (event) => (this.pressed = event.clientX));
    chart.over.addEventListener("dblclick", () => this.zoom(...this.wholeRange()));
    this.made.push({ panel, chart, now, body, values, curves });
  }

  private pressed = 0;
  private dragged(event: MouseEvent): boolean {
    return Math.abs(event.clientX - this.pressed) > 4;
  }

  private legend(values: HTMLElement, curves: Curve[], at: (c: Curve) => string = () => ""): void {
    values.replaceChildren(...curves.map((curve) => {
      const key = h("i", { class: curve.dash ? "dashed" : "" });
      key.style.setProperty("--key", curve.colour);
      return h("span", {}, key, `${curve.label} ${at(curve)}`);
    }));
  }

  private showValues(values: HTMLElement, curves: Curve[], u: uPlot, words?: string[]): void {
    const cursor = u.cursor.idx;
    if (cursor === null || cursor === undefined) return this.legend(values, curves);
    this.legend(values, curves, (curve) => {
      const k = curves.indexOf(curve);
      // Of several runs, each has times of its own.
      let index = cursor;
      while (index > 0 && u.data[2 * k + 1][index] === undefined) --index;
      const low = u.data[2 * k + 1][index], high = u.data[2 * k + 2][index];
      if (low === null || low === undefined || high === null || high === undefined) return "–";
      if (words) return words[high] ?? "";
      const text = (x: number) => x.toPrecision(3);
      return text(low) === text(high) ? text(low) : `${text(low)} … ${text(high)}`;
    });
  }

  private pyramid(series: Series): Pyramid {
    let pyramid = this.pyramids.get(series);
    if (!pyramid) this.pyramids.set(series, (pyramid = new Pyramid(series)));
    return pyramid;
  }

  private data(curves: Curve[], width: number): uPlot.AlignedData {
    if (curves.length === 0) return [[0], []] as unknown as uPlot.AlignedData;
    const scaled = (curve: Curve) => (v: number) => {
      const x = curve.scale ? curve.scale(v) : v;
      return Number.isFinite(x) ? x : null;
    };
    const tables = curves.map((curve) => {
      const level = this.pyramid(curve.series).at(this.range[0], this.range[1], Math.max(400, 1.5 * width));
      return [Array.from(level.time), Array.from(level.low, scaled(curve)), Array.from(level.high, scaled(curve))];
    });
    if (this.runs.length > 1) return uPlot.join(tables as uPlot.AlignedData[]);
    return [tables[0][0], ...tables.flatMap((table) => table.slice(1))] as uPlot.AlignedData;
  }

  zoom(begin: number, end: number): void {
    this.range = [begin, Math.max(end, begin + 2e-3)];
    for (const { chart, curves, body, now } of this.made) {
      chart.setData(this.data(curves, body.clientWidth));
      this.place(chart, now);
    }
  }

  private place(chart: uPlot, now: HTMLElement): void {
    const x = chart.valToPos(this.t, "x");
    now.hidden = this.t < this.range[0] || this.t > this.range[1];
    now.style.transform = `translateX(${x}px)`;
  }

  seek(t: number): void {
    this.t = t;
    for (const { chart, now } of this.made) this.place(chart, now);
  }

  // A run that goes on has more rows. Who has zoomed in keeps what is seen.
  grow(end: number): void {
    this.pyramids.clear();
    const follows = this.range[1] >= this.shownEnd - 1e-6;
    this.shownEnd = end;
    if (follows) this.zoom(this.range[0], end);
  }

  // Draws all anew in the page's colours.
  restyle(): void {
    for (const made of this.made) this.remake(made);
  }

  private remake(made: Made): void {
    made.chart.destroy();
    made.body.replaceChildren();
    this.made = this.made.filter((m) => m !== made);
    this.make(made.panel, made.body, made.values);
  }

  shownRange(): [number, number] {
    return this.range;
  }

  extremes(name: string): [number, number] | null {
    const series = this.run.series.get(name);
    return series ? this.pyramid(series).extremes() : null;
  }

  private saveCsv(panel: Panel): void {
    const curves = panel.curves();
    if (this.runs.length > 1) {
      const rows = ["\"curve\",\"time [s]\",\"least\",\"largest\""];
      for (const { label, series } of curves)
        series.time.forEach((t, i) => {
          if (t >= this.range[0] && t <= this.range[1] && Number.isFinite(series.low[i]))
            rows.push(`"${label.replaceAll('"', '""')}",${t.toFixed(3)},${Number(series.low[i].toPrecision(7))},${Number(series.high[i].toPrecision(7))}`);
        });
      return save(`${panel.title.replaceAll(/\W+/g, "-")}.csv`, new Blob([rows.join("\n") + "\n"], { type: "text/csv" }));
    }
    const lines = [["time [s]", ...curves.flatMap((c) => [`${c.label}, least`, `${c.label}, largest`])].map((x) => `"${x.replaceAll('"', '""')}"`).join(",")];
    const time = curves[0]?.series.time ?? [];
    for (let i = 0; i < time.length; ++i) {
      if (time[i] < this.range[0] || time[i] > this.range[1]) continue;
      const cells = curves.flatMap((c) => [c.series.low[i], c.series.high[i]].map((v) => (c.scale ? c.scale(v) : v)));
      lines.push([time[i].toFixed(3), ...cells.map((v) => (Number.isFinite(v) ? String(Number(v.toPrecision(7))) : ""))].join(","));
    }
    save(`${panel.title.replaceAll(/\W+/g, "-")}.csv`, new Blob([lines.join("\n") + "\n"], { type: "text/csv" }));
  }

  private savePng(panel: Panel): void {
    const made = this.made.find((m) => m.panel === panel);
    if (!made) return;
    const from = made.chart.ctx.canvas;
    const style = getComputedStyle(document.documentElement);
    const band = 22 * devicePixelRatio;
    const to = h("canvas", { width: from.width, height: from.height + band });
    const context = to.getContext("2d");
    if (!context) return;
    context.fillStyle = style.getPropertyValue("--back").trim();
    context.fillRect(0, 0, to.width, to.height);
    context.fillStyle = style.getPropertyValue("--text").trim();
    context.font = `${13 * devicePixelRatio}px system-ui, sans-serif`;
    context.fillText(this.titleOf(panel), 6 * devicePixelRatio, 16 * devicePixelRatio);
    context.drawImage(from, 0, band);
    to.toBlob((blob) => blob && save(`${panel.title.replaceAll(/\W+/g, "-")}.png`, blob), "image/png");
  }

  // How long the controller's steps took; logarithmic.
  private stepTimes(): HTMLElement | null {
    const steps = this.run.stepTimes;
    if (!steps) return null;
    const bars = h("div", { class: "bars", role: "img", "aria-label": "histogram of the controller's step times" });
    const most = Math.log10(1 + Math.max(...steps.counts));
    steps.counts.forEach((count, i) => {
      const bar = h("span", { title: `${steps.edges[i].toFixed(1)} to ${steps.edges[i + 1].toFixed(1)} µs: ${count} steps` });
      bar.style.height = `${(100 * Math.log10(1 + count)) / most}%`;
      bars.append(bar);
    });
    const edge = (x: number) => `${x.toFixed(1)} µs`;
    return h("section", { class: "panel", "aria-label": "controller step" },
      h("header", {}, h("h3", {}, "steps of the controller by their wall time, logarithmic")), bars,
      h("p", { class: "ends" }, h("span", {}, edge(steps.edges[0])), h("span", {}, `${edge(steps.edges.at(-1) ?? 0)} and longer`)));
  }
}
