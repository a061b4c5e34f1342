// One model in a scene of its own: its parts, and what of them is seen at a time.

import { LINE, SURFACE, VERTEX } from './shaders.js';
import {
  BufferAttribute,
  BufferGeometry,
  CustomBlending,
  DoubleSide,
  LineSegments,
  Mesh,
  OneFactor,
  OneMinusSrcAlphaFactor,
  Scene,
  ShaderMaterial,
  Vector2,
  Vector3,
  Vector4,
} from './three-global.js';
import { strike } from './strike.js';

/** Vertex normals of each frame, eight bits for each component, padded to four bytes. */
function normals(part, frame) {
  const { positions, triangles, vertices, low, high } = part;
  const sum = new Float32Array(3 * vertices);
  const scale = high.map((top, axis) => (top - low[axis]) / 65535);
  const start = 3 * vertices * frame;
  const side = (from, to, axis) =>
    (positions[start + 3 * to + axis] - positions[start + 3 * from + axis]) * scale[axis];
  for (let i = 0; i < triangles.length; i += 3) {
    const [a, b, c] = [triangles[i], triangles[i + 1], triangles[i + 2]];
    const [ux, uy, uz] = [side(a, b, 0), side(a, b, 1), side(a, b, 2)];
    const [vx, vy, vz] = [side(a, c, 0), side(a, c, 1), side(a, c, 2)];
    const normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    for (const vertex of [a, b, c]) {
      for (let axis = 0; axis < 3; axis++) sum[3 * vertex + axis] += normal[axis];
    }
  }
  const out = new Int8Array(4 * vertices);
  for (let i = 0; i < vertices; i++) {
    const length = Math.hypot(sum[3 * i], sum[3 * i + 1], sum[3 * i + 2]) || 1;
    for (let axis = 0; axis < 3; axis++) out[4 * i + axis] = (127 * sum[3 * i + axis]) / length;
  }
  return out;
}

/** One part of a model: buffers of each frame, and the objects that draw them. */
class Part {
  constructor(part, scene) {
    this.part = part;
    const { vertices, frames } = part;
    this.positions = [];
    this.normals = [];
    this.values = {};
    for (let frame = 0; frame < frames; frame++) {
      // four components, as graphics cards copy what is not a multiple of four bytes
      const padded = new Uint16Array(4 * vertices);
      for (let i = 0; i < vertices; i++) {
        const from = 3 * (vertices * frame + i);
        padded.set(part.positions.subarray(from, from + 3), 4 * i);
      }
      this.positions.push(new BufferAttribute(padded, 4, true));
      this.normals.push(new BufferAttribute(normals(part, frame), 4, true));
    }
    this.none = new BufferAttribute(new Float32Array(vertices), 1);
    for (const [name, all] of Object.entries(part.values)) {
      this.values[name] = this.positions.map(
        (_, frame) => new BufferAttribute(all.subarray(vertices * frame, vertices * (frame + 1)), 1),
      );
    }
    this.uniforms = {
      uLow: { value: new Vector3(...part.low) },
      uSize: { value: new Vector3(...part.high.map((h, axis) => h - part.low[axis])) },
      uPart: { value: 0 },
      uRange: { value: new Vector2(0, 1) },
      uPalette: { value: null },
      uCut: { value: 0 },
    };
    const flat = part.colour ? [...part.colour, 1] : [0, 0, 0, 0];
    this.moving = { surface: this.#geometry(part.triangles), lines: this.#geometry(part.lines) };
    this.still = { surface: this.#geometry(part.triangles), creases: this.#geometry(part.creases) };
    for (const geometry of Object.values(this.still)) this.#bind(geometry, 0, 0);
    this.objects = [];
    for (const mirror of part.mirrored ? [1, -1] : [1]) {
      const made = {
        mirror,
        surface: new Mesh(this.moving.surface, this.#material(SURFACE, mirror, flat, 1)),
        lines: new LineSegments(this.moving.lines, this.#material(LINE, mirror, [0, 0, 0, 0.3], 0)),
      };
      if (frames > 1 && !part.section) {
        const ghost = { uPart: { value: 0 } };
        made.ghost = new Mesh(
          this.still.surface,
          this.#material(SURFACE, mirror, [0.5, 0.5, 0.5, 0.13], 3, ghost),
        );
        made.ghost.material.depthWrite = false;
        made.outline = new LineSegments(
          this.still.creases,
          this.#material(LINE, mirror, [0.4, 0.4, 0.4, 0.6], 0, ghost),
        );
        made.outline.material.depthWrite = false;
        // the body is drawn over it: blended, yet before what three.js counts as transparent
        for (const { material } of [made.ghost, made.outline]) {
          material.transparent = false;
          material.blending = CustomBlending;
          material.blendSrcAlpha = OneFactor;
          material.blendDstAlpha = OneMinusSrcAlphaFactor;
        }
      }
      this.objects.push(made);
      ['ghost', 'outline', 'surface', 'lines'].forEach((name, order) => {
        if (!made[name]) return;
        made[name].frustumCulled = false;
        made[name].renderOrder = order;
        scene.add(made[name]);
      });
    }
    this.setTime(0);
  }

  #geometry(index) {
    const geometry = new BufferGeometry();
    geometry.setIndex(new BufferAttribute(index, 1));
    return geometry;
  }

  #material(fragmentShader, mirror, flat, behind, further = {}) {
    return new ShaderMaterial({
      vertexShader: VERTEX,
      fragmentShader,
      side: DoubleSide,
      transparent: flat[3] > 0 && flat[3] < 1,
      polygonOffset: behind > 0, // so that lines in the surface are seen
      polygonOffsetFactor: behind,
      polygonOffsetUnits: behind,
      uniforms: {
        ...this.uniforms,
        uMirror: { value: new Vector3(1, mirror, 1) },
        uFlat: { value: new Vector4(...flat) },
        ...further,
      },
    });
  }

  #bind(geometry, from, to) {
    const values = this.values[this.field];
    geometry.setAttribute('position', this.positions[from]); // three.js counts vertices by it
    geometry.setAttribute('rest', this.positions[0]);
    geometry.setAttribute('from', this.positions[from]);
    geometry.setAttribute('to', this.positions[to]);
    geometry.setAttribute('normalFrom', this.normals[from]);
    geometry.setAttribute('normalTo', this.normals[to]);
    geometry.setAttribute('valueFrom', values ? values[from] : this.none);
    geometry.setAttribute('valueTo', values ? values[to] : this.none);
  }

  /** The two frames between which a time lies, and how far on it is. */
  frames(time) {
    const last = this.part.frames - 1;
    if (last === 0) return [0, 0, 0];
    const from = Math.min(Math.floor(time) + 1, last);
    return [from, Math.min(from + 1, last), Math.min(Math.max(time - Math.floor(time), 0), 1)];
  }

  setTime(time) {
    this.time = time;
    const [from, to, share] = this.frames(time);
    for (const geometry of Object.values(this.moving)) this.#bind(geometry, from, to);
    this.uniforms.uPart.value = share;
  }

  setField(name, range, palette) {
    this.field = name;
    this.uniforms.uRange.value.set(...range);
    this.uniforms.uPalette.value = palette;
    this.setTime(this.time);
  }

  setLayers({ ghost, lines, section }) {
    const { part } = this;
    this.uniforms.uCut.value = section && !part.mirrored && !part.section && part.cut ? 1 : 0;
    for (const made of this.objects) {
      const there = part.section ? section : !(section && made.mirror < 0);
      made.surface.visible = there;
      made.lines.visible = there && lines && part.lines.length > 0;
      if (made.ghost) made.ghost.visible = made.outline.visible = ghost && there;
    }
  }

  setTheme(dark) {
    const ghost = dark ? [0.78, 0.82, 0.88, 0.16] : [0.35, 0.4, 0.48, 0.13];
    for (const made of this.objects) {
      made.lines.material.uniforms.uFlat.value.set(0, 0, 0, 0.2); // a finger is pale in both
      if (!made.ghost) continue;
      made.ghost.material.uniforms.uFlat.value.set(...ghost);
      made.outline.material.uniforms.uFlat.value.set(...ghost.slice(0, 3), 0.65);
    }
  }

  /** Places of all vertices at the present time, in mm. */
  places() {
    const { part, time } = this;
    if (this.known === time) return this.kept;
    const [from, to, share] = this.frames(time);
    const size = 3 * part.vertices;
    const found = new Float32Array(size);
    for (let i = 0; i < size; i++) {
      const axis = i % 3;
      const a = part.positions[size * from + i];
      const b = part.positions[size * to + i];
      const scale = (part.high[axis] - part.low[axis]) / 65535;
      found[i] = part.low[axis] + scale * (a + (b - a) * share);
    }
    [this.known, this.kept] = [time, found];
    return found;
  }

  /** Value of the field at a point of a triangle, by the shares of its corners. */
  valueAt(corners, shares) {
    const all = this.part.values[this.field];
    if (!all) return null;
    const [from, to, share] = this.frames(this.time);
    const { vertices } = this.part;
    return corners.reduce((sum, vertex, i) => {
      const [a, b] = [all[vertices * from + vertex], all[vertices * to + vertex]];
      return sum + shares[i] * (a + (b - a) * share);
    }, 0);
  }

  dispose() {
    for (const group of [this.moving, this.still]) {
      for (const geometry of Object.values(group)) geometry.dispose();
    }
    for (const made of this.objects) {
      for (const name of ['surface', 'lines', 'ghost', 'outline']) made[name]?.material.dispose();
    }
  }
}

export class Pane {
  constructor(model) {
    this.model = model;
    this.scene = new Scene();
    this.parts = model.parts.map((part) => new Part(part, this.scene));
    this.low = [0, 1, 2].map((axis) => Math.min(...model.parts.map((p) => this.#end(p, axis, -1))));
    this.high = [0, 1, 2].map((axis) => Math.max(...model.parts.map((p) => this.#end(p, axis, 1))));
  }

  #end(part, axis, sign) {
    const own = sign < 0 ? part.low[axis] : part.high[axis];
    if (axis !== 1 || !part.mirrored) return own;
    const most = Math.max(Math.abs(part.low[1]), Math.abs(part.high[1]));
    return sign * most;
  }

  setTime(time) {
    for (const part of this.parts) part.setTime(Math.min(Math.max(time, 0), this.model.steps - 1));
  }

  setField(name, range, palette) {
    for (const part of this.parts) part.setField(name, range, palette);
  }

  setLayers(layers) {
    for (const part of this.parts) part.setLayers(layers);
  }

  setTheme(dark) {
    for (const part of this.parts) part.setTheme(dark);
  }

  /** What a ray through a point of the picture meets first: `{part, value}` or null. */
  probe(at, camera) {
    const start = camera.position;
    const ahead = new Vector3(at[0], at[1], 0.5).unproject(camera).sub(start).normalize();
    let best = null;
    for (const part of this.parts) {
      const cut = part.uniforms.uCut.value > 0.5 ? part.part : null;
      for (const made of part.objects) {
        if (!made.surface.visible) continue;
        const mirrored = ([x, y, z]) => [x, made.mirror * y, z];
        const hit = strike(
          part.places(), part.part.triangles, mirrored(start.toArray()),
          mirrored(ahead.toArray()), cut,
        );
        if (hit && (!best || hit.distance < best.distance)) {
          best = { ...hit, part };
        }
      }
    }
    if (!best) return null;
    return { part: best.part.part.name, value: best.part.valueAt(best.corners, best.shares) };
  }

  dispose() {
    for (const part of this.parts) part.dispose();
  }
}
