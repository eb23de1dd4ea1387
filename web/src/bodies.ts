// Solid bodies, lit at their corners: a software renderer pays for each pixel that is lit.
import * as three from "three";
import type { Mesh } from "./data";

const toScreen = `
vec3 toScreen(vec3 c) {
  return mix(1.055 * pow(c, vec3(0.41666)) - 0.055, 12.92 * c, vec3(lessThanEqual(c, vec3(0.0031308))));
}`;
// Hemisphere of light from +y over a ground, and a sun; in W, as bright as what they hit [1/π].
const litCorners = `${toScreen}
uniform vec3 albedo;
varying vec3 vColour;
void main() {
  vec4 p = modelMatrix * vec4(position, 1.0);
  gl_Position = projectionMatrix * (viewMatrix * p);
  vec3 n = normalize(mat3(modelMatrix) * normal);
  vec3 sky = mix(vec3(0.323, 0.292, 0.262), vec3(1.0), 0.5 + 0.5 * n.y);
  vec3 light = 0.668 * sky + 0.509 * max(0.0, dot(n, vec3(0.33282, -0.44376, 0.83205)));
  vColour = toScreen(clamp(albedo * light, 0.0, 1.0));
}`;
const colouredCorners = `${toScreen}
attribute vec3 color;
uniform vec3 albedo;
varying vec3 vColour;
void main() {
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(position, 1.0));
  vColour = toScreen(clamp(albedo * color, 0.0, 1.0));
}`;
const plain = `
uniform float alpha;
varying vec3 vColour;
void main() {
  gl_FragColor = vec4(vColour, alpha);
}`;

class CornerMaterial extends three.ShaderMaterial {
  constructor(vertexShader: string, colour: three.ColorRepresentation) {
    super({ vertexShader, fragmentShader: plain, uniforms: { albedo: { value: new three.Color(colour) }, alpha: { value: 1 } } });
  }

  setColour(colour: three.ColorRepresentation): void {
    this.uniforms.albedo.value.set(colour);
  }

  // What is faint hides nothing.
  setAlpha(alpha: number): void {
    this.uniforms.alpha.value = alpha;
    this.transparent = alpha < 1;
    this.depthWrite = alpha >= 1;
    this.needsUpdate = true;
  }
}

// Lit from above and from the front left.
export class BodyMaterial extends CornerMaterial {
  constructor(colour: number) {
    super(litCorners, colour);
  }
}

// Of a surface that stands still: its corners have their shade (`color`, linear).
export class ShadedMaterial extends CornerMaterial {
  constructor() {
    super(colouredCorners, "#ffffff");
    this.side = three.DoubleSide;
    // Pushed back a little, so that ink on the surface is not hidden by it.
    this.polygonOffset = true;
    this.polygonOffsetFactor = 1;
    this.polygonOffsetUnits = 150;
  }
}

export function interleaved(points: Float64Array[]): Float32Array<ArrayBuffer> {
  const out = new Float32Array(3 * points[0].length);
  for (let axis = 0; axis < 3; ++axis) points[axis].forEach((x, i) => (out[3 * i + axis] = x));
  return out;
}

export function geometryOfMesh(mesh: Mesh): three.BufferGeometry {
  const geometry = new three.BufferGeometry();
  geometry.setAttribute("position", new three.BufferAttribute(interleaved(mesh.vertices), 3));
  geometry.setIndex(new three.BufferAttribute(Uint32Array.from(mesh.triangles), 1));
  return geometry;
}

// A body whose faces join smoothly where they meet at less than `angle` [rad]; a sharp edge has two corners in one place.
export function creased({ vertices }: Mesh, triangles: Float64Array, angle: number): three.BufferGeometry {
  const faces = triangles.length / 3;
  const sharp = Math.cos(angle);
  // Normals of the faces, as long as their area is large.
  const normal = new Float64Array(3 * faces);
  const length = new Float64Array(faces);
  const [x, y, z] = vertices;
  // What the corners share: a place, however many vertices stand there.
  const places = new Map<string, number>();
  const place = Int32Array.from(x, (_, v) => {
    const key = `${Math.round(1e6 * x[v])} ${Math.round(1e6 * y[v])} ${Math.round(1e6 * z[v])}`;
    const known = places.get(key);
    if (known === undefined) places.set(key, places.size);
    return known ?? places.size - 1;
  });
  const around: number[][] = Array.from({ length: places.size }, () => []); // faces at a place
  for (let f = 0; f < faces; ++f) {
    const [a, b, c] = [triangles[3 * f], triangles[3 * f + 1], triangles[3 * f + 2]];
    const [ux, uy, uz] = [x[b] - x[a], y[b] - y[a], z[b] - z[a]];
    const [vx, vy, vz] = [x[c] - x[a], y[c] - y[a], z[c] - z[a]];
    normal.set([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx], 3 * f);
    length[f] = Math.hypot(normal[3 * f], normal[3 * f + 1], normal[3 * f + 2]);
    for (const v of [a, b, c]) around[place[v]].push(f);
  }
  const positions: number[] = [];
  const normals: number[] = [];
  const index = new Uint32Array(3 * faces);
  const made: number[][] = Array.from({ length: places.size }, () => []); // corners at a place
  for (let f = 0; f < faces; ++f) {
    for (let k = 0; k < 3; ++k) {
      const v = triangles[3 * f + k];
      let nx = 0, ny = 0, nz = 0;
      for (const g of around[place[v]]) {
        const dot = normal[3 * f] * normal[3 * g] + normal[3 * f + 1] * normal[3 * g + 1] + normal[3 * f + 2] * normal[3 * g + 2];
        if (g !== f && !(dot > sharp * length[f] * length[g])) continue;
        nx += normal[3 * g]; ny += normal[3 * g + 1]; nz += normal[3 * g + 2];
      }
      const scale = 1 / Math.max(Math.hypot(nx, ny, nz), 1e-30);
      nx *= scale; ny *= scale; nz *= scale;
      let corner = made[place[v]].find((c) => nx * normals[3 * c] + ny * normals[3 * c + 1] + nz * normals[3 * c + 2] > 0.9998);
      if (corner === undefined) {
        corner = positions.length / 3;
        positions.push(x[v], y[v], z[v]);
        normals.push(nx, ny, nz);
        made[place[v]].push(corner);
      }
      index[3 * f + k] = corner;
    }
  }
  const geometry = new three.BufferGeometry();
  geometry.setAttribute("position", new three.Float32BufferAttribute(positions, 3));
  geometry.setAttribute("normal", new three.Float32BufferAttribute(normals, 3));
  geometry.setIndex(new three.BufferAttribute(index, 1));
  return geometry;
}
