/**
 * The 3D view of one model or of several side by side, all seen by one camera.
 *
 *     const viewer = new Viewer(box, { fields });   // throws where there is no WebGL 2
 *     viewer.show([await unpack(packed, fields)]);            // one pane for each model
 *     viewer.setTimes([2.5]);                         // for each pane: between its steps 2 and 3
 *     viewer.setField('stretch', [1, 1.6]);           // colours, and the ends of their scale
 *     viewer.setLayers({ ghost: true, lines: true, section: false });
 *     viewer.probe(event.clientX, event.clientY);     // {pane, part, value} or null
 *     viewer.camera = other.camera;                   // position and target, in mm
 *
 * The page of a report and the explorer use it; it knows nothing of either.
 */

import { overlay } from './overlay.js';
import { Pane } from './pane.js';
import {
  DataTexture,
  LinearFilter,
  OrbitControls,
  PerspectiveCamera,
  Vector3,
  WebGLRenderer,
} from './three-global.js';

const TURN = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
const MARGIN = 1.06; // width and height of the picture, by those of what it shows
const FIELD_OF_VIEW_DEG = 26;
const COARSE = 0.75; // pixels of software WebGL while something moves, by those of the screen
const STILL_MS = 350; // time without a change after which software WebGL draws finely

/** Whether this browser has WebGL 2, and whether software draws it. */
export function webgl() {
  const context = document.createElement('canvas').getContext('webgl2');
  if (!context) return { there: false, software: false };
  const info = context.getExtension('WEBGL_debug_renderer_info');
  const name = info ? context.getParameter(info.UNMASKED_RENDERER_WEBGL) : '';
  context.getExtension('WEBGL_lose_context')?.loseContext();
  return { there: true, software: /swiftshader|llvmpipe|software|basic render/i.test(name) };
}

function texture(rgb) {
  const pixels = new Uint8Array(4 * 256).fill(255);
  for (let i = 0; i < 256; i++) pixels.set(rgb.slice(3 * i, 3 * i + 3), 4 * i);
  const made = new DataTexture(pixels, 256, 1);
  made.minFilter = made.magFilter = LinearFilter;
  made.needsUpdate = true;
  return made;
}

/** Columns and rows of so many panes in a box, so that each is as little elongated as can be. */
function grid(count, width, height) {
  let best = [count, 1];
  let most = 0;
  for (let columns = 1; columns <= count; columns++) {
    const rows = Math.ceil(count / columns);
    const side = Math.min(width / columns, height / rows);
    if (side > most) [best, most] = [[columns, rows], side];
  }
  return best;
}

export class Viewer {
  /**
   * @param {HTMLElement} box which the canvas fills
   * @param {{fields: Object<string, {rgb: number[]}>, label?: string}} options colours of each field
   *     as 256 times red, green, blue; `label`: what the canvas is called for those who cannot see
   */
  constructor(box, { fields, label = '' }) {
    this.box = box;
    this.panes = [];
    this.field = 'displacement';
    this.range = [0, 1];
    this.layers = { ghost: true, lines: true, section: false };
    this.dark = false;
    this.listeners = [];
    this.software = webgl().software;
    this.canvas = document.createElement('canvas');
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute('role', 'img');
    this.canvas.setAttribute('aria-label', label);
    this.sheet = document.createElement('canvas'); // over it, for lines and letters
    this.sheet.className = 'sheet';
    box.append(this.canvas, this.sheet);
    this.renderer = new WebGLRenderer({
      canvas: this.canvas,
      antialias: !this.software,
      alpha: true,
      powerPreference: 'low-power',
    });
    this.renderer.setClearColor(0, 0);
    this.palettes = Object.fromEntries(
      Object.entries(fields).map(([name, { rgb }]) => [name, texture(rgb)]),
    );
    this.eye = new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, 1, 5000);
    this.eye.up.set(0, 0, 1);
    this.#orbits();
    this.observer = new ResizeObserver(() => this.#resize());
    this.observer.observe(box);
    this.#resize();
  }

  #orbits() {
    const { canvas } = this;
    this.controls = new OrbitControls(this.eye, canvas);
    this.controls.enableZoom = false; // the wheel scrolls the page until the view has the focus
    canvas.addEventListener('focus', () => (this.controls.enableZoom = true));
    canvas.addEventListener('blur', () => (this.controls.enableZoom = false));
    canvas.style.touchAction = 'pan-y'; // a vertical swipe scrolls the page
    this.controls.addEventListener('change', () => {
      this.draw();
      for (const listener of this.listeners) listener(this.camera);
    });
    canvas.addEventListener('keydown', (event) => {
      const turn = TURN[event.key];
      if (turn) this.turn(...turn);
      else if (event.key === 'Home') this.home();
      else return;
      event.preventDefault();
    });
  }

  /** Show models, one pane for each; the camera stays where it is if `keepCamera`. */
  show(models, { keepCamera = false } = {}) {
    for (const pane of this.panes) pane.dispose();
    this.panes = models.map((model) => new Pane(model));
    this.setLayers({});
    this.setTheme(this.dark);
    this.setField(this.field, this.range);
    if (!keepCamera) this.home();
    this.draw();
  }

  /** Time of each pane in steps of its model; between two steps it is interpolated. */
  setTimes(times) {
    this.panes.forEach((pane, i) => pane.setTime(times[i] ?? 0));
    this.draw();
  }

  /** Colour by a field, such as `stretch`, with the scale's ends in its unit. */
  setField(name, range) {
    this.field = name;
    this.range = range;
    for (const pane of this.panes) pane.setField(name, range, this.palettes[name]);
    this.draw();
  }

  /** Switch the unloaded shape, the mesh lines or the section on or off. */
  setLayers(layers) {
    Object.assign(this.layers, layers);
    for (const pane of this.panes) pane.setLayers(this.layers);
    this.draw();
  }

  setTheme(dark) {
    this.dark = dark;
    for (const pane of this.panes) pane.setTheme(dark);
    this.draw();
  }

  /** Place of the eye and of what it looks at, in mm; setting it does not call listeners. */
  get camera() {
    return { position: this.eye.position.toArray(), target: this.controls.target.toArray() };
  }

  set camera({ position, target }) {
    this.eye.position.set(...position);
    this.controls.target.set(...target);
    this.eye.lookAt(this.controls.target);
    this.draw();
  }

  /** Call a function with the camera whenever it was moved. */
  onCamera(listener) {
    this.listeners.push(listener);
  }

  /** Look from the side that the first model asks for, at all of every model. */
  home() {
    if (!this.panes.length) return;
    const low = [0, 1, 2].map((axis) => Math.min(...this.panes.map((p) => p.low[axis])));
    const high = [0, 1, 2].map((axis) => Math.max(...this.panes.map((p) => p.high[axis])));
    const middle = new Vector3(...low.map((l, axis) => (l + high[axis]) / 2));
    const towards = new Vector3(...this.panes[0].model.view).normalize();
    const right = this.eye.up.clone().cross(towards).normalize();
    const up = towards.clone().cross(right);
    const size = [right, up, towards].map((direction) => {
      let most = 0;
      for (let corner = 0; corner < 8; corner++) {
        const at = low.map((l, axis) => ((corner >> axis) & 1 ? high[axis] : l));
        most = Math.max(most, Math.abs(new Vector3(...at).sub(middle).dot(direction)));
      }
      return most;
    });
    const slope = Math.tan((FIELD_OF_VIEW_DEG * Math.PI) / 360);
    const far = MARGIN * Math.max(size[1] / slope, size[0] / (slope * this.#aspect())) + size[2] / 2;
    this.controls.target.copy(middle);
    this.eye.position.copy(towards.multiplyScalar(far).add(middle));
    this.eye.near = far / 50;
    this.eye.far = far * 10;
    this.controls.update();
    this.draw();
  }

  /** Turn around the model by two angles in radians. */
  turn(sideways, upwards) {
    const { up } = this.eye;
    const arm = this.eye.position.clone().sub(this.controls.target);
    arm.applyAxisAngle(up, sideways);
    const axis = arm.clone().cross(up).normalize();
    const raised = arm.clone().applyAxisAngle(axis, upwards);
    if (raised.angleTo(up) > 0.1 && raised.angleTo(up) < Math.PI - 0.1) arm.copy(raised);
    this.eye.position.copy(arm.add(this.controls.target));
    this.controls.update();
  }

  /** The value under a point of the window: `{pane, part, value}`; null beside the models. */
  probe(clientX, clientY) {
    const box = this.canvas.getBoundingClientRect();
    const found = this.#tiles(box.width, box.height).findIndex(
      ([x, y, w, h]) =>
        clientX - box.left >= x && clientX - box.left < x + w &&
        clientY - box.top >= y && clientY - box.top < y + h,
    );
    if (found < 0) return null;
    const [x, y, w, h] = this.#tiles(box.width, box.height)[found];
    const at = [
      (2 * (clientX - box.left - x)) / w - 1,
      1 - (2 * (clientY - box.top - y)) / h,
    ];
    this.#aim(w / h);
    const hit = this.panes[found].probe(at, this.eye);
    return hit && { pane: found, ...hit };
  }

  /** Draw so many pixels, whatever the box has, until the function that is returned is called. */
  hold(width, height) {
    const ratio = this.renderer.getPixelRatio();
    this.renderer.setPixelRatio(1);
    this.renderer.setSize(width, height, false);
    this.size = [width, height];
    return () => {
      this.renderer.setPixelRatio(ratio);
      this.size = null;
      this.#resize();
    };
  }

  /** Draw at once onto a 2D context, with the scale bar and the axes so many times as large. */
  drawOn(context, enlarged = 1) {
    this.render();
    context.drawImage(this.canvas, 0, 0); // of the same task as the drawing
    this.#annotate(context, enlarged);
  }

  /** A PNG of the view as a data address, of so many pixels; the camera then shows everything. */
  image(width, height, { plain = false } = {}) {
    const kept = this.camera;
    const release = this.hold(width, height);
    this.home();
    const picture = Object.assign(document.createElement('canvas'), { width, height });
    const context = picture.getContext('2d');
    if (plain) this.render();
    if (plain) context.drawImage(this.canvas, 0, 0);
    else this.drawOn(context, width / 700);
    release();
    this.camera = kept;
    return picture.toDataURL('image/png');
  }

  /** Draw with the next frame of the screen. */
  draw() {
    if (this.software && !this.size) {
      this.renderer.setPixelRatio(COARSE);
      clearTimeout(this.idle);
      this.idle = setTimeout(() => {
        if (this.size) return;
        this.renderer.setPixelRatio(2);
        this.render();
      }, STILL_MS);
    }
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      this.render();
    });
  }

  /** Draw at once. */
  render() {
    const [width, height] = this.#extent();
    this.renderer.setScissorTest(true);
    this.#tiles(width, height).forEach(([x, y, w, h], i) => {
      this.#aim(w / h);
      const bottom = height - y - h;
      this.renderer.setViewport(x, bottom, w, h);
      this.renderer.setScissor(x, bottom, w, h);
      this.renderer.render(this.panes[i].scene, this.eye);
    });
    if (this.size) return;
    const fine = devicePixelRatio || 1;
    Object.assign(this.sheet, { width: width * fine, height: height * fine }); // which clears it
    this.#annotate(this.sheet.getContext('2d'), fine);
  }

  /** Scale bar and axes of each pane, so many times as large as on a screen. */
  #annotate(context, enlarged) {
    const extent = this.#extent().map((px) => (this.size ? px / enlarged : px));
    context.save();
    context.scale(enlarged, enlarged);
    const ink = this.dark ? '#eceff3' : '#1d2126';
    this.#tiles(...extent).forEach((tile, i) => {
      const { axes } = this.panes[i].model;
      overlay(context, tile, { eye: this.eye, target: this.controls.target, axes, ink });
    });
    context.restore();
  }

  /** Places of the panes in the box, in shares of its width and height: `[x, y, w, h]`. */
  get places() {
    return this.#tiles(1, 1, this.#extent());
  }

  dispose() {
    this.observer.disconnect();
    clearTimeout(this.idle);
    for (const pane of this.panes) pane.dispose();
    this.controls.dispose();
    this.renderer.dispose();
    this.canvas.remove();
    this.sheet.remove();
  }

  #extent() {
    if (this.size) return this.size;
    const box = this.box.getBoundingClientRect();
    return [Math.max(box.width, 2), Math.max(box.height, 2)];
  }

  #tiles(width, height, extent = [width, height]) {
    const count = this.panes.length;
    if (!count) return [];
    const [columns, rows] = grid(count, ...extent);
    const [w, h] = [width / columns, height / rows];
    return this.panes.map((_, i) => [(i % columns) * w, Math.floor(i / columns) * h, w, h]);
  }

  #aspect() {
    const [, , w, h] = this.#tiles(...this.#extent())[0] ?? [0, 0, 1, 1];
    return w / h;
  }

  #aim(aspect) {
    this.eye.aspect = aspect;
    this.eye.updateProjectionMatrix();
    this.eye.updateMatrixWorld();
  }

  #resize() {
    const [width, height] = this.#extent();
    if (this.size || width < 4 || height < 4) return;
    const before = this.shape;
    this.shape = width / height;
    const fine = Math.min(devicePixelRatio || 1, 2);
    this.renderer.setPixelRatio(this.software ? COARSE : fine);
    this.renderer.setSize(width, height, false);
    if (before && Math.abs(this.shape - before) > 0.25) this.home();
    this.draw();
  }
}
