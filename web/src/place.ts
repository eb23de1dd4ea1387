// The page of ./impedraw place: the object in 3-D, on which the drawing is dragged, turned and scaled, or areas are marked for
// ./impedraw cover.
import * as three from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { BodyMaterial } from "./bodies";
import { problemColour, rgb } from "./colours";
import { h, numberText } from "./dom";
import { Lines } from "./lines";
import { type Cells, History, missing, type Place, placed, spaced, Surface } from "./placing";

interface Data {
  name: string;
  cells: Cells;
  X_WP: number[];
  mesh: { points: number[]; triangles: number[] };
  cloud: number[];
  strokes: number[][];
  given: Place;
}

interface Check {
  share: number;
  length_mm: number;
  time_s: number;
  width_mm: number;
  height_mm: number;
  lost_mm: Record<string, number>;
  error?: string;
}

const above = 0.4e-3; // of the lines over the surface [m]
const between = 1e-3; // of the points of an outline [m]
const mostPoints = 6000; // of the drawing on the screen
const token = location.search;

async function ask(name: string, question: object): Promise<Record<string, unknown>> {
  const answer = await fetch(`/${name}${token}`, { method: "POST", body: JSON.stringify(question) });
  return (await answer.json()) as Record<string, unknown>;
}

class Page {
  private surface: Surface;
  private history: History<Place>;
  private areas = new History<number[][]>([]); // that are marked: outlines in P, x and y by turns [m]
  private marking = false;
  private lines = new Lines([]);
  private renderer: three.WebGLRenderer;
  private scene = new three.Scene();
  private camera = new three.PerspectiveCamera(35, 1, 0.01, 30);
  private orbit: OrbitControls;
  private body: three.Object3D;
  private step: number;
  private checking = false;
  private wanted = false;
  private base = { width: 0, height: 0 }; // of the given drawing [mm]

  private share = h("div", { class: "share", role: "status", "aria-live": "polite" });
  private summary = h("div", { class: "hint" });
  private lost = h("div", { class: "lost" });
  private said = h("div", { class: "said", role: "status" });
  private inputs: Record<"x" | "y" | "turn" | "width", HTMLInputElement>;
  private undo = h("button", { title: "ctrl-Z" }, "Undo");
  private redo = h("button", { title: "ctrl-shift-Z" }, "Redo");
  private save = h("button", { title: "ctrl-S" }, "Save");
  private plan = h("button", { title: "the whole pre-flight; takes some seconds" }, "Check fully");
  private mark = h("button", { "aria-pressed": "false", title: "goes round what a pad shall treat: ./impedraw cover" }, "Mark an area");
  private keys = h("p", { class: "hint keys" });

  constructor(private data: Data, root: HTMLElement) {
    this.surface = new Surface(data.cells, data.X_WP);
    this.history = new History(data.given);
    const length = data.strokes.reduce((sum, s) => sum + lengthOf(s), 0);
    this.step = Math.max(1e-3, length / mostPoints);
    const input = (label: string): HTMLInputElement => h("input", { type: "number", step: "any", "aria-label": label });
    this.inputs = { x: input("x [mm]"), y: input("y [mm]"), turn: input("turn [°]"), width: input("width [mm]") };
    const canvas = document.createElement("canvas");
    const context = canvas.getContext("webgl2", { alpha: false, antialias: true });
    if (!context) throw new Error("this browser has no WebGL 2; ./impedraw draw --place surface finds a place without it");
    this.renderer = new three.WebGLRenderer({ canvas, context });
    const row = (name: string, input: HTMLInputElement, unit: string): Node[] => [h("span", {}, name), input, h("span", { class: "hint" }, unit)];
    const fields = h("div", { class: "fields" });
    for (const [name, key, unit] of [["x", "x", "mm"], ["y", "y", "mm"], ["turn", "turn", "°"], ["width", "width", "mm"]] as const)
      fields.append(...row(name, this.inputs[key], unit));
    const stage = h("div", { class: "stage" }, canvas);
    root.replaceChildren(h("main", { class: "place" }, stage,
      h("aside", { class: "side" }, h("h1", {}, data.name), h("div", {}, this.share, this.summary), this.lost, fields,
        h("div", { class: "buttons" }, this.undo, this.redo, this.mark, this.plan, this.save), this.said, this.keys)));

    this.body = this.makeBody();
    this.camera.up.set(0, 0, 1);
    this.lines.width = 3;
    this.scene.add(this.body, this.lines);
    this.orbit = new OrbitControls(this.camera, canvas);
    this.orbit.addEventListener("change", () => this.draw());
    this.look();
    new ResizeObserver(() => this.resize(stage)).observe(stage);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.draw());

    for (const element of Object.values(this.inputs)) element.addEventListener("change", () => this.typed());
    this.undo.addEventListener("click", () => this.changes.undo() && this.refresh());
    this.redo.addEventListener("click", () => this.changes.redo() && this.refresh());
    this.save.addEventListener("click", () => void this.store(false));
    this.plan.addEventListener("click", () => void this.planned());
    this.mark.addEventListener("click", () => this.setMarking(!this.marking));
    addEventListener("keydown", (event) => this.key(event));
    this.dragBy(canvas);
    this.markBy(canvas);
    this.setMarking(false);
  }

  private makeBody(): three.Object3D {
    const group = new three.Group();
    const { points, triangles } = this.data.mesh;
    if (triangles.length > 0) {
      const geometry = new three.BufferGeometry();
      geometry.setAttribute("position", new three.BufferAttribute(Float32Array.from(points), 3));
      geometry.setIndex(new three.BufferAttribute(Uint32Array.from(triangles), 1));
      geometry.computeVertexNormals();
      const material = new BodyMaterial(0xd5d9df);
      material.side = three.DoubleSide;
      // Pushed back a little, so that the drawing on it is not hidden by it.
      Object.assign(material, { polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 150 });
      group.add(new three.Mesh(geometry, material));
    } else {
      const geometry = new three.BufferGeometry();
      geometry.setAttribute("position", new three.BufferAttribute(Float32Array.from(this.data.cloud), 3));
      group.add(new three.Points(geometry, new three.PointsMaterial({ size: 2.5, sizeAttenuation: false, color: "#8a919b" })));
    }
    return group;
  }

  // As the drawing is read, from above, the whole object in view.
  private look(): void {
    const sphere = new three.Box3().setFromObject(this.body).getBoundingSphere(new three.Sphere());
    const from = new three.Vector3(-0.8, -0.25, 0.95).normalize().multiplyScalar(Math.max(0.05, sphere.radius) * 3.4);
    this.orbit.target.copy(sphere.center);
    this.camera.position.copy(sphere.center).add(from);
    this.orbit.update();
  }

  private resize(stage: HTMLElement): void {
    const { clientWidth: width, clientHeight: height } = stage;
    if (width === 0 || height === 0) return;
    this.renderer.setPixelRatio(Math.min(2, devicePixelRatio));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.lines.resize(width, height);
    this.draw();
  }

  private draw(): void {
    this.renderer.setClearColor(getComputedStyle(document.documentElement).getPropertyValue("--back").trim() || "#ffffff");
    this.renderer.render(this.scene, this.camera);
  }

  // The body is as bright in the dark.
  private colour(trouble: number): string {
    return trouble === 0 ? "#0a3d91" : problemColour(trouble - 1);
  }

  private get changes(): History<Place> | History<number[][]> {
    return this.marking ? this.areas : this.history;
  }

  private setMarking(marking: boolean): void {
    this.marking = marking;
    this.mark.setAttribute("aria-pressed", String(marking));
    for (const input of Object.values(this.inputs)) input.disabled = marking;
    this.plan.disabled = marking;
    this.renderer.domElement.classList.toggle("marking", marking);
    this.keys.textContent = marking
      ? "Go round what is to be treated, with the button held down; more areas are added. Drag beside the object to look around. Escape leads back to the drawing."
      : "Drag the drawing along the object; drag beside it to look around. Arrow keys move it by 1 mm, with shift by 10; [ and ] turn it, − and + scale it.";
    this.say("");
    this.refresh();
  }

  // The drawing anew at its place, or the areas that are marked, in their colours.
  private refresh(): void {
    if (this.marking) {
      const rows = this.surface.rows(this.areas.now);
      this.lay([...this.areas.now.map((area) => [...area, area[0], area[1]]), ...rows], this.data.cells.side / 2);
      this.tellAreas(rows);
    } else {
      this.lay(this.data.strokes.map((stroke) => placed(stroke, this.history.now)), this.step);
      void this.check();
    }
    const { x, y, turn, size } = this.history.now;
    const shown = { x: 1e3 * x, y: 1e3 * y, turn, width: size * this.base.width };
    for (const [key, input] of Object.entries(this.inputs))
      if (document.activeElement !== input) input.value = shown[key as keyof typeof shown].toFixed(1);
    this.undo.disabled = !this.changes.canUndo;
    this.redo.disabled = !this.changes.canRedo;
  }

  // Lines of P on the surface.
  private lay(lines: number[][], step: number): void {
    const points: number[] = [], tints: number[] = [];
    const top = this.surface.top();
    for (const given of lines) {
      const line = spaced(given, step);
      let last: [number, number, number] | null = null;
      for (let k = 0; k < line.length; k += 2) {
        const [x, y] = [line[k], line[k + 1]];
        const z = this.surface.height(x, y);
        const p = this.surface.world(x, y, (z ?? top) + above);
        if (last) {
          points.push(...last, ...p);
          tints.push(z === null ? missing : this.surface.trouble(x, y));
        }
        last = p;
      }
    }
    this.lines.forget();
    this.lines.append(points);
    this.lines.tint((segment) => rgb(this.colour(tints[segment])));
    this.lines.show(tints.length);
    this.draw();
  }

  // One question at a time; the last place is always asked for.
  private async check(): Promise<void> {
    this.wanted = true;
    if (this.checking) return;
    this.checking = true;
    try {
      while (this.wanted) {
        this.wanted = false;
        const place = this.history.now;
        const found = (await ask("check", place)) as unknown as Check;
        if (found.error) this.say(found.error, true);
        else this.tell(found, place);
      }
    } catch {
      this.say("impedraw does not answer: it has ended", true);
    } finally {
      this.checking = false;
    }
  }

  private tell(found: Check, place: Place): void {
    if (this.base.width === 0) {
      this.base = { width: found.width_mm / place.size, height: found.height_mm / place.size };
      this.inputs.width.value = found.width_mm.toFixed(1);
    }
    if (this.marking) return;
    this.tellShare(found.share, new Map(this.data.cells.words.map((word, trouble) => [trouble, found.lost_mm[word] ?? 0])), "mm",
      `can be drawn · ${numberText(found.width_mm, 3)} × ${numberText(found.height_mm, 3)} mm · about ${minutes(found.time_s)}`);
  }

  private tellAreas(rows: number[][]): void {
    const { all, lost } = this.surface.sizeOf(rows);
    const cm2 = new Map([...lost].map(([trouble, size]) => [trouble, 1e4 * size]));
    const share = all > 0 ? 1 - [...lost.values()].reduce((a, b) => a + b, 0) / all : 0;
    this.tellShare(share, cm2, "cm²", all > 0 ? `of ${numberText(1e4 * all, 3)} cm² can be treated, less the pad's margin at edges` : "nothing is marked");
  }

  private tellShare(share: number, lost: Map<number, number>, unit: string, summary: string): void {
    this.share.textContent = `${(Math.floor(1000 * share) / 10).toFixed(1)} %`;
    this.share.dataset.all = String(share > 0.9995);
    this.summary.textContent = summary;
    this.lost.replaceChildren(...[...lost].filter(([, size]) => size > 0).flatMap(([trouble, size]) => [
      h("span", {}, h("i", { style: `--key: ${problemColour(trouble - 1)}` }), trouble === missing ? "off the surface, or too rough" : this.data.cells.words[trouble]),
      h("span", { class: "hint" }, `${numberText(size, 2)} ${unit}`)]));
  }

  private say(text: string, bad = false): void {
    this.said.textContent = text;
    this.said.dataset.bad = String(bad);
  }

  private go(change: Partial<Place>, goesOn = false): void {
    const next = { ...this.history.now, ...change };
    if (!Object.values(next).every(Number.isFinite)) return this.refresh();
    next.turn = ((((next.turn + 180) % 360) + 360) % 360) - 180;
    next.size = Math.min(100, Math.max(0.01, next.size));
    this.history.move(next, goesOn);
    this.say("");
    this.refresh();
  }

  private typed(): void {
    const value = (key: keyof typeof this.inputs): number => (this.inputs[key].value === "" ? NaN : Number(this.inputs[key].value));
    this.go({ x: value("x") / 1e3, y: value("y") / 1e3, turn: value("turn"), size: value("width") / this.base.width });
  }

  private key(event: KeyboardEvent): void {
    const control = event.ctrlKey || event.metaKey;
    if (control && event.key.toLowerCase() === "z") {
      event.preventDefault();
      if (event.shiftKey ? this.changes.redo() : this.changes.undo()) this.refresh();
      return;
    }
    if (control && event.key.toLowerCase() === "s") {
      event.preventDefault();
      return void this.store(false);
    }
    if (event.key === "Escape" && this.marking) return this.setMarking(false);
    if (control || this.marking || event.target instanceof HTMLInputElement) return;
    const step = event.shiftKey ? 0.01 : 0.001;
    const { x, y, turn, size } = this.history.now;
    const moves: Record<string, Partial<Place>> = {
      ArrowLeft: { y: y + step }, ArrowRight: { y: y - step }, ArrowUp: { x: x + step }, ArrowDown: { x: x - step },
      "[": { turn: turn + 5 }, "]": { turn: turn - 5 }, "+": { size: size * 1.05 }, "-": { size: size / 1.05 },
    };
    if (!(event.key in moves)) return;
    event.preventDefault();
    this.go(moves[event.key]);
  }

  // Where the pointer's ray meets the object, in P.
  private under(event: PointerEvent, canvas: HTMLCanvasElement): [number, number] | null {
    const box = canvas.getBoundingClientRect();
    const at = new three.Vector2((2 * (event.clientX - box.left)) / box.width - 1, 1 - (2 * (event.clientY - box.top)) / box.height);
    const ray = new three.Raycaster();
    ray.setFromCamera(at, this.camera);
    // Along the ray, from the eye: the first point under the height field. It is what the drawing lies on.
    const { origin, direction } = ray.ray;
    const far = 4 * this.camera.position.distanceTo(this.orbit.target), step = this.data.cells.side / 2;
    const up = new three.Vector3(this.data.X_WP[2], this.data.X_WP[6], this.data.X_WP[10]);
    let before = false;
    for (let s = 0; s < far; s += step) {
      const p = origin.clone().addScaledVector(direction, s);
      const [x, y] = this.surface.plane(p);
      const z = this.surface.height(x, y);
      const below = z !== null && up.dot(p) - up.dot(new three.Vector3(...this.surface.world(x, y, z))) < 0;
      if (below) return before ? [x, y] : null;
      before = true;
    }
    return null;
  }

  // Where the drawing's middle is on the screen [px]; for tests.
  screen(): [number, number] {
    const { x, y } = this.history.now;
    const p = new three.Vector3(...this.surface.world(x, y, this.surface.height(x, y) ?? this.surface.top())).project(this.camera);
    const box = this.renderer.domElement.getBoundingClientRect();
    return [box.left + (box.width * (p.x + 1)) / 2, box.top + (box.height * (1 - p.y)) / 2];
  }

  private dragBy(canvas: HTMLCanvasElement): void {
    let from: { at: [number, number]; place: Place } | null = null;
    const onDrawing = (at: [number, number] | null): boolean => {
      if (!at) return false;
      const { x, y, turn, size } = this.history.now;
      const a = (-turn * Math.PI) / 180, dx = at[0] - x, dy = at[1] - y;
      const u = (Math.cos(a) * dx - Math.sin(a) * dy) / size, v = (Math.sin(a) * dx + Math.cos(a) * dy) / size;
      const box = boxOf(this.data.strokes), rim = 0.006 / size;
      return u > box[0] - rim && u < box[2] + rim && v > box[1] - rim && v < box[3] + rim;
    };
    // Before the orbit sees it.
    canvas.addEventListener("pointerdown", (event) => {
      const at = this.under(event, canvas);
      if (this.marking || event.button !== 0 || !at || !onDrawing(at)) return;
      event.stopImmediatePropagation();
      canvas.setPointerCapture(event.pointerId);
      from = { at, place: this.history.now };
      this.orbit.enabled = false;
      this.history.move(this.history.now);
    }, { capture: true });
    canvas.addEventListener("pointermove", (event) => {
      if (this.marking) return;
      const at = this.under(event, canvas);
      if (!from) return void canvas.classList.toggle("over", onDrawing(at));
      if (at) this.go({ x: from.place.x + at[0] - from.at[0], y: from.place.y + at[1] - from.at[1] }, true);
    });
    const end = (): void => {
      from = null;
      this.orbit.enabled = true;
    };
    canvas.addEventListener("pointerup", end);
    canvas.addEventListener("pointercancel", end);
  }

  // An outline that is drawn on the object, whose last point is joined to its first.
  private markBy(canvas: HTMLCanvasElement): void {
    let outline: number[] | null = null;
    canvas.addEventListener("pointerdown", (event) => {
      const at = this.marking && event.button === 0 ? this.under(event, canvas) : null;
      if (!at) return;
      event.stopImmediatePropagation();
      canvas.setPointerCapture(event.pointerId);
      this.orbit.enabled = false;
      outline = at.map(rounded);
      this.areas.move([...this.areas.now, outline]);
    }, { capture: true });
    canvas.addEventListener("pointermove", (event) => {
      const at = outline && this.under(event, canvas);
      if (!outline || !at || Math.hypot(at[0] - outline[outline.length - 2], at[1] - outline[outline.length - 1]) < between) return;
      outline.push(...at.map(rounded));
      this.refresh();
    });
    const end = (): void => {
      if (!outline) return;
      this.orbit.enabled = true;
      if (this.surface.rows([outline]).length === 0) this.areas.undo();
      outline = null;
      this.refresh();
    };
    canvas.addEventListener("pointerup", end);
    canvas.addEventListener("pointercancel", end);
  }

  private async planned(): Promise<void> {
    this.say("checking …");
    try {
      const found = await ask("plan", this.history.now);
      this.say(typeof found.share === "number" ? `the whole pre-flight lets ${(100 * found.share).toFixed(1)} % pass` : String(found.error), !("share" in found));
    } catch {
      this.say("impedraw does not answer: it has ended", true);
    }
  }

  private async store(overwrite: boolean): Promise<void> {
    try {
      const found = await ask("save", { ...(this.marking ? { areas: this.areas.now } : this.history.now), overwrite });
      if (typeof found.file === "string") return this.say(`saved: ${found.file}; ./impedraw ${this.marking ? "cover" : "draw"} takes it`);
      const again = h("button", { class: "small" }, "Overwrite");
      again.addEventListener("click", () => void this.store(true));
      this.say(`${String(found.error)} `, true);
      if (!overwrite) this.said.append(again);
    } catch {
      this.say("impedraw does not answer: it has ended", true);
    }
  }
}

function lengthOf(stroke: number[]): number {
  let sum = 0;
  for (let k = 2; k < stroke.length; k += 2) sum += Math.hypot(stroke[k] - stroke[k - 2], stroke[k + 1] - stroke[k - 1]);
  return sum;
}

function boxOf(strokes: number[][]): [number, number, number, number] {
  const box: [number, number, number, number] = [Infinity, Infinity, -Infinity, -Infinity];
  for (const stroke of strokes)
    for (let k = 0; k < stroke.length; k += 2) {
      box[0] = Math.min(box[0], stroke[k]);
      box[1] = Math.min(box[1], stroke[k + 1]);
      box[2] = Math.max(box[2], stroke[k]);
      box[3] = Math.max(box[3], stroke[k + 1]);
    }
  return box;
}

const rounded = (x: number): number => Math.round(1e5 * x) / 1e5; // to 0.01 mm
const minutes = (s: number): string => (s < 90 ? `${Math.round(s)} s` : `${(s / 60).toFixed(1)} min`);

async function begin(root: HTMLElement): Promise<void> {
  const answer = await fetch(`/data${token}`);
  if (!answer.ok) throw new Error(await answer.text());
  Object.assign(window, { impedraw: new Page((await answer.json()) as Data, root) });
}

const root = document.getElementById("page")!;
begin(root).catch((error: unknown) =>
  root.replaceChildren(h("p", { class: "waiting" }, String(error instanceof Error ? error.message : error))));
