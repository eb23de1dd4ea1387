// Elements. Text from files enters the page through here alone, and only as text.

type Child = Node | string | null | undefined;

export function h<K extends keyof HTMLElementTagNameMap>(
  tag: K, attributes: Record<string, string | number | boolean | undefined> = {}, ...children: Child[]
): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === false) continue;
    element.setAttribute(name, value === true ? "" : String(value));
  }
  for (const child of children) if (child !== null && child !== undefined) element.append(child);
  return element;
}

// Rounds to significant digits, with a true minus. No value is a dash.
export function numberText(value: unknown, digits = 4): string {
  if (typeof value !== "number" || !Number.isFinite(value)) return "–";
  if (Number.isInteger(value) && Math.abs(value) < 1e9) return String(value).replace("-", "−");
  const size = Math.floor(Math.log10(Math.abs(value)));
  let text = size < -6 ? value.toExponential(1) : value.toFixed(Math.max(0, Math.min(6, digits - 1 - size)));
  if (value < 1 && Number(text) === 1) text = value.toFixed(6); // 0.99999 must not read as 1
  return text.replace("-", "−");
}

export function timeText(seconds: number): string {
  return `${seconds.toFixed(2)} s`;
}

export function save(name: string, content: Blob): void {
  const url = URL.createObjectURL(content);
  h("a", { href: url, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(url), 10_000);
}
