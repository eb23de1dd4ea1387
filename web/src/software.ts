// A browser that draws without a graphics card.

let known: boolean | null = null;

// Smooth edges and more than a million pixels would cost most of such a renderer's time.
export function inSoftware(): boolean {
  return (known ??= look());
}

function look(): boolean {
  const gl = document.createElement("canvas").getContext("webgl2");
  if (!gl) return false;
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  const name = String(info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "");
  gl.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software/i.test(name);
}

// Fewer triangles will do: each costs such a renderer time. A film has all of them.
export function wantsCoarse(): boolean {
  return inSoftware() && !window.impedrawFine;
}

declare global {
  interface Window {
    impedrawFine?: boolean;
  }
}

// Makes something that draws on 2-D canvases. Without a graphics card these are painted by the processor at once: through an
// emulated card, the plots of a long run took seconds, in which the scene stood.
export function withPlainCanvases<T>(make: () => T): T {
  if (!inSoftware()) return make();
  const { getContext } = HTMLCanvasElement.prototype;
  HTMLCanvasElement.prototype.getContext = function (this: HTMLCanvasElement, kind: string, options?: object) {
    return getContext.call(this, kind, kind === "2d" ? { ...options, willReadFrequently: true } : options);
  } as typeof getContext;
  try {
    return make();
  } finally {
    HTMLCanvasElement.prototype.getContext = getContext;
  }
}
