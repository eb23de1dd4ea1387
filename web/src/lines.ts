// Lines of a width in pixels, one quad a segment. three.js' own fat lines draw each segment as an
// instance, which software renderers do one by one: seconds a frame for a drawing.
import * as three from "three";

const vertexShader = `
attribute vec3 other;
attribute float side;
attribute vec3 tint;
uniform vec2 resolution;
uniform float width;
varying vec3 vTint;
void main() {
  // Vector by vector: a product of matrices at each corner costs a software renderer most of a frame.
  vec4 a = projectionMatrix * (modelViewMatrix * vec4(position, 1.0));
  vec4 b = projectionMatrix * (modelViewMatrix * vec4(other, 1.0));
  // Behind the eye, directions on the screen turn round.
  vec2 along = (b.xy / max(b.w, 1e-4) - a.xy / max(a.w, 1e-4)) * resolution;
  float size = length(along);
  along = size > 1e-6 ? along / size : vec2(1.0, 0.0);
  // Half a width beyond the end, so that segments meet without a notch.
  vec2 off = side * vec2(-along.y, along.x) - along;
  a.xy += off * width / resolution * a.w;
  gl_Position = a;
  vTint = tint;
}`;
const fragmentShader = `
uniform float opacity;
varying vec3 vTint;
void main() {
  gl_FragColor = vec4(vTint, opacity);
}`;

export class Lines extends three.Mesh<three.BufferGeometry, three.ShaderMaterial> {
  segments = 0;

  // points: pairs of ends, x y z each.
  constructor(points: number[], opacity = 1) {
    super(quads(points.length / 6), new three.ShaderMaterial({
      vertexShader, fragmentShader, side: three.DoubleSide, transparent: opacity < 1, depthWrite: opacity >= 1,
      uniforms: { resolution: { value: new three.Vector2(1, 1) }, width: { value: 2 }, opacity: { value: opacity } },
    }));
    this.frustumCulled = false;
    this.append(points);
  }

  // None of them; their room stays.
  forget(): void {
    this.segments = 0;
  }

  // More segments, which have no colour yet.
  append(points: number[]): void {
    const first = this.segments;
    this.segments += points.length / 6;
    if (4 * this.segments > this.geometry.getAttribute("side").count) {
      const larger = quads(Math.max(256, 2 * this.segments));
      for (const name of ["position", "other", "side", "tint"])
        (larger.getAttribute(name).array as Float32Array).set(this.geometry.getAttribute(name).array);
      this.geometry.dispose();
      this.geometry = larger;
    }
    const position = this.attribute("position");
    const other = this.attribute("other");
    const side = this.attribute("side");
    for (let s = first; s < this.segments; ++s) {
      const from = 6 * (s - first);
      for (let corner = 0; corner < 4; ++corner) {
        const end = corner >> 1;
        for (let axis = 0; axis < 3; ++axis) {
          position.array[12 * s + 3 * corner + axis] = points[from + 3 * end + axis];
          other.array[12 * s + 3 * corner + axis] = points[from + 3 * (1 - end) + axis];
        }
        // Seen from its own end, a corner's left is the right of the other end.
        side.array[4 * s + corner] = corner === 0 || corner === 3 ? 1 : -1;
      }
    }
    for (const attribute of [position, other, side]) this.changed(attribute, first);
  }

  private attribute(name: string): three.BufferAttribute {
    return this.geometry.getAttribute(name) as three.BufferAttribute;
  }

  private changed(attribute: three.BufferAttribute, first: number): void {
    const size = 4 * attribute.itemSize;
    attribute.addUpdateRange(first * size, (this.segments - first) * size);
    attribute.needsUpdate = true;
  }

  // [px]
  set width(width: number) {
    this.material.uniforms.width.value = width;
  }

  resize(width: number, height: number): void {
    this.material.uniforms.resolution.value.set(width, height);
  }

  // Draws the first `count` segments.
  show(count: number): void {
    this.geometry.setDrawRange(0, 6 * count);
  }

  // sRGB, 0 to 1; from segment `first` on.
  tint(colourOf: (segment: number) => [number, number, number], first = 0): void {
    const tints = this.attribute("tint");
    for (let s = first; s < this.segments; ++s) {
      const colour = colourOf(s);
      for (let corner = 0; corner < 4; ++corner) tints.array.set(colour, 12 * s + 3 * corner);
    }
    this.changed(tints, first);
  }
}

// Room for segments, four corners each.
function quads(segments: number): three.BufferGeometry {
  const geometry = new three.BufferGeometry();
  for (const [name, size] of [["position", 3], ["other", 3], ["side", 1], ["tint", 3]] as const)
    geometry.setAttribute(name, new three.BufferAttribute(new Float32Array(4 * size * segments), size));
  const index = new Uint32Array(6 * segments);
  for (let s = 0; s < segments; ++s) index.set([0, 1, 2, 0, 2, 3].map((k) => 4 * s + k), 6 * s);
  geometry.setIndex(new three.BufferAttribute(index, 1));
  return geometry;
}
