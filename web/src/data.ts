// The page's data, as src/page/replay.cc writes it.
import { unpack, type Packed } from "./columns";

export type Matrix = number[]; // 3×4, row by row

export interface Link {
  name: string;
  parent: number;
  pose: Matrix;
  axis: number[];
  joint: number;
  slides: boolean;
  shapes: { kind: "cylinder" | "sphere" | "box" | "mesh"; pose: Matrix; size: number[] }[];
  meshes: Mesh[]; // drawn in place of the shapes
}

export interface Mesh {
  vertices: Float64Array[];
  triangles: Float64Array;
  coarse: Float64Array | null; // fewer triangles on the same vertices, for who has no graphics card
  of: number; // triangles of the whole
  error_mm: number;
}

// What the ink, or the canvas, can be coloured by.
export interface Colouring {
  name: string;
  label: string;
  unit: string;
  values: Float64Array;
}

// A part of a stroke that a plan, or a run, leaves out.
export interface Finding {
  stroke: number;
  from_mm: number;
  to_mm: number;
  problem: string;
  text: string;
  world_m: number[];
  line: Float64Array[];
  q: (number | null)[];
}

export interface Limit {
  min?: number;
  max?: number;
}

export interface Series {
  name: string;
  label: string;
  unit: string;
  time: Float64Array;
  low: Float64Array;
  high: Float64Array; // the same array as `low` where every row is shown
  rowsPerPoint: number;
}

export interface Part {
  stroke: number;
  from_mm: number;
  to_mm: number;
  problem?: string;
  text?: string;
  world_m?: number[];
  line_m?: number[]; // x y z of point after point
}

export interface Run {
  kind: "run" | "plan" | "live";
  live: { columns: string[]; duration: number; strokes: number } | null; // of a run that goes on
  name: string; // among runs compared
  title: string;
  version: string;
  commit: string;
  command: string;
  attributes: Record<string, string>;
  closed: boolean;
  complete: boolean;
  duration: number;
  definitions: { name: string; unit: string; meaning: string }[];
  metrics: Record<string, unknown>;
  limits: Record<string, Limit>;
  settings: string[][];
  scenario: string;
  strokes: { not_drawable?: Part[]; drawn_again?: Part[]; lacking?: Part[]; [key: string]: unknown };
  joints: {
    names: string[];
    lower: (number | null)[];
    upper: (number | null)[];
    speed: (number | null)[];
    torque: (number | null)[];
  };
  modes: string[];
  arm: Link[];
  armNotice: string; // copyright and licence of the links' meshes
  cameras: { pose: Matrix; fov_y_deg: number; aspect: number }[];
  drawingAxis: number[];
  drawingUp: number[];
  inkWidth: number; // [mm]
  spans: number[][]; // stroke, begin, end
  canvas: Mesh;
  maps: Colouring[]; // of the canvas's vertices
  findings: Finding[];
  plan: Record<string, unknown>; // as plan.json
  cloud: { points: Float64Array[]; colour: Float64Array; of: number }; // colour: 0xRRGGBB; may be empty
  target: { points: Float64Array[]; covered: Float64Array; begins: Float64Array; strokes: number[] };
  ink: {
    points: Float64Array[];
    time: Float64Array;
    colours: Colouring[];
    begins: Float64Array;
    stroke: Float64Array;
    pass: Float64Array;
  };
  scene: {
    time: Float64Array;
    joints: Float64Array[];
    tip: Float64Array[];
    penAxis: Float64Array[];
    force: Float64Array[];
    normal: Float64Array[];
    canvas: Float64Array[]; // pose of its frame: x y z, then quaternion w x y z; none: it stands
    mode: Float64Array;
    stroke: Float64Array;
  };
  series: Map<string, Series>;
  terms: string[];
  stepTimes: { edges: number[]; counts: number[] } | null;
  pictures: { title: string; type: string; content: Uint8Array<ArrayBuffer> }[];
}

export async function inflate(base64: string): Promise<Uint8Array<ArrayBuffer>> {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Of a run, whose log has no lines of what it does not draw. Those of older versions told only a place.
function leftOut(parts: Part[] = []): Finding[] {
  return parts.filter((part) => part.line_m && part.line_m.length >= 3).map((part) => {
    const flat = part.line_m as number[];
    const line = [0, 1, 2].map((axis) => Float64Array.from(flat.filter((_, i) => i % 3 === axis)));
    return {
      stroke: part.stroke, from_mm: part.from_mm, to_mm: part.to_mm, problem: part.problem ?? "", text: part.text ?? "",
      world_m: part.world_m ?? line.map((column) => column[0]), line, q: [],
    };
  });
}

/* eslint-disable @typescript-eslint/no-explicit-any */
export function parse(data: Uint8Array<ArrayBuffer>): Run {
  const length = new DataView(data.buffer, data.byteOffset).getUint32(0, true);
  const json: any = JSON.parse(new TextDecoder().decode(data.subarray(4, 4 + length)));
  if (json.format !== 1) throw new Error(`this page cannot read data of format ${json.format}`);
  const columns = data.subarray(4 + length);
  const one = (how: Packed) => unpack(columns, how);
  const each = (list: Packed[]) => list.map(one);
  const mesh = (m: any): Mesh => ({ of: m.of, error_mm: m.error_mm, vertices: each(m.vertices), triangles: one(m.triangles), coarse: m.coarse ? one(m.coarse) : null });
  const colouring = (c: any): Colouring => ({ name: c.name, label: c.label, unit: c.unit, values: one(c.values) });
  const ofRun = () => [["force", "normal force", "N"], ["error", "ink error", "mm"], ["tilt", "tilt", "deg"], ["speed", "speed", "mm/s"]]
    .map(([name, label, unit]) => ({ name, label, unit, values: one(json.ink[name]) }));

  const series = new Map<string, Series>();
  for (const group of [json.step_plots, json.joint_plots, json.torque_plots]) {
    const time = one(group.time);
    for (const s of group.series) {
      const low = one(s.low);
      const high = s.high ? one(s.high) : low;
      series.set(s.name, {
        name: s.name, label: s.label, unit: s.unit, time, low, high,
        rowsPerPoint: group.rows_per_point,
      });
    }
  }
  return {
    kind: json.kind ?? "run", live: json.live ?? null, name: json.name ?? json.title, commit: json.commit ?? "",
    maps: (json.maps ?? []).map(colouring), plan: json.plan ?? {},
    findings: json.findings ? json.findings.map((f: any) => ({ ...f, line: each(f.line) })) : leftOut(json.strokes?.not_drawable),
    title: json.title, version: json.version, command: json.command, attributes: json.attributes,
    closed: json.closed, complete: json.complete, duration: json.duration,
    definitions: json.definitions, metrics: json.metrics, limits: json.limits ?? {},
    settings: json.settings, scenario: json.scenario, strokes: json.strokes, joints: json.joints,
    modes: json.modes, cameras: json.cameras, drawingAxis: json.drawing_axis,
    drawingUp: json.drawing_up, inkWidth: json.ink_width_mm, spans: json.spans,
    arm: json.arm.map((link: any) => ({ ...link, meshes: (link.meshes ?? []).map(mesh) })),
    armNotice: json.arm_notice ?? "",
    canvas: mesh(json.canvas),
    cloud: { ...json.cloud, points: each(json.cloud.points), colour: one(json.cloud.colour) },
    target: {
      points: each(json.target.points), covered: one(json.target.covered),
      begins: one(json.target.begins), strokes: json.target.strokes,
    },
    ink: {
      points: each(json.ink.points), time: one(json.ink.time),
      colours: json.ink.colours ? json.ink.colours.map(colouring) : ofRun(),
      begins: one(json.ink.begins), stroke: one(json.ink.stroke), pass: one(json.ink.pass),
    },
    scene: {
      time: one(json.scene.time), joints: each(json.scene.joints), tip: each(json.scene.tip),
      penAxis: each(json.scene.pen_axis), force: each(json.scene.force),
      normal: each(json.scene.normal), canvas: each(json.scene.canvas ?? []), mode: one(json.scene.mode), stroke: one(json.scene.stroke),
    },
    series,
    terms: json.torque_plots.terms,
    stepTimes: json.step_times,
    pictures: json.pictures.map((p: any) => ({
      title: p.title, type: p.type, content: columns.slice(p.at, p.at + p.bytes),
    })),
  };
}
