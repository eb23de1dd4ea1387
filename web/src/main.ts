// The page of a run: scene, time line, plots, numbers. Test hook: window.impedraw.
import { kinds, rampCss } from "./colours";
import { lastAt } from "./columns";
import { inflate, parse, type Run } from "./data";
import { h, numberText, save, timeText } from "./dom";
import { colourNames, hashOf, momentOf, viewNames, type Colour, type View } from "./link";
import { Plots } from "./plots";
import { Scene, targetColour } from "./scene";
import { about, numbers, settings, strokes, tiles } from "./tables";

const speeds = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100];
const colourLabels: Record<Colour, string> = {
  nothing: "nothing", force: "normal force", error: "ink error", tilt: "tilt", speed: "speed", pass: "pass",
};
const viewLabels: Record<View, string> = {
  free: "all", top: "top", front: "front", side: "side", pen: "along the pen", tip: "follow the tip",
};

function pictures(run: Run): HTMLElement {
  const box = h("div", { class: "pictures" });
  for (const picture of run.pictures) {
    const url = URL.createObjectURL(new Blob([picture.content], { type: picture.type }));
    box.append(h("figure", {}, h("img", { src: url, alt: picture.title }), h("figcaption", {}, picture.title)));
  }
  if (!run.pictures.length) box.append(h("p", { class: "hint" }, "The run has no pictures."));
  return box;
}

class Page {
  private t = 0;
  private begin: number;
  private end: number;
  private playing = false;
  private speed = 1;
  private view: View = "free";
  private colour: Colour = "force";
  private dirty = true;
  private lastFrame = 0;
  private scene: Scene | null = null;
  private plots: Plots;
  private play = h("button", { type: "button", class: "play", "aria-label": "play" }, "▶");
  private slider: HTMLInputElement;
  private clock = h("output", { class: "clock", "aria-live": "off" });
  private state = h("output", { class: "state" });
  private strip = h("canvas", { class: "strip", "aria-hidden": "true" });
  private speedChoice = h("select", { "aria-label": "speed of the replay" });
  private colourChoice = h("select", { "aria-label": "colour of the ink" });
  private legend = h("div", { class: "legend", role: "img" });
  private viewButtons = new Map<View, HTMLButtonElement>();
  private strokeRows: HTMLElement[] = [];
  readonly stage = h("div", { class: "stage" });

  constructor(readonly run: Run, root: HTMLElement) {
    const { time } = run.scene;
    this.begin = time[0] ?? 0;
    this.end = time.at(-1) ?? 0;
    this.t = this.end;
    this.slider = h("input", {
      type: "range", class: "slider", min: this.begin, max: Math.max(this.end, this.begin + 1e-3), step: 0.001,
      "aria-label": "time of the replay",
    });
    this.plots = new Plots(run, { seek: (t) => this.seek(t) });
    let refusal = "";
    try {
      this.scene = new Scene(run);
    } catch (error) {
      refusal = error instanceof Error ? error.message : String(error);
    }
    document.title = run.title;
    root.replaceChildren(this.header(), h("main", { class: "layout" }, this.stageWith(refusal), this.panel()));
    this.listen();
    this.applyTheme();
    const moment = momentOf(location.hash);
    this.setColour(moment.colour ?? "force");
    this.resize();
    this.setView(moment.view ?? "free");
    this.seek(moment.t ?? this.end);
    this.draw();
    requestAnimationFrame((now) => this.frame(now));
  }

  private header(): HTMLElement {
    const theme = h("button", { type: "button", class: "small", "aria-label": "light or dark" }, "◐");
    theme.addEventListener("click", () => {
      document.documentElement.dataset.theme = this.isDark() ? "light" : "dark";
      this.applyTheme();
    });
    const facts = [`${this.run.duration.toFixed(1)} s simulated`];
    if (this.run.attributes.seed) facts.push(`seed ${this.run.attributes.seed}`);
    facts.push(`${this.run.spans.length} stroke${this.run.spans.length === 1 ? "" : "s"}`);
    const box = h("header", { class: "top" }, h("h1", {}, this.run.title), h("p", {}, facts.join(" · ")), theme);
    const cut = !this.run.complete ? "cannot be read to its end"
      : !this.run.closed ? "ends before the run was closed" : "";
    const header = h("div", {}, box);
    if (cut) header.append(h("p", { class: "warning", role: "alert" }, `The log ${cut}: the run is shown up to ${timeText(this.end)}.`));
    return header;
  }

  private stageWith(refusal: string): HTMLElement {
    const { scene } = this;
    if (scene) {
      scene.canvas.setAttribute("role", "img");
      scene.canvas.setAttribute("aria-label", "3-D scene of the run; drag turns it, the wheel zooms, keys 1 to 5 choose a view");
      scene.canvas.tabIndex = 0;
      const views = h("div", { class: "views", role: "group", "aria-label": "view" });
      viewNames.forEach((name, key) => {
        const button = h("button", { type: "button", class: "small", title: `key ${key}`, "aria-pressed": "false" }, viewLabels[name]);
        button.addEventListener("click", () => this.setView(name));
        this.viewButtons.set(name, button);
        views.append(button);
      });
      this.stage.append(scene.canvas, views, this.legend, this.state, this.options(scene));
    } else {
      const note = h("p", { class: "warning", role: "alert" }, "This browser shows no 3-D scene (no WebGL): here are the flat pictures.");
      note.title = refusal;
      this.stage.classList.add("flat");
      this.stage.append(note, pictures(this.run));
    }
    for (const s of speeds) this.speedChoice.append(h("option", { value: s, selected: s === 1 }, `${s} ×`));
    for (const c of colourNames) this.colourChoice.append(h("option", { value: c }, colourLabels[c]));
    const colour = h("label", { class: "pick" }, h("span", {}, "Ink by "), this.colourChoice);
    const controls = h("div", { class: "controls" },
      h("div", { class: "line" }, this.slider, this.strip),
      h("div", { class: "bar" }, this.play, this.clock, this.speedChoice, colour));
    return h("section", { class: "replay", "aria-label": "replay" }, this.stage, controls);
  }

  private options(scene: Scene): HTMLElement {
    const opacity = h("input", { type: "range", min: 0, max: 1, step: 0.05, value: 1, "aria-label": "opacity of the canvas" });
    opacity.addEventListener("input", () => {
      scene.setOpacity(Number(opacity.value));
      this.dirty = true;
    });
    const box = h("details", { class: "options" }, h("summary", {}, "Show"), h("label", {}, "canvas ", opacity));
    for (const part of ["arm", "cloud", "target", "ink", "normal", "force", "cameras", "grid"] as const) {
      const tick = h("input", { type: "checkbox" });
      tick.checked = part !== "cloud";
      tick.addEventListener("change", () => {
        scene.setShown(part, tick.checked);
        this.dirty = true;
      });
      const mark = h("i");
      const colour = { normal: kinds[2], force: kinds[1], cloud: kinds[5], target: targetColour }[part as string];
      mark.style.setProperty("--key", colour ?? "transparent");
      box.append(h("label", {}, tick, ` ${part} `, colour ? mark : null));
    }
    const bare = h("i");
    bare.style.setProperty("--key", kinds[3]);
    box.append(h("label", {}, bare, "target without ink"));
    const still = h("button", { type: "button", class: "small" }, "save picture");
    still.addEventListener("click", async () => {
      const blob = await scene.still();
      if (blob) save("scene.png", blob);
    });
    const link = h("button", { type: "button", class: "small" }, "link to this moment");
    link.addEventListener("click", () => {
      history.replaceState(null, "", this.hash());
      void navigator.clipboard?.writeText(location.href).catch(() => {});
      link.textContent = "in the address line";
      setTimeout(() => (link.textContent = "link to this moment"), 2000);
    });
    box.append(still, link);
    return box;
  }

  private panel(): HTMLElement {
    const strokeList = strokes(this.run, (t) => this.seek(t), (p) => {
      this.scene?.lookAt(p);
      this.dirty = true;
    });
    this.strokeRows = [...strokeList.querySelectorAll<HTMLElement>("tr[data-begin]")];
    const pages: [string, HTMLElement][] = [
      ["Plots", this.plots.element], ["Numbers", h("div", {}, tiles(this.run), numbers(this.run), about(this.run))],
      ["Strokes", strokeList], ["Settings", settings(this.run)], ["Pictures", this.scene ? pictures(this.run) : h("p", { class: "hint" }, "The pictures stand in place of the scene.")],
    ];
    const list = h("div", { role: "tablist", "aria-label": "about the run" });
    const tabs = pages.map(([name, content], i) => {
      content.id = `panel-${i}`;
      content.setAttribute("role", "tabpanel");
      content.tabIndex = -1;
      const tab = h("button", { type: "button", role: "tab", id: `tab-${i}`, "aria-controls": content.id }, name);
      content.setAttribute("aria-labelledby", tab.id);
      list.append(tab);
      return tab;
    });
    const choose = (chosen: number) => tabs.forEach((tab, i) => {
      tab.setAttribute("aria-selected", String(i === chosen));
      tab.tabIndex = i === chosen ? 0 : -1;
      pages[i][1].hidden = i !== chosen;
    });
    tabs.forEach((tab, i) => {
      tab.addEventListener("click", () => choose(i));
      tab.addEventListener("keydown", (event) => {
        const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
        if (!step) return;
        event.stopPropagation();
        const next = (i + step + tabs.length) % tabs.length;
        choose(next);
        tabs[next].focus();
      });
    });
    choose(0);
    return h("section", { class: "panel-side", "aria-label": "plots and numbers" }, list, ...pages.map(([, content]) => content));
  }

  private listen(): void {
    const { scene } = this;
    this.play.addEventListener("click", () => this.setPlaying(!this.playing));
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    this.speedChoice.addEventListener("change", () => (this.speed = Number(this.speedChoice.value)));
    this.colourChoice.addEventListener("change", () => this.setColour(this.colourChoice.value as Colour));
    window.addEventListener("hashchange", () => {
      const moment = momentOf(location.hash);
      if (moment.colour) this.setColour(moment.colour);
      if (moment.view) this.setView(moment.view);
      if (moment.t !== undefined) this.seek(moment.t);
    });
    window.addEventListener("keydown", (event) => this.key(event));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.applyTheme());
    new ResizeObserver(() => this.resize()).observe(this.stage);
    if (!scene) return;
    scene.onChange = () => (this.dirty = true);
    scene.onFree = () => this.markView("free");
    let pressed = [0, 0];
    scene.canvas.addEventListener("pointerdown", (e) => (pressed = [e.offsetX, e.offsetY]));
    scene.canvas.addEventListener("click", (e) => {
      if (Math.hypot(e.offsetX - pressed[0], e.offsetY - pressed[1]) > 4) return;
      const t = scene.timeAt(e.offsetX, e.offsetY);
      if (t !== null) this.seek(t);
    });
  }

  private key(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (target.matches("input:not([type=range]):not([type=checkbox]), select, textarea")) return;
    const onSlider = target.matches("input[type=range]");
    const step = event.shiftKey ? 1 : 0.1;
    const actions: Record<string, () => void> = {
      " ": () => this.setPlaying(!this.playing),
      ArrowLeft: () => this.seek(this.t - step),
      ArrowRight: () => this.seek(this.t + step),
      Home: () => this.seek(this.begin),
      End: () => this.seek(this.end),
      "+": () => this.changeSpeed(1),
      "-": () => this.changeSpeed(-1),
      c: () => this.setColour(colourNames[(colourNames.indexOf(this.colour) + 1) % colourNames.length]),
    };
    viewNames.forEach((name, i) => (actions[String(i)] = () => this.setView(name)));
    if (onSlider && target !== this.slider && event.key.startsWith("Arrow")) return;
    if (event.key === " " && target.matches("button, summary, input[type=checkbox]")) return;
    const action = actions[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  }

  private changeSpeed(by: number): void {
    const at = Math.min(speeds.length - 1, Math.max(0, speeds.indexOf(this.speed) + by));
    this.speed = speeds[at];
    this.speedChoice.value = String(this.speed);
  }

  private isDark(): boolean {
    const { theme } = document.documentElement.dataset;
    return theme ? theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  }

  private applyTheme(): void {
    this.scene?.setDark(this.isDark());
    this.plots.restyle();
    this.dirty = true;
    this.drawStrip();
  }

  setPlaying(playing: boolean): void {
    this.playing = playing;
    if (playing && this.t >= this.end - 1e-6) this.seek(this.begin);
    this.play.textContent = playing ? "❚❚" : "▶";
    this.play.setAttribute("aria-label", playing ? "pause" : "play");
    this.lastFrame = performance.now();
  }

  setView(view: View): void {
    this.scene?.setView(view);
    this.markView(view);
    this.dirty = true;
  }

  private markView(view: View): void {
    this.view = view;
    for (const [name, button] of this.viewButtons) button.setAttribute("aria-pressed", String(name === view));
  }

  setColour(colour: Colour): void {
    this.colour = colour;
    this.colourChoice.value = colour;
    const legend = this.scene?.setColour(colour) ?? null;
    this.legend.replaceChildren();
    this.legend.hidden = !legend;
    if (legend) {
      const what = colourLabels[colour];
      this.legend.setAttribute("aria-label", `${what}: ${numberText(legend.low, 3)} to ${numberText(legend.high, 3)} ${legend.unit}`);
      if (legend.passes) {
        const marks = Array.from({ length: Math.min(legend.passes, kinds.length) }, (_, i) => {
          const mark = h("i");
          mark.style.setProperty("--key", kinds[i]);
          return h("span", {}, mark, `pass ${i + 1}`);
        });
        this.legend.append(...marks);
      } else {
        const bar = h("b");
        bar.style.background = rampCss();
        this.legend.append(h("span", {}, `${what} [${legend.unit}]`), bar,
          h("span", { class: "ends" }, h("span", {}, numberText(legend.low, 3)), h("span", {}, `≥ ${numberText(legend.high, 3)}`)));
      }
    }
    this.dirty = true;
  }

  seek(t: number): void {
    this.t = Math.min(this.end, Math.max(this.begin, t));
    this.slider.value = String(this.t);
    this.slider.setAttribute("aria-valuetext", timeText(this.t));
    this.clock.textContent = `${this.t.toFixed(2)} / ${this.end.toFixed(2)} s`;
    const row = Math.max(0, lastAt(this.run.scene.time, this.t));
    const { mode, stroke } = this.run.scene;
    const state = this.run.modes[mode[row]] ?? "";
    this.state.textContent = stroke[row] >= 0 ? `${state} · stroke ${stroke[row]}` : state;
    this.state.style.borderLeftColor = kinds[mode[row] % kinds.length] ?? "";
    for (const tr of this.strokeRows)
      tr.classList.toggle("now", this.t >= Number(tr.dataset.begin) && this.t <= Number(tr.dataset.end));
    this.scene?.seek(this.t);
    this.plots.seek(this.t);
    this.dirty = true;
  }

  private drawStrip(): void {
    const { strip } = this;
    const ratio = Math.min(devicePixelRatio, 2);
    strip.width = Math.max(1, strip.clientWidth * ratio);
    strip.height = Math.max(1, strip.clientHeight * ratio);
    const context = strip.getContext("2d");
    if (!context) return;
    const x = (t: number) => ((t - this.begin) / Math.max(this.end - this.begin, 1e-6)) * strip.width;
    const { time, mode } = this.run.scene;
    const half = strip.height / 2;
    for (let i = 0; i < time.length;) {
      let next = i + 1;
      while (next < time.length && mode[next] === mode[i]) ++next;
      context.fillStyle = kinds[mode[i] % kinds.length];
      context.globalAlpha = mode[i] === 0 ? 0.25 : 0.8;
      const end = next < time.length ? time[next] : this.end;
      context.fillRect(x(time[i]), half + ratio, Math.max(1, x(end) - x(time[i])), half - ratio);
      i = next;
    }
    context.globalAlpha = 1;
    context.fillStyle = getComputedStyle(document.documentElement).getPropertyValue("--accent");
    for (const [, begin, end] of this.run.spans) context.fillRect(x(begin), 0, Math.max(1, x(end) - x(begin) - 1), half);
  }

  private resize(): void {
    this.drawStrip();
    if (!this.scene) return;
    const { clientWidth, clientHeight } = this.stage;
    this.scene.resize(Math.max(1, clientWidth), Math.max(1, clientHeight));
    this.draw();
  }

  private draw(): void {
    this.scene?.render();
    this.dirty = false;
  }

  private frame(now: number): void {
    if (this.playing) {
      const t = this.t + this.speed * Math.min(0.25, (now - this.lastFrame) / 1000);
      this.seek(t);
      if (t >= this.end) this.setPlaying(false);
    }
    this.lastFrame = now;
    if (this.dirty) this.draw();
    requestAnimationFrame((next) => this.frame(next));
  }

  hash(): string {
    return hashOf({ t: this.t, view: this.view, colour: this.colour });
  }

  // What tests ask.
  hook() {
    const { scene } = this;
    return {
      seek: (t: number) => {
        this.seek(t);
        this.draw();
      },
      state: () => ({ t: this.t, playing: this.playing, speed: this.speed, view: this.view, colour: this.colour, end: this.end }),
      frames: () => scene?.frames() ?? {},
      project: (p: number[]) => scene?.project(p),
      setColour: (colour: Colour) => this.setColour(colour),
      setView: (view: View) => {
        this.setView(view);
        this.draw();
      },
      hide: (part: keyof Scene["parts"]) => {
        scene?.setShown(part, false);
        this.draw();
      },
      extremes: (name: string) => this.plots.extremes(name),
      hash: () => this.hash(),
      // The colours within `reach` pixels of where points of W stand in the picture.
      coloursAround: async (points: number[][], reach: number) => {
        const blob = await scene?.still();
        if (!scene || !blob) return [];
        const image = await createImageBitmap(blob);
        const context = h("canvas", { width: image.width, height: image.height }).getContext("2d", { willReadFrequently: true });
        if (!context) return [];
        context.drawImage(image, 0, 0);
        const ratio = image.width / scene.canvas.clientWidth;
        return points.map((p) => {
          const [x, y] = scene.project(p).map((u) => Math.round(u * ratio));
          const { data } = context.getImageData(x - reach, y - reach, 2 * reach + 1, 2 * reach + 1);
          return Array.from({ length: data.length / 4 }, (_, i) => [...data.slice(4 * i, 4 * i + 3)]);
        });
      },
      framesPerSecond: async (seconds: number) => {
        const begin = performance.now();
        let frames = 0;
        while (performance.now() - begin < 1000 * seconds) {
          this.seek(this.begin + ((this.end - this.begin) * (performance.now() - begin)) / (1000 * seconds));
          this.draw();
          ++frames;
          await new Promise(requestAnimationFrame);
        }
        return frames / seconds;
      },
    };
  }
}

async function start(): Promise<ReturnType<Page["hook"]>> {
  const root = document.getElementById("page") as HTMLElement;
  try {
    const data = document.getElementById("data") as HTMLElement;
    const run = parse(await inflate(data.textContent ?? ""));
    data.remove();
    return new Page(run, root).hook();
  } catch (error) {
    root.replaceChildren(h("p", { class: "warning", role: "alert" },
      `This page cannot be shown here: ${error instanceof Error ? error.message : String(error)}. The pictures and metrics.json stand beside it.`));
    throw error;
  }
}

declare global {
  interface Window {
    impedraw: Promise<ReturnType<Page["hook"]>>;
  }
}
window.impedraw = start();
