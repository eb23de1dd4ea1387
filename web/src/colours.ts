// Colours that stay apart for colour-blind eyes: Okabe and Ito's for kinds, a ramp of rising
// lightness (after matplotlib's plasma, without its pale end) for numbers.

export const kinds = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a6d3b", "#6b6b6b"];

// Of a run among those compared.
export const runColour = (k: number): string => kinds[k % kinds.length];
// Of a target without ink, and of what a run left out because it cannot be drawn.
export const bareColour = kinds[3];
export const leftOutColour = kinds[6];
// Of the k-th reason why a plan leaves something out.
const problems = [1, 3, 4, 6, 2, 5, 7].map((k) => kinds[k]).concat("#6f51c9", "#a3b300", "#8c1c3a", "#1f5c4a");
export const problemColour = (k: number): string => problems[k % problems.length];

// The same before a dark ground: half way to white.
export const onDark = (hex: string): string => `#${rgb(hex).map((x) => Math.round(127.5 * (1 + x)).toString(16).padStart(2, "0")).join("")}`;
// For a style: the one or the other, as the page is.
export const onEither = (hex: string): string => `light-dark(${hex}, ${onDark(hex)})`;
export const problemKey = (k: number): string => onEither(problemColour(k));

const ramp = ["#0d0887", "#5b02a3", "#9a179b", "#cb4678", "#eb7852", "#fbb32f"].map(rgb);

export function rgb(hex: string): [number, number, number] {
  const n = parseInt(hex.slice(1), 16);
  return [(n >> 16) / 255, ((n >> 8) & 255) / 255, (n & 255) / 255];
}

// The ramp's colour at x, 0 to 1; clamped. sRGB.
export function rampAt(x: number): [number, number, number] {
  const s = Math.min(Math.max(x, 0), 1) * (ramp.length - 1);
  const i = Math.min(Math.floor(s), ramp.length - 2);
  const f = s - i;
  return [0, 1, 2].map((k) => ramp[i][k] * (1 - f) + ramp[i + 1][k] * f) as [number, number, number];
}

export function rampCss(): string {
  const stops = ramp.map((c) => `rgb(${c.map((x) => Math.round(255 * x)).join(" ")})`);
  return `linear-gradient(90deg, ${stops.join(", ")})`;
}

// The p-quantile of the finite values; NaN if there are none.
export function quantile(values: ArrayLike<number>, p: number): number {
  const finite = Float64Array.from(Array.from(values).filter(Number.isFinite)).sort();
  if (finite.length === 0) return NaN;
  const s = p * (finite.length - 1);
  const i = Math.floor(s);
  return finite[i] + (s - i) * (finite[Math.min(i + 1, finite.length - 1)] - finite[i]);
}
