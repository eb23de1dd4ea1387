// The drawing on the surface, as the page of ./impedraw place computes it while it is dragged.

export interface Cells {
  columns: number;
  rows: number;
  side: number; // [m]
  x: number; // of the lowest corner, in the drawing plane P [m]
  y: number;
  heights: (number | null)[]; // in P [m]
  troubles: number[]; // index in words; 0: none
  words: string[];
}

export interface Place {
  x: number; // of the drawing's middle, in P [m]
  y: number;
  turn: number; // from the given one, counter-clockwise [deg]
  size: number; // times the given one
}

export const missing = 1;

export class Surface {
  constructor(readonly cells: Cells, private X_WP: number[]) {}

  private index(x: number, y: number): number {
    const c = this.cells;
    const i = Math.floor((x - c.x) / c.side), j = Math.floor((y - c.y) / c.side);
    return i >= 0 && j >= 0 && i < c.columns && j < c.rows ? j * c.columns + i : -1;
  }

  trouble(x: number, y: number): number {
    const k = this.index(x, y);
    return k < 0 ? missing : this.cells.troubles[k];
  }

  // Between the middles of cells; null where one of them has no surface.
  height(x: number, y: number): number | null {
    const c = this.cells;
    const u = (x - c.x) / c.side - 0.5, v = (y - c.y) / c.side - 0.5;
    const i = Math.floor(u), j = Math.floor(v);
    const corner = (a: number, b: number): number | null =>
      a >= 0 && b >= 0 && a < c.columns && b < c.rows ? c.heights[b * c.columns + a] : null;
    const [p, q, r, s] = [corner(i, j), corner(i + 1, j), corner(i, j + 1), corner(i + 1, j + 1)];
    if (p === null || q === null || r === null || s === null) {
      const k = this.index(x, y);
      return k < 0 ? null : c.heights[k];
    }
    const f = u - i, g = v - j;
    return (1 - g) * ((1 - f) * p + f * q) + g * ((1 - f) * r + f * s);
  }

  world(x: number, y: number, z: number): [number, number, number] {
    const X = this.X_WP;
    return [0, 1, 2].map((r) => X[4 * r] * x + X[4 * r + 1] * y + X[4 * r + 2] * z + X[4 * r + 3]) as [number, number, number];
  }

  // Of a point of W, in P.
  plane(p: { x: number; y: number; z: number }): [number, number] {
    const X = this.X_WP;
    const d = [p.x - X[3], p.y - X[7], p.z - X[11]];
    return [0, 1].map((c) => X[c] * d[0] + X[4 + c] * d[1] + X[8 + c] * d[2]) as [number, number];
  }

  // Rows of cells in areas that were marked, each from its beginning to its end: x, y by turns. Of an outline that crosses itself,
  // all that it goes round is marked.
  rows(areas: number[][]): number[][] {
    const c = this.cells, out: number[][] = [];
    for (let j = 0; j < c.rows; ++j) {
      const y = c.y + (j + 0.5) * c.side;
      const crossed = areas.map((area) => crossings(area, y));
      let begin = -1;
      for (let i = 0; i <= c.columns; ++i) {
        const x = c.x + (i + 0.5) * c.side;
        const within = i < c.columns && crossed.some((edges) => turnsAt(edges, x) !== 0);
        if (within && begin < 0) begin = i;
        if (within || begin < 0) continue;
        out.push([c.x + begin * c.side, y, c.x + i * c.side, y]);
        begin = -1;
      }
    }
    return out;
  }

  // Of rows of cells: what is there, and what of it has each trouble, on the surface [m²].
  sizeOf(rows: number[][]): { all: number; lost: Map<number, number> } {
    const c = this.cells, lost = new Map<number, number>();
    let all = 0;
    for (const [from, y, to] of rows)
      for (let x = from + c.side / 2; x < to; x += c.side) {
        const at = (dx: number, dy: number): number => this.height(x + dx, y + dy) ?? NaN;
        const u = at(c.side, 0) - at(-c.side, 0), v = at(0, c.side) - at(0, -c.side);
        const size = c.side * Math.hypot(c.side, (u || 0) / 2, (v || 0) / 2), trouble = this.trouble(x, y);
        all += size;
        if (trouble !== 0) lost.set(trouble, (lost.get(trouble) ?? 0) + size);
      }
    return { all, lost };
  }

  // The highest known point, for what lies off the surface.
  top(): number {
    return this.cells.heights.reduce<number>((a, b) => (b !== null && b > a ? b : a), 0);
  }
}

// Where an outline crosses the line at y: x, and 1 upwards or −1 downwards.
function crossings(outline: number[], y: number): [number, number][] {
  const out: [number, number][] = [];
  for (let k = 0, n = outline.length; k < n; k += 2) {
    const ax = outline[k], ay = outline[k + 1], bx = outline[(k + 2) % n], by = outline[(k + 3) % n];
    if (ay <= y !== by <= y) out.push([ax + ((bx - ax) * (y - ay)) / (by - ay), by > ay ? 1 : -1]);
  }
  return out;
}

const turnsAt = (edges: [number, number][], x: number): number => edges.reduce((turns, [at, way]) => (at > x ? turns + way : turns), 0);

// How often an outline goes round a point, counter-clockwise.
export const turnsRound = (outline: number[], x: number, y: number): number => turnsAt(crossings(outline, y), x);

// x and y by turns, about the drawing's middle [m].
export function placed(stroke: number[], place: Place): number[] {
  const c = place.size * Math.cos((place.turn * Math.PI) / 180), s = place.size * Math.sin((place.turn * Math.PI) / 180);
  const out: number[] = [];
  for (let k = 0; k < stroke.length; k += 2)
    out.push(place.x + c * stroke[k] - s * stroke[k + 1], place.y + s * stroke[k] + c * stroke[k + 1]);
  return out;
}

// The same with points no further apart than `step` [m].
export function spaced(line: number[], step: number): number[] {
  const out = line.slice(0, 2);
  for (let k = 2; k < line.length; k += 2) {
    const dx = line[k] - line[k - 2], dy = line[k + 1] - line[k - 1];
    const parts = Math.max(1, Math.ceil(Math.hypot(dx, dy) / step));
    for (let n = 1; n <= parts; ++n) out.push(line[k - 2] + (dx * n) / parts, line[k - 1] + (dy * n) / parts);
  }
  return out;
}

// States that can be gone back to. What is dragged or typed in one go is one of them.
export class History<T> {
  private past: T[] = [];
  private future: T[] = [];
  constructor(public now: T) {}

  move(to: T, goesOn = false): void {
    if (!goesOn) {
      this.past.push(this.now);
      this.future = [];
    }
    this.now = to;
  }
  undo(): boolean {
    const last = this.past.pop();
    if (!last) return false;
    this.future.push(this.now);
    this.now = last;
    return true;
  }
  redo(): boolean {
    const next = this.future.pop();
    if (!next) return false;
    this.past.push(this.now);
    this.now = next;
    return true;
  }
  get canUndo(): boolean {
    return this.past.length > 0;
  }
  get canRedo(): boolean {
    return this.future.length > 0;
  }
}
