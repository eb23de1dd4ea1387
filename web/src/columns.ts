// Reads what src/page/page_json.cc packs; the layout is described in its header.

export interface Packed {
  n: number;
  quantum: number;
  order: number;
  planes: number;
  at: number;
  runs?: number;
  runs_at?: number;
}

export function unpack(bytes: Uint8Array, how: Packed): Float64Array {
  const { n, planes, at } = how;
  const k = new Float64Array(n); // whole numbers; their sums stay below 2^53
  for (let i = 0; i < n; ++i) {
    let code = 0;
    let scale = 1;
    for (let plane = 0; plane < planes; ++plane, scale *= 256)
      code += bytes[at + plane * n + i] * scale;
    k[i] = code % 2 === 1 ? -(code + 1) / 2 : code / 2;
  }
  for (let pass = 0; pass < how.order; ++pass)
    for (let i = 1; i < n; ++i) k[i] += k[i - 1];
  for (let i = 0; i < n; ++i) k[i] *= how.quantum;
  if (how.runs && how.runs_at !== undefined) {
    const view = new DataView(bytes.buffer, bytes.byteOffset + how.runs_at, 4 * how.runs);
    let i = 0;
    for (let run = 0; run < how.runs; ++run) {
      const length = view.getUint32(4 * run, true);
      if (run % 2 === 1) k.fill(NaN, i, i + length);
      i += length;
    }
  }
  return k;
}

// The index of the last value that is not above t; -1 if all are above. `times` do not decrease.
export function lastAt(times: ArrayLike<number>, t: number): number {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}
