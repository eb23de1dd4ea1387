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
  vec4 a = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  vec4 b = projectionMatrix * modelViewMatrix * vec4(other, 1.0);
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
  #include <colorspace_fragment>
}`;

export class Lines extends three.Mesh<three.BufferGeometry, three.ShaderMaterial> {
  readonly segments: number;
  private tints: three.BufferAttribute;

  // points: pairs of ends, x y z each.
  constructor(points: number[], opacity = 1) {
    const segments = points.length / 6;
    const position = new Float32Array(12 * segments);
    const other = new Float32Array(12 * segments);
    const side = new Float32Array(4 * segments);
    const index = new Uint32Array(6 * segments);
    for (let s = 0; s < segments; ++s) {
      for (let corner = 0; corner < 4; ++corner) {
        const end = corner >> 1;
        for (let axis = 0; axis < 3; ++axis) {
          position[12 * s + 3 * corner + axis] = points[6 * s + 3 * end + axis];
          other[12 * s + 3 * corner + axis] = points[6 * s + 3 * (1 - end) + axis];
        }
        // Seen from its own end, a corner's left is the right of the other end.
        side[4 * s + corner] = corner === 0 || corner === 3 ? 1 : -1;
      }
      index.set([0, 1, 2, 0, 2, 3].map((k) => 4 * s + k), 6 * s);
    }
    const geometry = new three.BufferGeometry();
    geometry.setAttribute("position", new three.BufferAttribute(position, 3));
    geometry.setAttribute("other", new three.BufferAttribute(other, 3));
    geometry.setAttribute("side", new three.BufferAttribute(side, 1));
    const tints = new three.BufferAttribute(new Float32Array(12 * segments), 3);
    geometry.setAttribute("tint", tints);
    geometry.setIndex(new three.BufferAttribute(index, 1));
    super(geometry, new three.ShaderMaterial({
      vertexShader, fragmentShader, side: three.DoubleSide, transparent: opacity < 1, depthWrite: opacity >= 1,
      uniforms: { resolution: { value: new three.Vector2(1, 1) }, width: { value: 2 }, opacity: { value: opacity } },
    }));
    this.frustumCulled = false;
    this.segments = segments;
    this.tints = tints;
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

  // sRGB, 0 to 1
  tint(colourOf: (segment: number) => [number, number, number]): void {
    const linear = new three.Color();
    for (let s = 0; s < this.segments; ++s) {
      linear.setRGB(...colourOf(s), three.SRGBColorSpace);
      for (let corner = 0; corner < 4; ++corner)
        this.tints.set([linear.r, linear.g, linear.b], 12 * s + 3 * corner);
    }
    this.tints.needsUpdate = true;
  }
}
