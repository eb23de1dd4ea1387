// The link to a moment: #t=12.4&view=top&colour=force

export const viewNames = ["free", "top", "front", "side", "pen", "tip"] as const;
export type View = (typeof viewNames)[number];
// Not every page has all of them.
export const colourNames = [
  "nothing", "force", "error", "tilt", "speed", "pass", "run",
  "joint_margin", "torque", "effective_mass", "clearance", "normal_error",
] as const;
export type Colour = (typeof colourNames)[number];

export interface Moment {
  t?: number;
  view?: View;
  colour?: Colour;
}

// What is not valid is left out.
export function momentOf(hash: string): Moment {
  const given = new URLSearchParams(hash.replace(/^#/, ""));
  const moment: Moment = {};
  const t = Number(given.get("t") ?? NaN);
  if (Number.isFinite(t)) moment.t = t;
  const view = viewNames.find((name) => name === given.get("view"));
  if (view) moment.view = view;
  const colour = colourNames.find((name) => name === given.get("colour"));
  if (colour) moment.colour = colour;
  return moment;
}

export function hashOf(moment: Required<Moment>): string {
  return `#t=${Number(moment.t.toFixed(2))}&view=${moment.view}&colour=${moment.colour}`;
}
