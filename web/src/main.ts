// The page of a run: scene, time line, plots, numbers. Test hook: window.impedraw.
import { bareColour, kinds, leftOutColour, onEither, problemKey, rampCss, runColour } from "./colours";
import { lastAt } from "./columns";
import { inflate, parse, type Finding, type Run } from "./data";
import { h, numberText, save, timeText } from "./dom";
import { colourNames, hashOf, momentOf, viewNames, type Colour, type View } from "./link";
import { LiveLink, LiveRun } from "./live";
import { Plots } from "./plots";
import { withPlainCanvases } from "./software";
import { Scene, targetColour, type Legend } from "./scene";
import { about, changedSettings, comparison, drawnText, endText, findings, liveTiles, numbers, planNumbers, settings, strokeComparison, strokes, tiles } from "./tables";

const speeds = [0.1, 0.25, 0.5, 1, 2, 5, 10, 20, 50, 100];
const viewLabels: Record<View, string> = {
  free: "all", top: "top", front: "front", side: "side", pen: "along the pen", tip: "follow the tip",
};

function pictures(runs: Run[]): HTMLElement {
  const box = h("div", { class: "pictures" });
  for (const run of runs) {
    for (const picture of run.pictures) {
      const title = runs.length > 1 ? `${run.name}: ${picture.title}` : picture.title;
      const url = URL.createObjectURL(new Blob([picture.content], { type: picture.type }));
      box.append(h("figure", {}, h("img", { src: url, alt: title }), h("figcaption", {}, title)));
    }
  }
  if (!box.hasChildNodes()) box.append(h("p", { class: "hint" }, "There are no pictures."));
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
  private drawn = 0; // pictures so far
  private told = 0; // [ms]
  private scenes: Scene[] = [];
  private over = false; // ink over ink
  private readonly run: Run; // the first
  private readonly isPlan: boolean;
  private panes: HTMLElement[] = [];
  private plots: Plots;
  private play = h("button", { type: "button", class: "play", "aria-label": "play" }, "▶");
  private slider: HTMLInputElement;
  private clock = h("output", { class: "clock", "aria-live": "off" });
  private state = h("output", { class: "state" });
  private strip = h("canvas", { class: "strip", "aria-hidden": "true" });
  private speedChoice = h("select", { "aria-label": "speed of the replay" });
  private colourChoice = h("select", { "aria-label": "colour of the ink" });
  private mapChoice = h("select", { "aria-label": "colour of the canvas" });
  private overTick = h("input", { type: "checkbox" });
  private legend = h("div", { class: "legend", role: "img" });
  private mapLegend = h("div", { class: "legend of-map", role: "img", "aria-label": "colours of the canvas" });
  private viewButtons = new Map<View, HTMLButtonElement>();
  private strokeRows: HTMLElement[] = [];
  private moving = false; // the page moves the cameras itself
  private gone = new AbortController(); // another page takes this one's place
  private follows = true; // the end of a run that goes on
  private inkShown = 0;
  private thinned = 0; // as the ink that is shown
  private refreshed = 0; // [ms]
  private coloured = 0; // [ms]
  private liveState = h("output", { class: "live-state", role: "status" });
  private livePause = h("button", { type: "button" }, "pause the run");
  private liveStop = h("button", { type: "button" }, "stop with a lift");
  private liveEmergency = h("button", { type: "button", class: "emergency", title: "damps the motion and ends the run where the pen is" }, "emergency stop");
  private liveFollow = h("button", { type: "button", "aria-pressed": "true" }, "follow the run");
  private liveNumbers = h("div", {});
  readonly stage = h("div", { class: "stage" });

  // `live`: of a run that goes on. `note`: said at the top.
  constructor(readonly runs: Run[], root: HTMLElement, private live: { run: LiveRun; link: LiveLink } | null = null, note = "") {
    const run = (this.run = runs[0]);
    this.isPlan = run.kind === "plan";
    this.begin = Math.min(...runs.map((r) => r.scene.time[0] ?? 0));
    this.end = Math.max(...runs.map((r) => r.scene.time.at(-1) ?? 0));
    this.t = this.end;
    this.slider = h("input", {
      type: "range", class: "slider", min: this.begin, max: Math.max(this.end, this.begin + 1e-3), step: 0.001,
      "aria-label": "time of the replay",
    });
    this.plots = new Plots(runs, { seek: (t) => this.goAway(t) });
    let refusal = "";
    try {
      this.scenes = runs.map((r, k) => new Scene(r, k === 0 ? runs.slice(1) : [], runs.length));
    } catch (error) {
      this.scenes = [];
      refusal = error instanceof Error ? error.message : String(error);
    }
    document.title = this.title();
    root.replaceChildren(this.header(note), h("main", { class: "layout" }, this.stageWith(refusal), this.panel()));
    this.listen();
    this.applyTheme();
    const moment = momentOf(location.hash);
    this.setColour(moment.colour ?? (this.isPlan ? "nothing" : "force"));
    this.setMap("");
    this.resize();
    this.setView(moment.view ?? "free");
    this.seek(moment.t ?? (this.isPlan ? this.begin : this.end));
    this.inkShown = run.ink.time.length;
    this.draw();
    requestAnimationFrame((now) => this.frame(now));
  }

  private title(): string {
    return this.runs.length > 1 ? `${this.run.title}: ${this.runs.map((r) => r.name).join(", ")}` : this.run.title;
  }

  private header(note: string): HTMLElement {
    const theme = h("button", { type: "button", class: "small", "aria-label": "light or dark" }, "◐");
    theme.addEventListener("click", () => {
      document.documentElement.dataset.theme = this.isDark() ? "light" : "dark";
      this.applyTheme();
    });
    const facts: string[] = [];
    if (this.live) {
      facts.push("live");
      if (this.run.attributes.seed) facts.push(`seed ${this.run.attributes.seed}`);
    } else if (this.isPlan) {
      facts.push("plan, nothing has moved", `${this.run.duration.toFixed(1)} s`, `${this.run.spans.length} part${this.run.spans.length === 1 ? "" : "s"} to draw`,
        this.run.findings.length ? `${this.run.findings.length} cannot be drawn` : "all can be drawn");
    } else if (this.runs.length > 1) {
      facts.push(`${this.runs.length} runs compared`);
    } else {
      facts.push(`${this.run.duration.toFixed(1)} s simulated`);
      if (this.run.attributes.seed) facts.push(`seed ${this.run.attributes.seed}`);
      facts.push(`${this.run.spans.length} stroke${this.run.spans.length === 1 ? "" : "s"}`);
    }
    const box = h("header", { class: "top" }, h("h1", {}, this.title()), h("p", {}, facts.join(" · ")), theme);
    const header = h("div", {}, box);
    if (note) header.append(h("p", { class: "note", role: "status" }, note));
    if (this.live) {
      const { link } = this.live;
      this.livePause.addEventListener("click", () => link.send(link.state === "paused" ? "resume" : "pause"));
      this.liveStop.addEventListener("click", () => link.send("stop"));
      this.liveEmergency.addEventListener("click", () => link.send("emergency"));
      this.liveFollow.addEventListener("click", () => this.setFollow(!this.follows));
      header.append(h("div", { class: "live", role: "group", "aria-label": "the run that goes on" },
        this.liveState, this.livePause, this.liveStop, this.liveEmergency, this.liveFollow));
    }
    for (const run of this.runs) {
      const cut = !run.complete ? "cannot be read to its end" : !run.closed ? "ends before the run was closed" : "";
      const whose = this.runs.length > 1 ? `The log of ${run.name}` : "The log";
      const ended = endText(run), drew = drawnText(run), of = this.runs.length > 1 ? `${run.name}: ` : "";
      if (ended && !ended.startsWith("finished")) header.append(h("p", { class: "warning ended", role: "alert" }, `${of}${ended}.`));
      if (drew) header.append(h("p", { class: "note drew" }, of + drew));
      if (cut) header.append(h("p", { class: "warning", role: "alert" }, `${whose} ${cut}: the run is shown up to ${timeText(run.scene.time.at(-1) ?? 0)}.`));
    }
    return header;
  }

  private stageWith(refusal: string): HTMLElement {
    if (this.scenes.length) {
      const views = h("div", { class: "views", role: "group", "aria-label": "view" });
      viewNames.forEach((name, key) => {
        const button = h("button", { type: "button", class: "small", title: `key ${key}`, "aria-pressed": "false" }, viewLabels[name]);
        button.addEventListener("click", () => this.setView(name));
        this.viewButtons.set(name, button);
        views.append(button);
      });
      this.scenes.forEach(({ canvas }, k) => {
        canvas.setAttribute("role", "img");
        canvas.setAttribute("aria-label", `3-D scene of ${this.runs.length > 1 ? this.runs[k].name : this.isPlan ? "the plan" : "the run"}; drag turns it, the wheel zooms, keys 1 to 5 choose a view`);
        canvas.tabIndex = 0;
        const pane = h("div", { class: "pane" }, canvas);
        if (this.runs.length > 1) {
          const name = h("span", { class: "name" }, this.runs[k].name);
          name.style.borderLeftColor = runColour(k);
          pane.append(name);
        }
        this.panes.push(pane);
      });
      this.stage.append(h("div", { class: "panes" }, ...this.panes), views,
        h("div", { class: "legends" }, this.mapLegend, this.legend), this.state, this.options());
    } else {
      const note = h("p", { class: "warning", role: "alert" }, "This browser shows no 3-D scene (no WebGL): here are the flat pictures.");
      note.title = refusal;
      this.stage.classList.add("flat");
      this.stage.append(note, pictures(this.runs));
    }
    for (const s of speeds) this.speedChoice.append(h("option", { value: s, selected: s === 1 }, `${s} ×`));
    for (const c of this.colours()) this.colourChoice.append(h("option", { value: c }, this.labelOf(c)));
    const colour = h("span", { class: "pick" }, h("label", {}, this.isPlan ? "Strokes by " : "Ink by ", this.colourChoice));
    if (this.run.maps.length) {
      this.mapChoice.append(h("option", { value: "" }, "nothing"), ...this.run.maps.map((m) => h("option", { value: m.name }, m.label)));
      colour.append(h("label", {}, "Canvas by ", this.mapChoice));
    }
    if (this.runs.length > 1) colour.append(h("label", {}, this.overTick, " ink over ink"));
    const controls = h("div", { class: "controls" },
      h("div", { class: "line" }, this.slider, this.strip),
      h("div", { class: "bar" }, this.play, this.clock, this.speedChoice, colour));
    return h("section", { class: "replay", "aria-label": "replay" }, this.stage, controls);
  }

  // What this page's ink can be coloured by.
  private colours(): Colour[] {
    const own = this.run.ink.colours.map((c) => c.name);
    return colourNames.filter((c) => c === "nothing" || own.includes(c) || (c === "pass" && !this.isPlan));
  }

  private labelOf(colour: Colour): string {
    return this.run.ink.colours.find((c) => c.name === colour)?.label ?? (this.isPlan && colour === "nothing" ? "what fails" : colour);
  }

  private options(): HTMLElement {
    const opacity = h("input", { type: "range", min: 0, max: 1, step: 0.05, value: 1, "aria-label": "opacity of the canvas" });
    opacity.addEventListener("input", () => {
      for (const scene of this.scenes) scene.setOpacity(Number(opacity.value));
      this.dirty = true;
    });
    const box = h("details", { class: "options" }, h("summary", {}, "Show"), h("label", {}, "canvas ", opacity));
    for (const part of ["arm", "cloud", "target", "ink", "normal", "force", "cameras", "grid"] as const) {
      if (this.isPlan && part === "force") continue;
      const label = this.isPlan ? ({ target: "what fails", ink: "strokes" } as Record<string, string>)[part] ?? part : part;
      const tick = h("input", { type: "checkbox" });
      tick.checked = part !== "cloud" || this.scenes.some((scene) => scene.parts.cloud.visible);
      tick.addEventListener("change", () => {
        for (const scene of this.scenes) scene.setShown(part, tick.checked);
        this.dirty = true;
      });
      const mark = h("i");
      const colour = { normal: kinds[2], force: kinds[1], cloud: kinds[5], target: this.isPlan ? undefined : targetColour }[part as string];
      mark.style.setProperty("--key", colour ?? "transparent");
      box.append(h("label", {}, tick, ` ${label} `, colour ? mark : null));
    }
    const keyed = (colour: string, text: string) => {
      const key = h("i");
      key.style.setProperty("--key", colour);
      box.append(h("label", {}, key, text));
    };
    if (!this.isPlan) keyed(bareColour, "target without ink");
    if (!this.isPlan && this.run.findings.length) keyed(onEither(leftOutColour), "left out: cannot be drawn");
    const still = h("button", { type: "button", class: "small" }, "save picture");
    still.addEventListener("click", async () => {
      for (const scene of this.over ? [this.scenes[0]] : this.scenes) {
        const blob = await scene.still();
        if (blob) save("scene.png", blob);
      }
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
    const flat = this.scenes.length > 0 ? pictures(this.runs) : h("p", { class: "hint" }, "The pictures stand in place of the scene.");
    const pages: [string, HTMLElement][] = [["Plots", this.plots.element]];
    if (this.runs.length > 1) {
      pages.unshift(["Differences", h("div", {}, comparison(this.runs), h("h3", {}, "Settings that differ"), changedSettings(this.runs))]);
      const strokeList = strokeComparison(this.runs, (t) => this.seek(t));
      this.strokeRows = [...strokeList.querySelectorAll<HTMLElement>("tr[data-begin]")];
      pages.push(["Strokes", strokeList]);
      pages.push(["Settings", h("div", {}, ...this.runs.map((run) => h("details", {}, h("summary", {}, run.name), about(run), settings(run))))]);
    } else if (this.isPlan) {
      pages.unshift(["What fails", findings(this.run, this.scenes[0]?.problems() ?? [...new Set(this.run.findings.map((f) => f.problem))].sort(), problemKey, (f) => this.goTo(f))]);
      pages.push(["Numbers", h("div", {}, planNumbers(this.run), about(this.run))], ["Settings", settings(this.run)]);
    } else {
      const strokeList = strokes(this.run, (t) => this.seek(t), (p) => {
        this.scenes[0]?.lookAt(p);
        this.dirty = true;
      });
      this.strokeRows = [...strokeList.querySelectorAll<HTMLElement>("tr[data-begin]")];
      pages.push(["Numbers", h("div", {}, tiles(this.run), numbers(this.run), about(this.run))],
        ["Strokes", strokeList], ["Settings", settings(this.run)]);
    }
    if (this.live) pages.splice(1, pages.length - 1, ["Numbers", h("div", {}, this.liveNumbers, about(this.run))], ["Settings", settings(this.run)]);
    else pages.push(["Pictures", flat]);
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

  // Shows what a plan leaves out, and the arm there.
  private goTo(finding: Finding): void {
    this.setPlaying(false);
    for (const scene of this.scenes) {
      scene.showPosture(finding.q);
      scene.lookAt(finding.world_m, 0.6);
    }
    this.state.textContent = `stroke ${finding.stroke}: ${finding.text}`;
    this.state.style.borderLeftColor = this.isPlan ? problemKey(this.scenes[0]?.problems().indexOf(finding.problem) ?? 0) : onEither(leftOutColour);
    this.dirty = true;
  }

  private listen(): void {
    this.play.addEventListener("click", () => this.setPlaying(!this.playing));
    this.slider.addEventListener("input", () => this.goAway(Number(this.slider.value)));
    this.speedChoice.addEventListener("change", () => (this.speed = Number(this.speedChoice.value)));
    this.colourChoice.addEventListener("change", () => this.setColour(this.colourChoice.value as Colour));
    this.mapChoice.addEventListener("change", () => this.setMap(this.mapChoice.value));
    this.overTick.addEventListener("change", () => this.setOver(this.overTick.checked));
    const { signal } = this.gone;
    window.addEventListener("hashchange", () => {
      const moment = momentOf(location.hash);
      if (moment.colour) this.setColour(moment.colour);
      if (moment.view) this.setView(moment.view);
      if (moment.t !== undefined) this.goAway(moment.t);
    }, { signal });
    window.addEventListener("keydown", (event) => this.key(event), { signal });
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.applyTheme(), { signal });
    new ResizeObserver(() => this.resize()).observe(this.stage);
    for (const scene of this.scenes) {
      scene.onChange = () => (this.dirty = true);
      scene.onFree = () => this.markView("free");
      // One camera for all.
      scene.onMove = () => {
        if (!this.moving) for (const other of this.scenes) if (other !== scene) other.setEye(scene.eye(), this.view);
      };
      let pressed = [0, 0];
      scene.canvas.addEventListener("pointerdown", (e) => (pressed = [e.offsetX, e.offsetY]));
      scene.canvas.addEventListener("click", (e) => {
        if (Math.hypot(e.offsetX - pressed[0], e.offsetY - pressed[1]) > 4) return;
        const finding = scene.findingAt(e.offsetX, e.offsetY);
        if (finding) return this.goTo(finding);
        const t = scene.timeAt(e.offsetX, e.offsetY);
        if (t !== null) this.goAway(t);
      });
    }
    if (this.live) {
      this.live.link.onState = () => this.showLive();
      this.showLive();
    }
  }

  // To a moment that the user chose: a run that goes on is no longer followed.
  private goAway(t: number): void {
    if (this.live) this.setFollow(t >= this.end - 1e-6);
    this.seek(t);
  }

  private setFollow(follows: boolean): void {
    this.follows = follows;
    this.liveFollow.setAttribute("aria-pressed", String(follows));
    if (follows) {
      this.setPlaying(false);
      this.seek(this.end);
    }
  }

  private setFollowOff(): void {
    this.follows = false;
    this.liveFollow.setAttribute("aria-pressed", "false");
  }

  private showLive(): void {
    if (!this.live) return;
    const { run, link } = this.live;
    const now = run.numbers();
    const words = {
      connecting: "connecting …", running: link.stopping ? "stopping" : "running", paused: "paused",
      ending: "the run has ended; its report is being made …", finished: "finished",
      lost: "the run's program does not answer; trying again …",
    }[link.state];
    const facts = [words];
    if (Number.isFinite(now.share)) facts.push(`${Math.round(100 * now.share)} %`);
    if (link.state === "running" && Number.isFinite(now.rate)) facts.push(`${numberText(now.rate, 2)} × real time`);
    const text = facts.join(" · ");
    if (this.liveState.textContent !== text) this.liveState.textContent = text;
    this.liveState.dataset.state = link.state;
    this.livePause.textContent = link.state === "paused" ? "resume the run" : "pause the run";
    const going = link.state === "running" || link.state === "paused";
    this.livePause.disabled = this.liveStop.disabled = !going || link.stopping;
    this.liveEmergency.disabled = !going; // also while the pen is lifted
    this.liveNumbers.replaceChildren(liveTiles(now, this.run, this.run.live?.strokes ?? 0));
  }

  // Rows of a run that goes on have come.
  grow(): void {
    const { time } = this.run.scene;
    this.end = time[time.length - 1];
    this.slider.max = String(this.end);
    if (this.live && this.live.run.thinned !== this.thinned) {
      this.thinned = this.live.run.thinned;
      this.scenes[0]?.growAgain();
    } else {
      this.scenes[0]?.grow(this.inkShown);
    }
    this.inkShown = this.run.ink.time.length;
    const now = performance.now();
    if (now - this.refreshed > 300) {
      this.refreshed = now;
      this.plots.grow(this.end);
      this.drawStrip();
      this.showLive();
    }
    // The colours' ends follow what there is.
    if (now - this.coloured > 2000 || (this.inkShown > 0 && this.inkShown < 100)) {
      this.coloured = now;
      this.setColour(this.colour);
    }
    this.seek(this.follows && !this.playing ? this.end : this.t);
  }

  // Another page takes this one's place.
  close(): void {
    this.gone.abort();
    for (const scene of this.scenes) scene.dispose();
  }

  private key(event: KeyboardEvent): void {
    const target = event.target as HTMLElement;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (target.matches("input:not([type=range]):not([type=checkbox]), select, textarea")) return;
    const onSlider = target.matches("input[type=range]");
    const step = event.shiftKey ? 1 : 0.1;
    const actions: Record<string, () => void> = {
      " ": () => this.setPlaying(!this.playing),
      ArrowLeft: () => this.goAway(this.t - step),
      ArrowRight: () => this.goAway(this.t + step),
      Home: () => this.goAway(this.begin),
      End: () => this.goAway(this.end),
      "+": () => this.changeSpeed(1),
      "-": () => this.changeSpeed(-1),
      c: () => {
        const all = this.colours();
        this.setColour(all[(all.indexOf(this.colour) + 1) % all.length]);
      },
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
    for (const scene of this.scenes) scene.setDark(this.isDark());
    this.plots.restyle();
    this.dirty = true;
    this.drawStrip();
  }

  setPlaying(playing: boolean): void {
    this.playing = playing;
    if (!playing) this.tell();
    if (playing && this.live) this.setFollowOff();
    if (playing && this.t >= this.end - 1e-6) this.seek(this.begin);
    this.play.textContent = playing ? "❚❚" : "▶";
    this.play.setAttribute("aria-label", playing ? "pause" : "play");
    this.lastFrame = performance.now();
  }

  // Ink over ink in one scene, or the runs side by side.
  setOver(over: boolean): void {
    this.over = over;
    this.overTick.checked = over;
    this.panes.forEach((pane, k) => {
      pane.hidden = over && k > 0;
      pane.querySelector<HTMLElement>(".name")?.toggleAttribute("hidden", over); // the legend tells
    });
    this.scenes[0]?.setOver(over);
    this.colourChoice.disabled = over;
    this.setColour(this.colour);
    this.resize();
  }

  // Colours the canvas of a plan.
  setMap(name: string): void {
    this.mapChoice.value = name;
    const legend = this.scenes[0]?.setMap(name) ?? null;
    this.showLegend(this.mapLegend, legend, this.run.maps.find((m) => m.name === name)?.label ?? "");
    this.dirty = true;
  }

  setView(view: View): void {
    this.moving = true;
    for (const scene of this.scenes) scene.setView(view);
    // The drawings may differ in size: the first decides.
    for (const scene of this.scenes.slice(1)) scene.setEye(this.scenes[0].eye(), view);
    this.moving = false;
    this.markView(view);
    this.dirty = true;
  }

  private markView(view: View): void {
    this.view = view;
    for (const [name, button] of this.viewButtons) button.setAttribute("aria-pressed", String(name === view));
  }

  setColour(colour: Colour): void {
    if (!this.colours().includes(colour)) colour = "nothing";
    this.colour = colour;
    this.colourChoice.value = colour;
    const [legend] = this.scenes.map((scene) => scene.setColour(colour));
    const problems = this.isPlan && colour === "nothing" ? this.scenes[0]?.problems() ?? [] : [];
    if (problems.length) {
      const shown = { unit: "", low: 0, high: 0, kinds: problems.map((p) => p.replaceAll("_", " ")) };
      this.showLegend(this.legend, shown, "cannot be drawn", problemKey);
    } else {
      this.showLegend(this.legend, legend ?? null, this.labelOf(colour), this.over ? runColour : undefined);
    }
    this.dirty = true;
  }

  private showLegend(box: HTMLElement, legend: Legend | null, what: string, colourOf = (k: number) => kinds[k % kinds.length]): void {
    box.replaceChildren();
    box.hidden = !legend;
    if (!legend) return;
    if (legend.kinds) {
      box.setAttribute("aria-label", `${what}: ${legend.kinds.join(", ")}`);
      box.append(...legend.kinds.map((word, k) => {
        const mark = h("i");
        mark.style.setProperty("--key", colourOf(k));
        return h("span", {}, mark, word);
      }));
    } else {
      box.setAttribute("aria-label", `${what}: ${numberText(legend.low, 3)} to ${numberText(legend.high, 3)} ${legend.unit}`);
      const bar = h("b");
      bar.style.background = rampCss();
      box.append(h("span", {}, `${what} [${legend.unit}]`), bar,
        h("span", { class: "ends" }, h("span", {}, numberText(legend.low, 3)), h("span", {}, `≥ ${numberText(legend.high, 3)}`)));
    }
  }

  seek(t: number): void {
    this.move(t);
    this.tell();
  }

  // The scene alone.
  private move(t: number): void {
    this.t = Math.min(this.end, Math.max(this.begin, t));
    this.moving = true;
    for (const scene of this.scenes) scene.seek(this.t);
    this.moving = false;
    this.dirty = true;
  }

  // Time, state, strokes and plots say where the scene is.
  private tell(): void {
    this.told = performance.now();
    this.slider.value = String(this.t);
    this.slider.setAttribute("aria-valuetext", timeText(this.t));
    const filmed = this.stage.querySelector(".film-clock");
    if (filmed) filmed.textContent = timeText(this.t);
    this.clock.textContent = `${this.t.toFixed(2)} / ${this.end.toFixed(2)} s`;
    const row = Math.max(0, lastAt(this.run.scene.time, this.t));
    const { mode, stroke } = this.run.scene;
    const state = this.run.modes[mode[row]] ?? "";
    const text = this.runs.length > 1 ? "" : stroke[row] >= 0 ? `${state} · stroke ${stroke[row]}` : state;
    if (this.state.textContent !== text) {
      this.state.textContent = text;
      this.state.style.borderLeftColor = kinds[mode[row] % kinds.length] ?? "";
    }
    for (const tr of this.strokeRows)
      tr.classList.toggle("now", this.t >= Number(tr.dataset.begin) && this.t <= Number(tr.dataset.end));
    this.plots.seek(this.t);
  }

  private drawStrip(): void {
    const { strip } = this;
    const ratio = Math.min(devicePixelRatio, 2);
    strip.width = Math.max(1, strip.clientWidth * ratio);
    strip.height = Math.max(1, strip.clientHeight * ratio);
    const context = withPlainCanvases(() => strip.getContext("2d"));
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
    this.scenes.forEach((scene, k) => {
      const { clientWidth, clientHeight } = this.panes[k];
      if (!this.panes[k].hidden) scene.resize(Math.max(1, clientWidth), Math.max(1, clientHeight));
    });
    if (this.scenes.length) this.draw();
  }

  private draw(): void {
    this.scenes.forEach((scene, k) => this.panes[k].hidden || scene.render());
    this.dirty = false;
    ++this.drawn;
  }

  private frame(now: number): void {
    if (this.gone.signal.aborted) return;
    if (this.playing) {
      const t = this.t + this.speed * Math.min(0.25, (now - this.lastFrame) / 1000);
      this.move(t);
      // All that changes beside the scene makes the browser paint the whole window.
      if (now - this.told > (this.scenes[0]?.software ? 120 : 0)) this.tell();
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
    const [scene] = this.scenes;
    return {
      seek: (t: number) => {
        this.seek(t);
        this.draw();
      },
      live: () => ({ state: this.live?.link.state ?? "", rows: this.run.scene.time.length, ink: this.run.ink.time.length, follows: this.follows, segments: this.inkShown }),
      drop: () => this.live?.link.drop(),
      times: () => Array.from(this.run.scene.time),
      state: () => ({ t: this.t, playing: this.playing, speed: this.speed, view: this.view, colour: this.colour, end: this.end, over: this.over }),
      frames: (which = 0) => this.scenes[which]?.frames() ?? {},
      eyes: () => this.scenes.map((s) => ({ from: s.eye().from.toArray(), at: s.eye().at.toArray() })),
      setOver: (over: boolean) => this.setOver(over),
      setMap: (name: string) => {
        this.setMap(name);
        this.draw();
      },
      // The scene alone, as large as the window, in full sharpness.
      film: (wanted: { view: View; colour: string; hide: string; plain: boolean }) => {
        document.documentElement.dataset.film = wanted.plain ? "plain" : "";
        this.stage.append(h("span", { class: "film-clock" }));
        for (const s of this.scenes) {
          s.setSharpness(2);
          for (const part of wanted.hide.split(",").map((x) => x.trim()).filter(Boolean)) {
            if (!(part in s.parts)) throw new Error(`--hide ${part}: valid are ${Object.keys(s.parts).join(", ")}`);
            s.setShown(part as keyof Scene["parts"], false);
          }
        }
        if (wanted.colour) {
          if (!this.colours().includes(wanted.colour as Colour)) throw new Error(`--colour ${wanted.colour}: valid are ${this.colours().join(", ")}`);
          this.setColour(wanted.colour as Colour);
        }
        this.resize();
        this.setView(wanted.view);
        return { begin: this.begin, end: this.end };
      },
      findingLine: (k: number) => Array.from(this.run.findings[k].line[0], (_, i) => this.run.findings[k].line.map((column) => column[i])),
      maps: () => this.run.maps.map((m) => m.name),
      tipOfPath: () => {
        const { time, tip } = this.run.scene;
        const row = Math.max(0, lastAt(time, this.t));
        const next = Math.min(row + 1, time.length - 1);
        const f = next > row ? (this.t - time[row]) / (time[next] - time[row]) : 0;
        return tip.map((column) => column[row] * (1 - f) + column[next] * f);
      },
      findings: () => this.run.findings.map(({ problem, world_m, q }) => ({ problem, world_m, q })),
      project: (p: number[]) => scene?.project(p),
      placed: (p: number[]) => scene?.placed(p).toArray(),
      setColour: (colour: Colour) => this.setColour(colour),
      setView: (view: View) => {
        this.setView(view);
        this.draw();
      },
      hide: (part: keyof Scene["parts"]) => {
        for (const s of this.scenes) s.setShown(part, false);
        this.draw();
      },
      // What is not hidden, and the range of time that the plots show.
      shown: () => Object.entries(scene?.parts ?? {}).filter(([, part]) => part.visible).map(([name]) => name),
      range: () => this.plots.shownRange(),
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
        // All of it is played in twice that time.
        this.seek(this.begin);
        const { speed } = this;
        this.speed = (this.end - this.begin) / (2 * seconds);
        this.setPlaying(true);
        const [begin, drawn] = [performance.now(), this.drawn];
        while (performance.now() - begin < 1000 * seconds) await new Promise(requestAnimationFrame);
        const rate = (1000 * (this.drawn - drawn)) / (performance.now() - begin);
        this.setPlaying(false);
        this.speed = speed;
        return rate;
      },
    };
  }
}

// A run that goes on: its page is made when the first rows are here, and gives way to the report.
function follow(run: Run, root: HTMLElement): Promise<ReturnType<Page["hook"]>> {
  document.head.append(h("link", { rel: "icon", href: "data:," })); // else the browser asks for one
  return new Promise((shown) => {
    const live = new LiveRun(run);
    const link = new LiveLink(() => live.lastTime);
    let page: Page | null = null;
    let waiting: Float32Array[] = [];
    let asked = false;
    const take = () => {
      asked = false;
      for (const rows of waiting) live.append(rows);
      waiting = [];
      if (page) return page.grow();
      page = new Page([run], root, { run: live, link });
      shown(page.hook());
    };
    link.onRows = (rows) => {
      waiting.push(rows);
      if (!asked) requestAnimationFrame(take);
      asked = true;
    };
    const tell = () => root.querySelector(".waiting")?.replaceChildren(link.state === "lost" ? "The run's program does not answer; trying again …" : "Waiting for the run …");
    link.onState = tell;
    tell();
    link.onReport = (report) => {
      page?.close();
      if (report) {
        page = new Page([report], root, null, "The run has ended: this is its report.");
        const hook = page.hook();
        shown(hook);
        window.impedraw = Promise.resolve(hook);
      } else {
        root.replaceChildren(h("p", { class: "warning", role: "status" }, "The run has ended. It left no report."));
      }
      link.onRows = () => {};
      waiting = [];
    };
  });
}

async function start(): Promise<ReturnType<Page["hook"]>> {
  const root = document.getElementById("page") as HTMLElement;
  try {
    const data = document.getElementById("data") as HTMLElement;
    const runs = await Promise.all((data.textContent ?? "").split(",").map(async (text) => parse(await inflate(text))));
    data.remove();
    return runs[0].live ? await follow(runs[0], root) : new Page(runs, root).hook();
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
