import assert from "node:assert/strict";
import test from "node:test";
import { quantile, rampAt } from "../src/colours";
import { lastAt, unpack } from "../src/columns";
import { linkFrames, rotation } from "../src/kinematics";
import { hashOf, momentOf } from "../src/link";
import { LiveRun } from "../src/live";
import type { Run } from "../src/data";
import { History, placed, spaced, Surface, turnsRound } from "../src/placing";
import { Pyramid } from "../src/pyramid";
import { straightTo } from "../src/thin";
import { differenceText, holds } from "../src/tables";
import { numberText } from "../src/dom";

test("unpack reads differences, planes and gaps as page_json.h describes them", () => {
  // 3, 4, gap, 300: first differences 3, 1, 0, 296 → zigzag 6, 2, 0, 592 = 0x250
  const bytes = new Uint8Array([9, 6, 2, 0, 0x50, 0, 0, 0, 2, 2, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0]);
  const values = unpack(bytes, { n: 4, quantum: 0.5, order: 1, planes: 2, at: 1, runs: 3, runs_at: 9 });
  assert.deepEqual([...values], [1.5, 2, NaN, 150]);
  // negative: -1 → 1, -2 → 3
  assert.deepEqual([...unpack(new Uint8Array([1, 3]), { n: 2, quantum: 1, order: 0, planes: 1, at: 0 })], [-1, -2]);
});

test("lastAt finds the last value that is not above", () => {
  const times = [0, 1, 1, 2];
  assert.deepEqual([-0.1, 0, 0.5, 1, 1.9, 2, 9].map((t) => lastAt(times, t)), [-1, 0, 0, 2, 2, 3, 3]);
  assert.equal(lastAt([], 1), -1);
});

test("a rotation turns its own axis into itself and others by the angle", () => {
  const axis = [2 / 7, 3 / 7, 6 / 7];
  const R = rotation(axis, 1.1);
  const by = (v: number[]) => [0, 1, 2].map((i) => R[4 * i] * v[0] + R[4 * i + 1] * v[1] + R[4 * i + 2] * v[2]);
  by(axis).forEach((x, i) => assert.ok(Math.abs(x - axis[i]) < 1e-12));
  const across = [3 / Math.sqrt(13), -2 / Math.sqrt(13), 0];
  const dot = by(across).reduce((sum, x, i) => sum + x * across[i], 0);
  assert.ok(Math.abs(dot - Math.cos(1.1)) < 1e-12);
  // the right-hand rule
  const quarter = rotation([0, 0, 1], Math.PI / 2);
  assert.ok(Math.abs(quarter[4] - 1) < 1e-12 && Math.abs(quarter[1] + 1) < 1e-12);
});

test("links follow their joints: a planar arm of two", () => {
  const identity = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];
  const at = (x: number) => [1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0];
  const link = (parent: number, pose: number[], joint: number, slides = false) =>
    ({ name: "", parent, pose, axis: slides ? [1, 0, 0] : [0, 0, 1], joint, slides, shapes: [], meshes: [] });
  const arm = [link(-1, identity, -1), link(0, identity, 0), link(1, at(2), 1), link(2, at(1), -1), link(3, identity, 2, true)];
  const end = linkFrames(arm, [0.3, 0.4, 0.25])[4];
  assert.ok(Math.abs(end[3] - (2 * Math.cos(0.3) + 1.25 * Math.cos(0.7))) < 1e-12);
  assert.ok(Math.abs(end[7] - (2 * Math.sin(0.3) + 1.25 * Math.sin(0.7))) < 1e-12);
});

test("a pyramid keeps extremes at every level and gaps only where all is gap", () => {
  const n = 1000;
  const time = Array.from({ length: n }, (_, i) => i);
  const low = time.map((t) => (t % 7 === 0 ? NaN : Math.sin(t)));
  low[617] = 40;
  low[211] = -30;
  const pyramid = new Pyramid({ time, low, high: low });
  for (const most of [2000, 300, 50, 3]) {
    const level = pyramid.at(0, n, most);
    assert.ok(level.time.length <= Math.max(most, 2));
    assert.equal(Math.max(...Array.from(level.high).filter(Number.isFinite)), 40);
    assert.equal(Math.min(...Array.from(level.low).filter(Number.isFinite)), -30);
  }
  assert.equal(pyramid.at(100, 110, 50).time.length, n, "a short range is shown in full");
  assert.deepEqual(pyramid.extremes(), [-30, 40]);
});

test("a link to a moment is read as it is written, and nonsense is left out", () => {
  const moment = { t: 12.4, view: "top", colour: "force" } as const;
  assert.equal(hashOf(moment), "#t=12.4&view=top&colour=force");
  assert.deepEqual(momentOf(hashOf(moment)), moment);
  assert.deepEqual(momentOf("#t=abc&view=<b>&colour=constructor&more=1"), {});
  assert.deepEqual(momentOf(""), {});
});

test("limits hold for numbers alone", () => {
  assert.ok(holds(1, { min: 1, max: 2 }));
  assert.ok(!holds(2.1, { max: 2 }));
  assert.ok(!holds(null, { max: 2 }));
});

test("numbers are rounded, but never to what they are not", () => {
  assert.equal(numberText(0.99999), "0.999990");
  assert.equal(numberText(-0.01234567), "−0.01235");
  assert.equal(numberText(null), "–");
  assert.equal(numberText(1234.5678), "1235");
});

test("differences are signed, and rounding is none", () => {
  assert.equal(differenceText(1, 1.25), "+0.250");
  assert.equal(differenceText(2, 1.5), "−0.500");
  assert.equal(differenceText(0.1 + 0.2, 0.3), "0");
  assert.equal(differenceText(null, 1), "–");
});

test("quantiles and colours", () => {
  assert.equal(quantile([3, NaN, 1, 2], 0.5), 2);
  assert.ok(Number.isNaN(quantile([NaN], 0.5)));
  const light = (c: number[]) => 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
  for (let i = 0; i < 20; ++i) assert.ok(light(rampAt((i + 1) / 20)) > light(rampAt(i / 20)), "lightness rises");
});

test("a circle of many points is drawn by few, within the tolerance of each", () => {
  const n = 2000, radius = 0.02, off = 4e-5;
  const at = (k: number) => (2 * Math.PI * k) / n;
  const points = [Array.from({ length: n }, (_, k) => radius * Math.cos(at(k))), Array.from({ length: n }, (_, k) => radius * Math.sin(at(k))), new Array<number>(n).fill(0.1)];
  const ends = [0];
  while (ends[ends.length - 1] + 1 < n) ends.push(straightTo(points, ends[ends.length - 1], n, 1000, off));
  // A chord over the angle a stands r (1 − cos a/2) off its arc.
  const longest = 2 * Math.acos(1 - off / radius);
  assert.ok(ends.length < (2.05 * Math.PI) / longest + 2 && ends.length > (1.9 * Math.PI) / longest, `${ends.length} ends`);
  ends.slice(1).forEach((k, i) => assert.ok(radius * (1 - Math.cos((at(k) - at(ends[i])) / 2)) < 1.0001 * off));
  // A line that turns back is not shortened, nor one across points that differ, nor beyond the end.
  assert.equal(straightTo([[0, 2, 1], [0, 0, 0], [0, 0, 0]], 0, 3, 9, off), 1);
  const straight = [[0, 1, 2, 3, 4], [0, 0, 0, 0, 0], [0, 0, 0, 0, 0]];
  assert.equal(straightTo(straight, 0, 5, 9, off), 4);
  assert.equal(straightTo(straight, 0, 5, 3, off), 3);
  assert.equal(straightTo(straight, 0, 5, 9, off, (k) => k < 2), 2);
});

test("a run that goes on for hours is kept in bounded memory, and its numbers count every row", () => {
  const columns = ["time", "wall", "share", "stroke", "force", "tilt", "mode", ...["contact_point", "tip", "pen_axis", "contact_force", "normal"].flatMap((name) => ["x", "y", "z"].map((axis) => `${name}_${axis}`))];
  const straight = [0, 1, 2].map((axis) => Float64Array.from([0, axis === 0 ? 1e4 : 0]));
  const run = {
    live: { columns, duration: 1, strokes: 40 }, series: new Map(), spans: [], joints: { names: [] },
    target: { points: straight, begins: Float64Array.of(0), strokes: [0] }, ink: { colours: [] }, scene: {},
  } as unknown as Run;
  const live = new LiveRun(run, { rows: 1000, ink: 600 });
  const n = 20000, each = 500; // rows of a stroke, the last ten without ink
  let force = 0;
  for (let row = 0; row < n; ++row) {
    const values = new Float32Array(columns.length);
    const put = (name: string, x: number) => (values[columns.indexOf(name)] = x);
    const down = row % each < each - 10;
    put("time", 0.01 * (row + 1));
    put("stroke", down ? Math.floor(row / each) : -1);
    put("force", down ? 1 + (row % 7) : 0);
    put("contact_point_x", row);
    if (down) force += 1 + (row % 7);
    live.append(values);
    assert.ok(run.scene.time.length <= 1001 && run.ink.time.length <= 601);
  }
  const { ink, scene } = run;
  assert.ok(scene.time.length > 400 && ink.time.length > 250 && live.thinned > 3);
  assert.ok(Math.abs(scene.time[0] - 0.01) < 1e-6 && Math.abs(scene.time.at(-1)! - 0.01 * n) < 1e-3);
  for (let i = 1; i < scene.time.length; ++i) assert.ok(scene.time[i] > scene.time[i - 1]);
  // Each stroke still has its own line, from its first point to its last.
  assert.deepEqual([...ink.stroke], Array.from({ length: n / each }, (_, k) => k));
  [...ink.begins].forEach((begin, k) => {
    const end = (ink.begins[k + 1] ?? ink.time.length) - 1;
    assert.equal(ink.points[0][begin], k * each);
    assert.equal(ink.points[0][end], k * each + each - 11);
    assert.ok(Math.abs(ink.time[end] - 0.01 * (k * each + each - 10)) < 1e-3, "a point keeps its time");
  });
  assert.equal(run.spans.length, n / each);
  assert.ok(Math.abs(live.numbers().force - force / (n - (10 * n) / each)) < 1e-6);
});

const cells = { columns: 3, rows: 2, side: 0.1, x: 0, y: 0, heights: [0, 1, 2, 10, 11, null], troubles: [0, 0, 0, 0, 0, 1], words: [] };

test("a surface is linear between the middles of cells, and its holes are missing", () => {
  const surface = new Surface(cells, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]);
  assert.ok(Math.abs(surface.height(0.1, 0.1)! - 5.5) < 1e-12);
  assert.ok(Math.abs(surface.height(0.07, 0.08)! - (0.2 + 3)) < 1e-12);
  assert.equal(surface.height(0.25, 0.15), null);
  assert.deepEqual([surface.trouble(0.25, 0.15), surface.trouble(0.05, 0.05), surface.trouble(-0.01, 0)], [1, 0, 1]);
});

test("a point of W is found again in P, however P is turned", () => {
  const [c, s] = [Math.cos(0.3), Math.sin(0.3)];
  const surface = new Surface(cells, [c, 0, s, 0.4, 0, 1, 0, -0.1, -s, 0, c, 0.2]);
  const [x, y, z] = surface.world(0.12, 0.07, 0.3);
  const [u, v] = surface.plane({ x, y, z });
  assert.ok(Math.abs(u - 0.12) < 1e-12 && Math.abs(v - 0.07) < 1e-12);
});

test("a placed stroke is scaled, turned and moved, in this order, and spaced without losing its corners", () => {
  const line = placed([0.1, 0, 0.1, 0.1], { x: 1, y: 2, turn: 90, size: 2 });
  [1, 2.2, 0.8, 2.2].forEach((x, k) => assert.ok(Math.abs(line[k] - x) < 1e-12));
  const fine = spaced([0, 0, 0.25, 0, 0.25, 0.1], 0.1);
  assert.equal(fine.length, 2 * 5);
  assert.deepEqual(fine.slice(6), [0.25, 0, 0.25, 0.1]);
});

test("areas that are marked have the surface's size, also where they overlap or cross themselves", () => {
  const n = 100, side = 0.001, slope = 0.75;
  const heights = Array.from({ length: n * n }, (_, k) => slope * side * (k % n));
  const surface = new Surface({ columns: n, rows: n, side, x: 0, y: 0, heights, troubles: heights.map((_, k) => (k % n < 20 ? 2 : 0)), words: [] },
    [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]);
  const square = (x: number, y: number, size: number) => [x, y, x + size, y, x + size, y + size, x, y + size];
  const { all, lost } = surface.sizeOf(surface.rows([square(0.01, 0.01, 0.04), square(0.03, 0.03, 0.04)]));
  const steep = Math.hypot(1, slope);
  assert.ok(Math.abs(all - steep * (2 * 0.04 * 0.04 - 0.02 * 0.02)) < 1e-9);
  assert.ok(Math.abs(lost.get(2)! - steep * 0.01 * 0.04) < 1e-9);
  // The edge of the cells has no middle to be linear between.
  assert.deepEqual(surface.rows([square(-1, -1, 3)]).length, n);
  assert.deepEqual(surface.sizeOf(surface.rows([])).all, 0);
  // An outline that goes on beyond its beginning goes round its middle twice.
  const twice = Array.from({ length: 36 }, (_, k) => [Math.cos(k / 3), Math.sin(k / 3)]).flat();
  assert.equal(Math.abs(turnsRound(twice, 0.1, 0.1)), 2);
  assert.equal(turnsRound(twice, 1.1, 0.1), 0);
  assert.deepEqual([turnsRound(square(0, 0, 1), 0.5, 0.5), turnsRound([0, 0, 0, 1, 1, 1, 1, 0], 0.5, 0.5)], [1, -1]);
});

test("what is dragged in one go is one step back", () => {
  const at = (x: number) => ({ x, y: 0, turn: 0, size: 1 });
  const history = new History(at(0));
  history.move(at(0));
  for (let k = 1; k < 5; ++k) history.move(at(k), true);
  assert.equal(history.undo() && history.now.x, 0);
  assert.equal(history.redo() && history.now.x, 4);
  history.move(at(9));
  assert.equal(history.canRedo, false);
});
