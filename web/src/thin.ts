// Lines of fewer points, where these are nearly straight.

// How far a line from point `from` may leave out what lies between: all of that stands within `off` of it, in order [m].
// At most `most` steps, before point `end`, and only over points that are `alike`.
export function straightTo(points: ArrayLike<number>[], from: number, end: number, most: number, off: number, alike: (k: number) => boolean = () => true): number {
  let next = from + 1;
  while (next + 1 < end && next - from < most && alike(next) && isStraight(points, from, next + 1, off)) ++next;
  return next;
}

function isStraight([x, y, z]: ArrayLike<number>[], i: number, k: number, off: number): boolean {
  const [ax, ay, az] = [x[k] - x[i], y[k] - y[i], z[k] - z[i]];
  const square = Math.max(ax * ax + ay * ay + az * az, 1e-18);
  for (let j = i + 1; j < k; ++j) {
    const [bx, by, bz] = [x[j] - x[i], y[j] - y[i], z[j] - z[i]];
    const f = (ax * bx + ay * by + az * bz) / square;
    if (f < 0 || f > 1 || Math.hypot(bx - f * ax, by - f * ay, bz - f * az) > off) return false;
  }
  return true;
}
