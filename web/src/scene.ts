// The scene: arm, canvas, cloud, target, ink, normal and force, cameras. Units m, z up, frame W.
import * as three from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { BodyMaterial, creased, geometryOfMesh, interleaved, ShadedMaterial } from "./bodies";
import { bareColour, kinds, leftOutColour, onDark, problemColour, quantile, rampAt, rgb, runColour } from "./colours";
import { lastAt } from "./columns";
import type { Colouring, Finding, Matrix, Run } from "./data";
import { linkFrames } from "./kinematics";
import { inSoftware, wantsCoarse } from "./software";
import { straightTo } from "./thin";
import { Lines } from "./lines";
import type { Colour, View } from "./link";

export interface Legend {
  unit: string;
  low: number;
  high: number;
  kinds?: string[]; // words in the colours of `kinds`, in place of a ramp
}

// Where the camera is; `from` is relative to `at`.
export interface Eye {
  from: three.Vector3;
  at: three.Vector3;
}

// The ink of a run, of which as much is drawn as it has by then.
interface Ink {
  run: Run;
  lines: Lines;
  point: number[]; // index of each segment's first point in run.ink
  time: number[]; // of each segment
}

export const targetColour = "#6f9fcc";
const forceScale = 0.02; // [m/N]
const normalLength = 0.06; // [m]
// Ink of more points is drawn by fewer, off by at most `inkOff` [m]: a tenth of a thin line's width.
const fineInk = 4000;
const inkOff = 4e-5;
const coarseOff = 0.08; // of a canvas's coarse triangles [mm]

function matrix4(m: Matrix): three.Matrix4 {
  return new three.Matrix4().set(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8], m[9], m[10], m[11], 0, 0, 0, 1);
}

function pointAt(points: Float64Array[], i: number): three.Vector3 {
  return new three.Vector3(points[0][i], points[1][i], points[2][i]);
}

// A line with an arrow's head; both keep their width whatever the length.
class Arrow extends three.Group {
  private shaft: three.Mesh;
  private head: three.Mesh;
  private ring: three.Mesh | null = null;

  constructor(colour: string, withRing: boolean) {
    super();
    const material = new three.MeshBasicMaterial({ color: colour });
    this.shaft = new three.Mesh(new three.CylinderGeometry(0.0012, 0.0012, 1, 8).translate(0, 0.5, 0), material);
    this.head = new three.Mesh(new three.ConeGeometry(0.004, 0.012, 12).translate(0, 0.006, 0), material);
    this.add(this.shaft, this.head);
    if (withRing) {
      this.ring = new three.Mesh(
        new three.RingGeometry(0.011, 0.0125, 40).rotateX(-Math.PI / 2).translate(0, 0.0005, 0),
        new three.MeshBasicMaterial({ color: colour, side: three.DoubleSide }));
      this.add(this.ring);
    }
    this.visible = false;
  }

  // As wide as it should look from here; a ring about it shows where a pen hides it.
  setWidth(width: number): void {
    this.shaft.scale.x = this.shaft.scale.z = width;
    this.head.scale.setScalar(width);
    this.ring?.scale.setScalar(width);
  }

  // Hidden if there is no vector, or a very short one.
  show(from: three.Vector3, vector: three.Vector3): void {
    const length = vector.length();
    this.visible = Number.isFinite(length) && length > 1e-4;
    if (!this.visible) return;
    this.position.copy(from);
    this.quaternion.setFromUnitVectors(new three.Vector3(0, 1, 0), vector.clone().divideScalar(length));
    this.shaft.scale.y = length;
    this.head.position.set(0, length, 0);
  }
}

export class Scene {
  readonly canvas: HTMLCanvasElement;
  readonly parts: Record<"canvas" | "cloud" | "target" | "ink" | "arm" | "normal" | "force" | "cameras" | "grid", three.Object3D>;
  onChange: () => void = () => {};
  onFree: () => void = () => {};
  onMove: () => void = () => {}; // of the camera, by hand
  readonly software = inSoftware();
  private renderer: three.WebGLRenderer;
  private scene = new three.Scene();
  private carried = new three.Group(); // what is given in the canvas's frame
  private camera = new three.PerspectiveCamera(35, 1, 0.02, 30);
  private orbit: OrbitControls;
  private links: three.Group[] = [];
  private armMaterials: BodyMaterial[] = [];
  private penMaterial!: BodyMaterial;
  private pen: three.Mesh | null = null;
  private normal = new Arrow(kinds[2], true);
  private force = new Arrow(kinds[1], false);
  private inks!: Ink[]; // the run's own first
  private targets: Lines[] = [];
  private shades = new Float32Array();
  private map: Colouring | null = null;
  private posture: number[] | null = null;
  private over = false;
  private sharpness: number | null = null;
  private canvasMaterial!: ShadedMaterial;
  private canvasOff = 0; // [m]
  private gridMaterial!: three.LineBasicMaterial;
  private drawing = new three.Sphere(new three.Vector3(0.6, 0, 0.1), 0.2);
  private whole = new three.Sphere();
  private opening = new three.Sphere(); // of a plan: the canvas alone
  private view: View = "free";
  private followed = new three.Vector3();
  private t = 0;
  private dark = false;
  private colour: Colour = "nothing";
  private tintOf: (segment: number) => [number, number, number] = () => [0, 0, 0]; // of the run's own ink

  // `others`: runs whose ink can be laid over this one's. `panes`: scenes that share the page.
  // Throws an error where there is no WebGL.
  constructor(private run: Run, private others: Run[] = [], private panes = 1) {
    // Opaque, which three.js does not ask for: else the browser draws what lies behind, too. Desynchronized: without a graphics
    // card, that saves a copy of each picture.
    this.canvas = document.createElement("canvas");
    const context = this.canvas.getContext("webgl2", { alpha: false, antialias: !this.software, desynchronized: this.software, powerPreference: "high-performance" });
    if (!context) throw new Error("no WebGL 2");
    this.renderer = new three.WebGLRenderer({ canvas: this.canvas, context });
    this.camera.up.set(0, 0, 1);
    this.orbit = new OrbitControls(this.camera, this.canvas);
    this.orbit.addEventListener("change", () => {
      this.onChange();
      this.onMove();
    });
    this.orbit.addEventListener("start", () => {
      if (this.view === "pen") this.setFree();
    });
    this.parts = {
      canvas: this.makeCanvas(), cloud: this.makeCloud(), target: this.makeTarget(), ink: this.makeInk(),
      arm: this.makeArm(), normal: this.normal, force: this.force, cameras: this.makeCameras(), grid: this.makeGrid(),
    };
    this.scene.add(this.carried);
    for (const [name, part] of Object.entries(this.parts))
      (["canvas", "cloud", "target", "ink"].includes(name) ? this.carried : this.scene).add(part);
    this.measure();
    this.setDark(false);
  }

  private makeCanvas(): three.Object3D {
    const geometry = geometryOfMesh(this.run.canvas);
    geometry.computeVertexNormals();
    this.shades = shade(geometry);
    // Its corners have the shade of the fine one.
    const coarse = wantsCoarse() && this.run.canvas.coarse !== null;
    this.canvasOff = 1.5e-3 * (this.run.canvas.error_mm + (coarse ? coarseOff : 0));
    if (coarse && this.run.canvas.coarse) geometry.setIndex(new three.BufferAttribute(Uint32Array.from(this.run.canvas.coarse), 1));
    // Pushed back a little, so that ink on the surface is not hidden by it.
    this.canvasMaterial = new ShadedMaterial();
    return new three.Mesh(geometry, this.canvasMaterial);
  }

  private makeCloud(): three.Object3D {
    const geometry = new three.BufferGeometry();
    geometry.setAttribute("position", new three.BufferAttribute(interleaved(this.run.cloud.points), 3));
    const { colour } = this.run.cloud, coloured = colour.length > 0;
    if (coloured) {
      const rgb = new Float32Array(3 * colour.length);
      colour.forEach((c, i) => new three.Color(c).toArray(rgb, 3 * i));
      geometry.setAttribute("color", new three.BufferAttribute(rgb, 3));
    }
    const cloud = new three.Points(geometry, new three.PointsMaterial({
      color: coloured ? 0xffffff : kinds[5], vertexColors: coloured, size: coloured ? 2.5 : 1.6, sizeAttenuation: false,
    }));
    cloud.visible = coloured;
    return cloud;
  }

  private makeTarget(): three.Object3D {
    const { points, covered, begins } = this.run.target;
    const positions: number[] = [];
    const isCovered: boolean[] = [];
    for (let line = 0; line < begins.length; ++line) {
      const end = line + 1 < begins.length ? begins[line + 1] : covered.length;
      const has = (i: number) => covered[i] > 0 && covered[i + 1] > 0;
      for (let i = begins[line]; i + 1 < end;) {
        const next = straightTo(points, i, end, 60, 2e-5, (k) => has(k) === has(i));
        for (const k of [i, next]) positions.push(points[0][k], points[1][k], points[2][k]);
        isCovered.push(has(i));
        i = next;
      }
    }
    const target = new Lines(positions, 0.75);
    const pale = rgb(targetColour);
    const bare = rgb(bareColour);
    target.tint((s) => (isCovered[s] ? pale : bare));
    target.renderOrder = 1;
    this.targets = [target];
    const group = new three.Group().add(target);
    // What is left out: of a plan, by its reason.
    this.problems().forEach((problem, k) => {
      const ends = this.run.findings.filter((f) => f.problem === problem).flatMap((f) => {
        const at = Array.from(f.line[0], (_, i) => [f.line[0][i], f.line[1][i], f.line[2][i]]);
        if (at.length === 1) at.push(at[0]);
        return at.slice(1).flatMap((p, i) => [...at[i], ...p]);
      });
      const lines = new Lines(ends);
      lines.material.transparent = true;
      lines.renderOrder = 3;
      this.targets.push(lines);
      group.add(lines);
    });
    return group;
  }

  problems(): string[] {
    return [...new Set(this.run.findings.map((f) => f.problem))].sort();
  }

  private makeInk(): three.Object3D {
    this.inks = [this.run, ...this.others].map((run) => {
      const { points, time, begins } = run.ink;
      const positions: number[] = [];
      const times: number[] = [];
      const point: number[] = [];
      const long = time.length > fineInk;
      const add = (i: number, next: number) => {
        for (const k of [i, next]) positions.push(points[0][k], points[1][k], points[2][k]);
        times.push(time[next]);
        point.push(i);
      };
      for (let line = 0; line < begins.length; ++line) {
        const end = line + 1 < begins.length ? begins[line + 1] : time.length;
        if (end - begins[line] === 1) add(begins[line], begins[line]); // a dot
        for (let i = begins[line]; i + 1 < end;) {
          const next = long ? straightTo(points, i, end, 30, inkOff) : i + 1;
          add(i, next);
          i = next;
        }
      }
      const lines = new Lines(positions);
      lines.material.transparent = true; // so that it is drawn after the target
      lines.renderOrder = 2 + 0.01 * this.others.indexOf(run) + 0.01;
      lines.visible = run === this.run;
      return { run, lines, point, time: times };
    });
    return new three.Group().add(...this.inks.map((ink) => ink.lines));
  }

  // The ink of a run that goes on has lost points: all of it anew.
  growAgain(): void {
    const [ink] = this.inks;
    ink.lines.forget();
    ink.point = [];
    ink.time = [];
    this.grow(0);
  }

  // A run that goes on has more ink, from its point `first` on.
  grow(first: number): void {
    const [{ run, lines, point, time }] = this.inks;
    const { points, begins } = run.ink;
    const positions: number[] = [];
    const before = lines.segments;
    let line = lastAt(begins, first);
    for (let i = first; i < run.ink.time.length; ++i) {
      while (line + 1 < begins.length && begins[line + 1] <= i) ++line;
      if (i === begins[line]) continue;
      for (const k of [i - 1, i]) positions.push(points[0][k], points[1][k], points[2][k]);
      point.push(i - 1);
      time.push(run.ink.time[i]);
    }
    if (positions.length === 0) return;
    lines.append(positions);
    lines.tint(this.tintOf, before);
  }

  // The scene is not shown again.
  dispose(): void {
    this.orbit.dispose();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
  }

  // The other runs' ink in the same scene, or this run's alone.
  setOver(over: boolean): void {
    this.over = over;
    this.inks.forEach((ink, k) => {
      ink.lines.visible = k === 0 || over;
      ink.lines.material.depthWrite = !over; // pens press to different depths
    });
    this.setColour(this.colour);
    this.seek(this.t);
  }

  private makeArm(): three.Object3D {
    const arm = new three.Group();
    const light = new BodyMaterial(0xd8dbe0);
    const darker = new BodyMaterial(0x8b94a1);
    const ink = (this.penMaterial = new BodyMaterial(0x24406e));
    const mid = new BodyMaterial(0xc3c8cf);
    this.armMaterials = [light, darker, mid];
    const { arm: links } = this.run;
    const bare = links.every((link) => link.meshes.length === 0 && link.shapes.every((shape) => shape.kind === "mesh"));
    links.forEach((link, index) => {
      const group = new three.Group();
      group.matrixAutoUpdate = false;
      for (const mesh of link.meshes)
        group.add(new three.Mesh(creased(mesh, wantsCoarse() && mesh.coarse ? mesh.coarse : mesh.triangles, 0.6), index % 2 === 1 && index > 1 ? mid : light));
      for (const shape of link.meshes.length ? [] : link.shapes) {
        const thin = shape.kind === "cylinder" && shape.size[0] < 0.02;
        // The foot's would stand in the floor; others are a little smaller than the tubes that they join.
        const round = shape.kind === "sphere";
        if (round && link.parent < 0) continue;
        const geometry = geometryOf(shape.kind, round ? shape.size.map((x) => 0.975 * x) : shape.size);
        if (!geometry) continue;
        const mesh = new three.Mesh(geometry, thin ? ink : round ? darker : light);
        mesh.applyMatrix4(matrix4(shape.pose));
        group.add(mesh);
      }
      // A description without shapes: a rod to each child.
      if (bare) {
        for (const child of links.filter((l) => l.parent === index)) {
          const rod = rodTo(new three.Vector3(child.pose[3], child.pose[7], child.pose[11]), 0.03, light);
          if (rod) group.add(rod);
        }
      }
      this.links.push(group);
      arm.add(group);
    });
    if (links.length > 0) {
      // The pen's point, which a URDF seldom draws.
      const tip = this.links[links.length - 1];
      tip.add(new three.Mesh(new three.ConeGeometry(0.005, 0.011, 16).rotateX(Math.PI / 2).translate(0, 0, -0.0055), ink));
    } else {
      this.pen = new three.Mesh(
        new three.CylinderGeometry(0.005, 0.001, 0.12, 16).rotateX(-Math.PI / 2).translate(0, 0, -0.06), ink);
      arm.add(this.pen);
    }
    return arm;
  }

  private makeCameras(): three.Object3D {
    const group = new three.Group();
    const depth = 0.07;
    for (const camera of this.run.cameras) {
      const y = depth * Math.tan((camera.fov_y_deg * Math.PI) / 360);
      const x = y * camera.aspect;
      const corners = [[-x, -y], [x, -y], [x, y], [-x, y]].map(([a, b]) => new three.Vector3(a, b, depth));
      const lines = corners.flatMap((c, i) => [new three.Vector3(), c, c, corners[(i + 1) % 4]]);
      const frustum = new three.LineSegments(
        new three.BufferGeometry().setFromPoints(lines), new three.LineBasicMaterial({ color: 0x808893 }));
      frustum.applyMatrix4(matrix4(camera.pose));
      group.add(frustum);
    }
    return group;
  }

  private makeGrid(): three.Object3D {
    const grid = new three.GridHelper(3, 30);
    grid.rotateX(Math.PI / 2);
    this.gridMaterial = grid.material as three.LineBasicMaterial;
    this.gridMaterial.vertexColors = false;
    this.gridMaterial.transparent = true;
    return grid;
  }

  // What the views show: the drawing, and all of it.
  private measure(): void {
    const box = new three.Box3();
    for (const points of [this.run.target.points, this.run.ink.points, ...this.run.findings.map((f) => f.line)])
      for (let i = 0; i < points[0].length; ++i) box.expandByPoint(pointAt(points, i));
    if (box.isEmpty()) box.setFromObject(this.parts.canvas);
    if (!box.isEmpty()) box.getBoundingSphere(this.drawing);
    this.drawing.radius = Math.max(this.drawing.radius, 0.03);
    const all = new three.Box3();
    const { time, canvas } = this.run.scene;
    // Where a canvas moves to is a part of the picture.
    for (const share of canvas.length ? [1, 0.75, 0.5, 0.25, 0] : [0]) {
      this.seek(time[Math.floor(share * (time.length - 1))] ?? 0);
      this.scene.updateMatrixWorld(true);
      all.union(new three.Box3().setFromObject(this.parts.canvas)).union(box.clone().applyMatrix4(this.carried.matrixWorld));
    }
    all.getBoundingSphere(this.opening);
    all.union(new three.Box3().setFromObject(this.parts.arm));
    all.getBoundingSphere(this.whole);
    if (this.run.kind !== "plan" || all.isEmpty()) this.opening = this.whole;
  }

  // Shows the run at time t.
  seek(t: number): void {
    this.t = t;
    const { scene } = this.run;
    const i = Math.max(0, lastAt(scene.time, t));
    const next = Math.min(i + 1, scene.time.length - 1);
    const gap = scene.time[next] - scene.time[i];
    const f = gap > 0 ? Math.min(1, Math.max(0, (t - scene.time[i]) / gap)) : 0;
    const mixed = (column: Float64Array) => column[i] * (1 - f) + column[next] * f;
    if (scene.canvas.length && scene.time.length) {
      const [x, y, z, qw, qx, qy, qz] = scene.canvas;
      const turn = (k: number) => new three.Quaternion(qx[k], qy[k], qz[k], qw[k]).normalize();
      this.carried.position.set(mixed(x), mixed(y), mixed(z));
      this.carried.quaternion.copy(turn(i)).slerp(turn(next), f);
      this.carried.updateMatrixWorld(true);
    }
    const q = this.posture ?? scene.joints.map(mixed);
    linkFrames(this.run.arm, q).forEach((X, link) => this.links[link].matrix.copy(matrix4(X)));
    const tip = new three.Vector3(mixed(scene.tip[0]), mixed(scene.tip[1]), mixed(scene.tip[2]));
    const axis = new three.Vector3(mixed(scene.penAxis[0]), mixed(scene.penAxis[1]), mixed(scene.penAxis[2])).normalize();
    if (this.pen) {
      this.pen.position.copy(tip);
      this.pen.quaternion.setFromUnitVectors(new three.Vector3(0, 0, 1), axis);
    }
    const wanted = { normal: this.parts?.normal.userData.shown ?? true, force: this.parts?.force.userData.shown ?? true };
    this.force.show(tip, pointAt(scene.force, i).multiplyScalar(forceScale));
    this.normal.show(tip, pointAt(scene.normal, i).multiplyScalar(normalLength));
    this.force.visible &&= wanted.force;
    this.normal.visible &&= wanted.normal;
    // A plan shows all of its strokes: the arm alone moves.
    for (const ink of this.inks)
      ink.lines.show(ink.run.kind === "plan" ? ink.lines.segments : lastAt(ink.time, t) + 1);
    if (this.view === "tip") {
      const step = tip.clone().sub(this.followed);
      this.camera.position.add(step);
      this.orbit.target.add(step);
      this.orbit.update();
    } else if (this.view === "pen") {
      this.camera.position.copy(tip).addScaledVector(axis, -0.3).addScaledVector(sideways(axis), 0.04);
      this.orbit.target.copy(tip).addScaledVector(axis, 0.02);
      this.camera.lookAt(this.orbit.target);
    }
    this.followed.copy(tip);
  }

  // The arm takes a posture of its own until the next seek.
  showPosture(q: (number | null)[]): void {
    if (q.length !== this.run.joints.names.length || q.some((x) => x === null)) return;
    this.posture = q as number[];
    this.seek(this.t);
    this.posture = null;
    this.normal.visible = false; // that of the path
  }

  eye(): Eye {
    return { from: this.camera.position.clone().sub(this.orbit.target), at: this.orbit.target.clone() };
  }

  // Looks as another scene does; one that follows its tip goes on to do so.
  setEye(eye: Eye, view: View): void {
    this.view = view;
    if (view === "pen") return;
    const at = view === "tip" ? this.followed : eye.at;
    this.orbit.target.copy(at);
    this.camera.position.copy(at).add(eye.from);
    this.camera.lookAt(at);
  }

  setView(view: View): void {
    this.view = view;
    const axis = new three.Vector3(...this.run.drawingAxis);
    const up = new three.Vector3(...this.run.drawingUp);
    const distance = (sphere: three.Sphere) => {
      const fov = (this.camera.fov * Math.PI) / 360;
      return (1.06 * sphere.radius) / Math.sin(Math.min(fov, Math.atan(Math.tan(fov) * this.camera.aspect)));
    };
    const look = (direction: three.Vector3, sphere: three.Sphere) => {
      this.orbit.target.copy(sphere.center);
      this.camera.position.copy(sphere.center).addScaledVector(direction.normalize(), distance(sphere));
      this.orbit.update();
    };
    // From above and along the pen the arm stands in the way.
    for (const material of this.armMaterials) material.setAlpha(view === "top" || view === "pen" ? 0.18 : 1);
    if (view === "free") look(new three.Vector3(0.75, -1, 0.62), this.opening);
    if (view === "top") look(axis.clone().addScaledVector(up, -1e-3), this.drawing.clone().applyMatrix4(this.carried.matrixWorld));
    if (view === "front") look(new three.Vector3(1, 0, 0.25), this.whole);
    if (view === "side") look(new three.Vector3(0, -1, 0.25), this.whole);
    if (view === "tip") {
      this.orbit.target.copy(this.followed);
      this.camera.position.copy(this.followed).add(new three.Vector3(0.22, -0.3, 0.22));
      this.orbit.update();
    }
    if (view === "pen") this.seek(this.t);
    this.onChange();
  }

  private setFree(): void {
    this.view = "free"; // the arm stays as faint as it is
    this.onFree();
  }

  // Turns the free view towards a point.
  lookAt(p: number[], distance = 0.35): void {
    const target = this.placed(p);
    const offset = this.camera.position.clone().sub(this.orbit.target).setLength(distance);
    this.orbit.target.copy(target);
    this.camera.position.copy(target).add(offset);
    this.setFree();
    this.orbit.update();
  }

  setShown(part: keyof Scene["parts"], shown: boolean): void {
    this.parts[part].visible = shown;
    this.parts[part].userData.shown = shown;
    this.seek(this.t);
  }

  setOpacity(opacity: number): void {
    this.canvasMaterial.setAlpha(opacity);
    this.parts.canvas.visible = opacity > 0;
  }

  setDark(dark: boolean): void {
    this.dark = dark;
    this.renderer.setClearColor(dark ? "#14171c" : "#f3f4f6", 1);
    this.penMaterial.setColour(dark ? 0x5f8ed6 : 0x24406e);
    this.targets.slice(1).forEach((lines, k) => {
      const colour = this.run.kind === "plan" ? problemColour(k) : leftOutColour;
      lines.tint(() => rgb(dark ? onDark(colour) : colour));
    });
    this.gridMaterial.color.set(dark ? "#39404a" : "#c9ced6");
    this.setMap(this.map?.name ?? "");
    this.setColour(this.colour);
  }

  // Colours the canvas by one of the run's maps; by none where there is no such.
  setMap(name: string): Legend | null {
    this.map = this.run.maps.find((m) => m.name === name) ?? null;
    const { geometry } = this.parts.canvas as three.Mesh;
    const colours = this.shades.slice();
    let legend: Legend | null = null;
    if (this.map) {
      const { values, unit } = this.map;
      const high = Math.max(quantile(values, 0.98), 1e-6);
      const linear = new three.Color();
      values.forEach((v, i) => {
        linear.setRGB(...(Number.isFinite(v) ? rampAt(v / high) : rgb("#8a8f98")), three.SRGBColorSpace);
        const light = 0.55 + 0.5 * this.shades[3 * i];
        colours.set([light * linear.r, light * linear.g, light * linear.b], 3 * i);
      });
      legend = { unit, low: 0, high };
    }
    this.canvasMaterial.setColour(this.map ? "#ffffff" : this.dark ? "#7d848f" : "#e2ddd3");
    geometry.setAttribute("color", new three.BufferAttribute(colours, 3));
    this.onChange();
    return legend;
  }

  // Colours the ink; returns what the legend shows.
  setColour(colour: Colour): Legend | null {
    this.colour = colour;
    const [{ run, lines, point }] = this.inks;
    const plain = rgb(this.dark ? "#0a1a3c" : "#173d85");
    this.inks.forEach((ink, k) => {
      if (k > 0 || this.over) ink.lines.tint(() => rgb(runColour(k)));
    });
    if (this.over) return { unit: "", low: 0, high: 0, kinds: this.inks.map((ink) => ink.run.name) };
    if (colour === "pass") {
      let passes = 0;
      lines.tint(this.tintOf = (segment) => {
        const pass = run.ink.pass[Math.max(0, lastAt(run.ink.begins, point[segment]))];
        passes = Math.max(passes, pass);
        return rgb(kinds[(pass - 1) % kinds.length]);
      });
      return { unit: "", low: 1, high: passes, kinds: Array.from({ length: passes }, (_, i) => `pass ${i + 1}`) };
    }
    const chosen = run.ink.colours.find((c) => c.name === colour);
    if (!chosen) {
      lines.tint(this.tintOf = () => plain);
      return null;
    }
    const { values, unit } = chosen;
    const low = ["error", "tilt", "speed", "normal_error"].includes(colour) ? 0 : quantile(values, 0.01);
    const high = quantile(values, 0.99);
    const span = Math.max(high - low, 1e-9);
    lines.tint(this.tintOf = (segment) => {
      const v = chosen.values[point[segment]];
      return Number.isFinite(v) && Number.isFinite(span) ? rampAt((v - low) / span) : rgb("#8a8f98");
    });
    return { unit, low, high };
  }

  // Picture points a pixel, whatever it costs.
  setSharpness(sharpness: number): void {
    this.sharpness = sharpness;
  }

  resize(width: number, height: number): void {
    const sharp = this.sharpness ?? Math.min(window.devicePixelRatio, 2);
    const affordable = this.sharpness ?? Math.sqrt((1280 * 720) / (this.panes * width * height));
    this.renderer.setPixelRatio(this.software ? Math.min(sharp, affordable) : sharp);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / Math.max(height, 1);
    this.camera.updateProjectionMatrix();
    for (const lines of [...this.inks.map((ink) => ink.lines), ...this.targets]) lines.resize(width, height);
  }

  render(): void {
    // The pen's own width, but never so thin that it breaks up.
    const height = this.canvas.clientHeight || 1;
    const distance = this.camera.position.distanceTo(this.orbit.target);
    const pixel = (2 * distance * Math.tan((this.camera.fov * Math.PI) / 360)) / height;
    const width = Math.min(12, Math.max(1.8, (1e-3 * this.run.inkWidth) / pixel));
    const thick = Math.max(0.6, (1.3 * pixel) / 0.0012);
    // The canvas is pushed back by as much as its triangles may stand above the ink; a unit of depth is smaller from near.
    const unit = distance ** 2 / (this.camera.near * 2 ** 24);
    this.canvasMaterial.polygonOffsetUnits = Math.max(150, this.canvasOff / unit);
    this.force.setWidth(thick);
    this.normal.setWidth(thick);
    // Ink over ink: those below stay visible beside those above.
    this.inks.forEach((ink, k) => (ink.lines.width = this.over ? width * (1 + 0.9 * (this.inks.length - 1 - k)) : width));
    for (const lines of this.targets) lines.width = Math.max(3.4, 1.9 * width);
    this.renderer.render(this.scene, this.camera);
  }

  // A point of the canvas's frame, in W at the instant that is shown.
  placed(p: number[]): three.Vector3 {
    return this.carried.localToWorld(new three.Vector3(...p));
  }

  // Where a point of the canvas's frame stands in the picture [px], from its upper left corner.
  project(p: number[]): [number, number] {
    this.camera.updateMatrixWorld();
    const q = this.placed(p).project(this.camera);
    return [((q.x + 1) / 2) * this.canvas.clientWidth, ((1 - q.y) / 2) * this.canvas.clientHeight];
  }

  // The time of the ink nearest to a place in the picture, if there is some within a few pixels.
  timeAt(x: number, y: number, reach = 9): number | null {
    let best = reach;
    let time: number | null = null;
    const { points, time: times } = this.run.ink;
    for (let i = 0; i < times.length; ++i) {
      const [u, v] = this.project([points[0][i], points[1][i], points[2][i]]);
      const away = Math.hypot(u - x, v - y);
      if (away < best) {
        best = away;
        time = times[i];
      }
    }
    return time;
  }

  // What fails nearest to a place in the picture, within a few pixels.
  findingAt(x: number, y: number, reach = 9): Finding | null {
    let best = reach;
    let found: Finding | null = null;
    for (const finding of this.run.findings) {
      const [xs, ys, zs] = finding.line;
      for (let i = 0; i < xs.length; ++i) {
        const [u, v] = this.project([xs[i], ys[i], zs[i]]);
        const away = Math.hypot(u - x, v - y);
        if (away < best) {
          best = away;
          found = finding;
        }
      }
    }
    return found;
  }

  frames(): Record<string, number[]> {
    const out: Record<string, number[]> = {};
    this.run.arm.forEach((link, i) => {
      const e = this.links[i].matrix.elements;
      out[link.name] = [e[0], e[4], e[8], e[12], e[1], e[5], e[9], e[13], e[2], e[6], e[10], e[14]];
    });
    return out;
  }

  // The picture as it stands.
  async still(): Promise<Blob | null> {
    this.render();
    return new Promise((done) => this.canvas.toBlob(done, "image/png"));
  }
}

// Shades a body that stands still, once: light from above and from the front left.
function shade(geometry: three.BufferGeometry): Float32Array<ArrayBuffer> {
  const normals = geometry.getAttribute("normal");
  const shades = new Float32Array(3 * normals.count);
  const sun = new three.Vector3(0.55, -0.6, 0.5).normalize();
  const n = new three.Vector3();
  for (let i = 0; i < normals.count; ++i) {
    n.fromBufferAttribute(normals, i);
    shades.fill(0.36 + 0.12 * n.z + 0.72 * Math.max(0, n.dot(sun)), 3 * i, 3 * i + 3);
  }
  geometry.setAttribute("color", new three.BufferAttribute(shades, 3));
  return shades;
}

function geometryOf(kind: string, size: number[]): three.BufferGeometry | null {
  if (kind === "cylinder") return new three.CylinderGeometry(size[0], size[0], size[1], 28).rotateX(Math.PI / 2);
  if (kind === "sphere") return new three.SphereGeometry(size[0], 24, 16);
  if (kind === "box") return new three.BoxGeometry(size[0], size[1], size[2]);
  return null;
}

function rodTo(end: three.Vector3, radius: number, material: three.Material): three.Mesh | null {
  const length = end.length();
  if (length < 0.01) return null;
  const rod = new three.Mesh(new three.CapsuleGeometry(radius, length, 6, 16).translate(0, length / 2, 0), material);
  rod.quaternion.setFromUnitVectors(new three.Vector3(0, 1, 0), end.clone().divideScalar(length));
  return rod;
}

function sideways(axis: three.Vector3): three.Vector3 {
  const other = Math.abs(axis.x) < 0.9 ? new three.Vector3(1, 0, 0) : new three.Vector3(0, 1, 0);
  return other.addScaledVector(axis, -other.dot(axis)).normalize();
}
