// Follows a run that goes on: rows come over a WebSocket (src/live/live_server.h) and lengthen the
// columns of a Run in place.
import { inflate, parse, type Run, type Series } from "./data";

// A column that grows.
export class Column {
  private data = new Float64Array(1024);
  private n = 0;

  push(x: number): void {
    if (this.n === this.data.length) {
      const longer = new Float64Array(2 * this.n);
      longer.set(this.data);
      this.data = longer;
    }
    this.data[this.n++] = x;
  }

  get values(): Float64Array {
    return this.data.subarray(0, this.n);
  }

  last(): number {
    return this.n > 0 ? this.data[this.n - 1] : NaN;
  }

  // Keeps those whose index is in `kept`, which rises.
  thin(kept: number[]): void {
    kept.forEach((from, to) => (this.data[to] = this.data[from]));
    this.n = kept.length;
  }
}

// The memory of a run that lasts for hours is bounded: beyond this many rows, or points of ink, every second one goes. The report
// has all of them.
const mostRows = 60000;
const mostInk = 60000;

const inkForce = 0.1; // [N]; less leaves no ink, as in the metrics

// The run's target by stroke; where on it the ink was last, so that the next search is short.
class Targets {
  private parts: { stroke: number; begin: number; end: number; at: number }[];

  constructor(private points: Float64Array[], begins: Float64Array, strokes: number[]) {
    this.parts = strokes.map((stroke, k) => ({
      stroke, begin: begins[k], end: k + 1 < begins.length ? begins[k + 1] : points[0].length, at: begins[k],
    }));
  }

  // Distance to the stroke's target [m]; NaN if it has none.
  distance(stroke: number, p: number[]): number {
    let best = NaN;
    for (const part of this.parts) {
      if (part.stroke !== stroke) continue;
      let d = this.search(part, p, Math.max(part.begin, part.at - 100), Math.min(part.end, part.at + 100));
      if (!(d < 2e-3)) d = this.search(part, p, part.begin, part.end);
      if (!(best <= d)) best = d;
    }
    return best;
  }

  private search(part: { at: number }, p: number[], from: number, to: number): number {
    const [x, y, z] = this.points;
    let best = Infinity;
    for (let i = from; i < to; ++i) {
      const k = Math.min(i + 1, to - 1);
      const d = [x[k] - x[i], y[k] - y[i], z[k] - z[i]];
      const r = [p[0] - x[i], p[1] - y[i], p[2] - z[i]];
      const length = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
      const f = length > 0 ? Math.min(1, Math.max(0, (d[0] * r[0] + d[1] * r[1] + d[2] * r[2]) / length)) : 0;
      const away = Math.hypot(r[0] - f * d[0], r[1] - f * d[1], r[2] - f * d[2]);
      if (away < best) {
        best = away;
        part.at = i;
      }
    }
    return best;
  }
}

// What the numbers of a run that goes on show.
export interface LiveNumbers {
  share: number;
  rate: number; // seconds of the run a second, of late
  force: number;
  forceSd: number;
  error: number; // RMS [mm]
  errorMax: number;
  tilt: number;
}

export class LiveRun {
  private index = new Map<string, number>();
  private columns: Column[];
  private more = new Map<string, Column>(["ink_error", "speed"].map((name) => [name, new Column()]));
  private ink = { points: [new Column(), new Column(), new Column()], time: new Column(), force: new Column(), error: new Column(), tilt: new Column(), speed: new Column(), begins: new Column(), stroke: new Column(), pass: new Column() };
  private targets: Targets;
  private lastInk: { stroke: number; time: number; p: number[] } | null = null;
  private passes = new Map<number, number>();
  private sums = { n: 0, force: 0, force2: 0, error2: 0, errors: 0, errorMax: 0, tilt: 0, tilts: 0 };
  readonly width: number;
  thinned = 0; // times that points of the ink have gone

  constructor(readonly run: Run, private most = { rows: mostRows, ink: mostInk }) {
    const names = run.live?.columns ?? [];
    this.width = names.length;
    names.forEach((name, i) => this.index.set(name, i));
    this.columns = names.map(() => new Column());
    this.targets = new Targets(run.target.points, run.target.begins, run.target.strokes);
    const series = (name: string): Series => ({ name, label: name, unit: "", time: new Float64Array(), low: new Float64Array(), high: new Float64Array(), rowsPerPoint: 1 });
    for (const name of [...names, ...this.more.keys()]) run.series.set(name, series(name));
  }

  private of(name: string): Column {
    return this.columns[this.index.get(name) ?? 0];
  }

  get lastTime(): number {
    return this.of("time").last();
  }

  // Rows one after the other, `width` numbers each; those that are not newer are left out.
  append(rows: Float32Array): void {
    const at = (row: number, name: string) => rows[row + (this.index.get(name) ?? 0)];
    const triple = (row: number, name: string) => ["x", "y", "z"].map((axis) => at(row, `${name}_${axis}`));
    for (let row = 0; row + this.width <= rows.length; row += this.width) {
      const time = at(row, "time");
      if (time <= this.lastTime) continue;
      for (let k = 0; k < this.width; ++k) this.columns[k].push(rows[row + k]);
      const force = at(row, "force");
      const stroke = at(row, "stroke");
      const p = triple(row, "contact_point");
      const writes = force > inkForce && Number.isFinite(p[0]);
      this.addSpan(stroke, time);
      let error = NaN;
      let speed = NaN;
      if (writes) {
        error = 1e3 * (stroke >= 0 ? this.targets.distance(stroke, p) : NaN);
        const before = this.lastInk;
        const goesOn = before !== null && before.stroke === stroke;
        if (!goesOn) {
          this.ink.begins.push(this.ink.time.values.length);
          this.ink.stroke.push(stroke);
          this.ink.pass.push(this.passes.get(stroke) ?? 1);
        } else if (stroke >= 0) {
          speed = (1e3 * Math.hypot(p[0] - before.p[0], p[1] - before.p[1], p[2] - before.p[2])) / (time - before.time);
        }
        const tilt = at(row, "tilt");
        this.ink.points.forEach((column, axis) => column.push(p[axis]));
        this.ink.time.push(time);
        this.ink.force.push(force);
        this.ink.error.push(error);
        this.ink.tilt.push(tilt);
        this.ink.speed.push(speed);
        this.lastInk = { stroke, time, p };
        if (stroke >= 0) this.count(force, error, tilt);
      } else {
        this.lastInk = null;
      }
      this.more.get("ink_error")?.push(error);
      this.more.get("speed")?.push(speed);
    }
    if (this.of("time").values.length > this.most.rows) this.thinRows();
    if (this.ink.time.values.length > this.most.ink) this.thinInk();
    this.publish();
  }

  // The last two stay: what comes next is compared with them.
  private thinRows(): void {
    const n = this.of("time").values.length;
    const kept: number[] = [];
    for (let i = 0; i < n; ++i) if (i % 2 === 0 || i >= n - 2) kept.push(i);
    for (const column of [...this.columns, ...this.more.values()]) column.thin(kept);
  }

  // A line's ends stay.
  private thinInk(): void {
    const { ink } = this;
    const begins = Array.from(ink.begins.values);
    const n = ink.time.values.length;
    const kept: number[] = [];
    begins.forEach((begin, line) => {
      const end = begins[line + 1] ?? n;
      ink.begins.values[line] = kept.length;
      for (let i = begin; i < end; ++i) if ((i - begin) % 2 === 0 || i === end - 1) kept.push(i);
    });
    for (const column of [...ink.points, ink.time, ink.force, ink.error, ink.tilt, ink.speed]) column.thin(kept);
    ++this.thinned;
  }

  private addSpan(stroke: number, time: number): void {
    const { spans } = this.run;
    const last = spans.at(-1);
    if (stroke < 0) return;
    if (last && last[0] === stroke && this.wasDown) {
      last[2] = time;
    } else {
      this.passes.set(stroke, (this.passes.get(stroke) ?? 0) + 1);
      spans.push([stroke, time, time]);
    }
  }

  // The plan was on a stroke in the row before the last.
  private get wasDown(): boolean {
    const strokes = this.of("stroke").values;
    return strokes.length > 1 && strokes[strokes.length - 2] >= 0;
  }

  private count(force: number, error: number, tilt: number): void {
    const s = this.sums;
    s.n += 1;
    s.force += force;
    s.force2 += force * force;
    if (Number.isFinite(error)) {
      s.errors += 1;
      s.error2 += error * error;
      s.errorMax = Math.max(s.errorMax, error);
    }
    if (Number.isFinite(tilt)) {
      s.tilts += 1;
      s.tilt += tilt;
    }
  }

  // The run's columns are as long as what has come.
  private publish(): void {
    const { run } = this;
    const of = (name: string) => this.of(name).values;
    const triple = (name: string) => ["x", "y", "z"].map((axis) => of(`${name}_${axis}`));
    run.scene = {
      time: of("time"), joints: run.joints.names.map((_, j) => of(`position_${j}`)), tip: triple("tip"),
      penAxis: triple("pen_axis"), force: triple("contact_force"), normal: triple("normal"),
      canvas: this.index.has("canvas_pose_x") ? ["x", "y", "z", "qw", "qx", "qy", "qz"].map((name) => of(`canvas_pose_${name}`)) : [],
      mode: of("mode"), stroke: of("stroke"),
    };
    run.duration = this.lastTime;
    const { ink } = this;
    run.ink.points = ink.points.map((column) => column.values);
    run.ink.time = ink.time.values;
    run.ink.begins = ink.begins.values;
    run.ink.stroke = ink.stroke.values;
    run.ink.pass = ink.pass.values;
    for (const colour of run.ink.colours)
      colour.values = { force: ink.force, error: ink.error, tilt: ink.tilt, speed: ink.speed }[colour.name]?.values ?? colour.values;
    for (const [name, series] of run.series) {
      series.time = of("time");
      series.low = series.high = (this.more.get(name) ?? this.of(name)).values;
    }
  }

  numbers(): LiveNumbers {
    const s = this.sums;
    const mean = s.force / s.n;
    const time = this.of("time").values;
    const wall = this.of("wall").values;
    // Over the last second of the wall clock, or as much as there is.
    let i = wall.length - 1;
    while (i > 0 && wall[wall.length - 1] - wall[i] < 1000) --i;
    const last = wall.length - 1;
    return {
      share: this.of("share").last(), rate: last > i ? (1000 * (time[last] - time[i])) / (wall[last] - wall[i]) : NaN,
      force: mean, forceSd: Math.sqrt(Math.max(0, s.force2 / s.n - mean * mean)),
      error: Math.sqrt(s.error2 / s.errors), errorMax: s.errors ? s.errorMax : NaN, tilt: s.tilt / s.tilts,
    };
  }
}

export type LiveState = "connecting" | "running" | "paused" | "ending" | "finished" | "lost";

// The connection to the run's program. It is made again whenever it breaks.
export class LiveLink {
  state: LiveState = "connecting";
  stopping = false;
  onRows: (rows: Float32Array) => void = () => {};
  onState: () => void = () => {};
  onReport: (run: Run | null) => void = () => {};
  private socket: WebSocket | null = null;
  private failures = 0;
  private over = false;

  constructor(private since: () => number) {
    this.connect();
  }

  send(command: "pause" | "resume" | "stop" | "emergency"): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(command);
  }

  // For tests: the connection breaks.
  drop(): void {
    this.socket?.close();
  }

  private connect(): void {
    const token = new URLSearchParams(location.search).get("token") ?? "";
    const since = this.since();
    const socket = new WebSocket(`ws://${location.host}/live?token=${encodeURIComponent(token)}${since > 0 ? `&since=${since}` : ""}`);
    this.socket = socket;
    socket.binaryType = "arraybuffer";
    socket.onmessage = ({ data }) => {
      this.failures = 0;
      if (typeof data === "string") {
        const message = JSON.parse(data) as { state: LiveState; stopping: boolean };
        this.stopping = message.stopping;
        this.setState(message.state);
      } else {
        this.take(data as ArrayBuffer);
      }
    };
    socket.onclose = () => {
      if (this.over) return;
      this.failures += 1;
      this.setState(this.failures > 2 ? "lost" : "connecting");
      setTimeout(() => this.connect(), Math.min(5000, 250 * 2 ** Math.min(this.failures, 5)));
    };
  }

  private take(data: ArrayBuffer): void {
    const head = new DataView(data);
    if (head.getUint32(0, true) === 0) return this.onRows(new Float32Array(data, 8));
    this.over = true;
    const text = new TextDecoder().decode(new Uint8Array(data, 4));
    void (text ? inflate(text).then(parse) : Promise.resolve(null)).catch(() => null).then((run) => {
      this.onReport(run);
      this.socket?.close();
    });
  }

  private setState(state: LiveState): void {
    this.state = state;
    this.onState();
  }
}
