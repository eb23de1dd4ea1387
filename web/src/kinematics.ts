// Frames of the links, from the joint positions.
import type { Link, Matrix } from "./data";

// a · b of 3×4 matrices.
export function times(a: Matrix, b: Matrix): Matrix {
  const out = new Array<number>(12);
  for (let i = 0; i < 3; ++i) {
    for (let k = 0; k < 4; ++k) {
      out[4 * i + k] = a[4 * i] * b[k] + a[4 * i + 1] * b[4 + k] + a[4 * i + 2] * b[8 + k] +
        (k === 3 ? a[4 * i + 3] : 0);
    }
  }
  return out;
}

// Rotation about a unit axis (Rodrigues).
export function rotation(axis: number[], angle: number): Matrix {
  const [x, y, z] = axis;
  const c = Math.cos(angle);
  const s = Math.sin(angle);
  const d = 1 - c;
  return [
    c + x * x * d, x * y * d - z * s, x * z * d + y * s, 0,
    y * x * d + z * s, c + y * y * d, y * z * d - x * s, 0,
    z * x * d - y * s, z * y * d + x * s, c + z * z * d, 0,
  ];
}

function translation(axis: number[], length: number): Matrix {
  return [1, 0, 0, axis[0] * length, 0, 1, 0, axis[1] * length, 0, 0, 1, axis[2] * length];
}

// X_WL of each link.
export function linkFrames(links: Link[], q: number[]): Matrix[] {
  const frames: Matrix[] = [];
  for (const link of links) {
    let X = link.pose;
    if (link.joint >= 0) {
      const turn = link.slides ? translation(link.axis, q[link.joint]) : rotation(link.axis, q[link.joint]);
      X = times(X, turn);
    }
    frames.push(link.parent < 0 ? X : times(frames[link.parent], X));
  }
  return frames;
}
