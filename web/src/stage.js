// The 3D view of a report with its slider, switches, colour scale and film strip.

import { element, formatted, joined, ticks } from './format.js';
import { unpack } from './packed.js';
import { Saver } from './save.js';
import { Viewer } from './viewer.js';

const FILM = { count: 6, width: 220, height: 165 };
const PRINT = { width: 1400, height: 800, afterMs: 700 };
const STEPS_A_SECOND = 4; // of the animation
const WHOLE = 1e-6; // distance from a step within which a time is that step's

const $ = (id) => document.getElementById(id);
const clamped = (v, low, high) => Math.max(low, Math.min(high, v));

/** The value of a scene's control at a time. */
function valueAt({ control }, time) {
  const from = clamped(Math.floor(time), 0, control.values.length - 1);
  const to = Math.min(from + 1, control.values.length - 1);
  return control.values[from] + (control.values[to] - control.values[from]) * (time - from);
}

/** The time at which a scene's control has a value; null if it goes up and down. */
function timeOf({ control }, value) {
  const { values, monotone } = control;
  if (!monotone) return null;
  let i = 1;
  while (i < values.length - 1 && values[i] < value) i++;
  if (values.length < 2) return 0;
  const step = values[i] - values[i - 1] || 1;
  return clamped(i - 1 + (value - values[i - 1]) / step, 0, values.length - 1);
}

export class Stage {
  /**
   * @param {object[]} scenes packed
   * @param {Object<string, object>} fields title, unit, least value and colours of each
   */
  constructor(scenes, fields) {
    this.scenes = scenes;
    this.fields = fields;
    this.models = [];
    this.listeners = [];
    this.shown = this.#first();
    this.time = 0;
    this.slider = $('time');
    this.#controls();
  }

  /** Scenes that are shown at first: those of the first one's kind. */
  #first() {
    const { kind } = this.scenes[0];
    return this.scenes.map((s, i) => i).filter((i) => this.scenes[i].kind === kind).slice(0, 4);
  }

  /** Show other scenes at the same load; the camera stays where the kind of scene is the same. */
  async replace(scenes) {
    const before = this.scenes[this.lead];
    const value = valueAt(before, this.time);
    const ended = this.time > before.steps - 1 - WHOLE; // whoever looks at the last step goes on so
    const loaded = before.steps > 1;
    const same = scenes[0].kind === before.kind && loaded === scenes[0].steps > 1
      && scenes.length === this.scenes.length;
    this.scenes = scenes;
    this.models = [];
    this.shown = this.#first();
    const lead = scenes[this.lead];
    this.slider.max = lead.steps - 1;
    this.slider.disabled = lead.steps < 2;
    const alike = !ended && before.control.label === lead.control.label;
    this.time = (alike ? timeOf(lead, value) : null) ?? lead.steps - 1;
    const shown = this.shown;
    if (this.viewer) await this.#show(shown, same);
    if (shown === this.shown) this.setTime(this.time);
  }

  /** Call a function with the time of each scene whenever it changes. */
  onTime(listener) {
    this.listeners.push(listener);
  }

  /** Make the 3D view; it may fail, and the slider then moves the curves alone. */
  async begin(dark) {
    this.viewer = new Viewer($('view'), { fields: this.fields, label: this.scenes[0].alt });
    this.viewer.setTheme(dark);
    this.#probe();
    this.saver = new Saver(this);
    await this.#show(this.shown);
    this.setTime(this.time, true);
  }

  get lead() {
    const longest = Math.max(...this.shown.map((i) => this.scenes[i].steps));
    return this.shown.find((i) => this.scenes[i].steps === longest);
  }

  /** Times of all scenes: the shown ones follow the lead's load, or its share of the way. */
  times() {
    const lead = this.scenes[this.lead];
    const value = valueAt(lead, this.time);
    return this.scenes.map((scene) => {
      if (scene === lead) return this.time;
      const same = lead.control.monotone && scene.control.label === lead.control.label;
      const found = same ? timeOf(scene, value) : null;
      return found ?? (this.time / Math.max(lead.steps - 1, 1)) * (scene.steps - 1);
    });
  }

  /** Set the time of the lead, or of the scene whose curve was picked. */
  pick(scene, index) {
    if (scene === this.lead) return this.setTime(index);
    const value = valueAt(this.scenes[scene], index);
    const lead = this.scenes[this.lead];
    const same = this.scenes[scene].control.label === lead.control.label;
    const share = (index / Math.max(this.scenes[scene].steps - 1, 1)) * (lead.steps - 1);
    return this.setTime((same ? timeOf(lead, value) : null) ?? share);
  }

  setTime(time) {
    this.time = clamped(time, 0, this.scenes[this.lead].steps - 1);
    this.slider.value = this.time;
    this.#label();
    const times = this.times();
    if (this.viewer) {
      this.viewer.setTimes(this.shown.map((i) => times[i]));
      this.#markPeak(times);
      this.#later();
    }
    for (const listener of this.listeners) listener(times);
  }

  setTheme(dark) {
    this.viewer?.setTheme(dark);
  }

  #label() {
    const { control, steps, solved } = this.scenes[this.lead];
    const whole = Math.abs(this.time - Math.round(this.time)) < WHOLE;
    const value = formatted(valueAt(this.scenes[this.lead], this.time));
    const at = Math.round(this.time);
    const from = Math.floor(this.time);
    const name = (i) => joined(formatted(control.values[i]), control.unit);
    const branch = control.branches[whole ? at : from];
    const step = solved ? 'solved step' : 'step';
    let said = `interpolated between the ${step}s at ${name(from)} and ${name(from + 1)}`;
    if (whole) said = `${step} ${at + 1} of ${steps}`;
    if (!control.label) said = 'without load';
    $('now').textContent = control.label ? joined(value, control.unit) : '';
    $('said').textContent = branch ? `${branch}, ${said}` : said;
    this.slider.setAttribute('aria-valuetext', `${$('now').textContent}, ${$('said').textContent}`);
    $('control').textContent = control.label;
  }

  #controls() {
    const { slider } = this;
    slider.max = this.scenes[this.lead].steps - 1;
    slider.addEventListener('input', () => this.setTime(+slider.value));
    slider.addEventListener('keydown', (event) => {
      const ahead = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
      if (!ahead) return;
      event.preventDefault(); // from one solved step to the next, not a twentieth of it
      const { time } = this;
      this.setTime(ahead > 0 ? Math.floor(time + WHOLE) + 1 : Math.ceil(time - WHOLE) - 1);
    });
    $('play').addEventListener('click', () => this.#play());
    const choice = $('field');
    for (const [name, { label }] of Object.entries(this.fields)) {
      choice.append(element('option', { value: name }, label));
    }
    choice.addEventListener('change', () => this.#setField(choice.value));
    for (const name of ['ghost', 'lines', 'section']) {
      const button = $(name);
      button.addEventListener('click', () => {
        const on = button.getAttribute('aria-pressed') !== 'true';
        button.setAttribute('aria-pressed', on);
        this.viewer?.setLayers({ [name]: on });
        this.#film();
      });
    }
    $('home').addEventListener('click', () => this.viewer?.home());
    for (const button of document.querySelectorAll('[data-scene]')) {
      const index = +button.dataset.scene;
      button.setAttribute('aria-pressed', this.shown.includes(index));
      button.addEventListener('click', () => this.#toggle(index));
    }
    this.#label();
  }

  async #toggle(index) {
    const on = this.shown.includes(index);
    const shown = on ? this.shown.filter((i) => i !== index) : [...this.shown, index].sort();
    if (!shown.length) return;
    for (const button of document.querySelectorAll('[data-scene]')) {
      button.setAttribute('aria-pressed', shown.includes(+button.dataset.scene));
    }
    const share = this.time / Math.max(this.scenes[this.lead].steps - 1, 1);
    this.shown = shown;
    const steps = this.scenes[this.lead].steps;
    this.slider.max = steps - 1;
    if (this.viewer) await this.#show(shown);
    this.setTime(Math.round(share * (steps - 1)));
    this.#film();
  }

  async #show(shown, keepCamera = false) {
    await Promise.all(shown.map(async (i) => (this.models[i] ??= await unpack(this.scenes[i], this.fields))));
    if (shown !== this.shown) return;
    this.viewer.show(shown.map((i) => this.models[i]), { keepCamera });
    const captions = $('captions');
    captions.replaceChildren();
    if (shown.length > 1) {
      this.viewer.places.forEach(([x, y, w], pane) => {
        const caption = element('span', {}, this.scenes[shown[pane]].title);
        Object.assign(caption.style, { left: `${100 * x}%`, top: `${100 * y}%`, width: `${100 * w}%` });
        captions.append(caption);
      });
    }
    for (const choice of $('field').options) {
      choice.disabled = !shown.some((i) => this.models[i].peaks[choice.value]);
    }
    const cut = shown.some((i) => this.scenes[i].parts.some((part) => part.section || part.cut));
    $('section').disabled = !cut;
    this.#setField($('field').value);
  }

  #setField(name) {
    if (!this.viewer) return;
    const highest = Math.max(
      ...this.shown.flatMap((i) => this.models[i].peaks[name] ?? [this.fields[name].least]),
    );
    // a shape without load has no scale
    this.coloured = this.scenes[this.lead].steps > 1;
    $('video').disabled = !this.coloured || !this.saver.kind;
    $('bar').parentElement.classList.toggle('still', !this.coloured);
    this.range = [this.fields[name].least, Math.max(highest, this.fields[name].least + 1e-6)];
    this.field = name;
    this.viewer.setField(name, this.range);
    this.#scale();
    this.#markPeak(this.times());
    this.#film();
  }

  #scale() {
    const { label, unit, rgb } = this.fields[this.field];
    const colours = Array.from({ length: 33 }, (_, i) => {
      const at = 3 * Math.round((i * 255) / 32);
      return `rgb(${rgb[at]},${rgb[at + 1]},${rgb[at + 2]})`;
    });
    const bar = $('bar');
    bar.replaceChildren();
    bar.style.setProperty('--colours', colours.join(','));
    $('scale-title').textContent = `${label} (${unit})`;
    const [low, high] = this.range;
    for (const v of ticks(low, high, 5)) {
      const tick = element('i', {}, formatted(v));
      tick.style.setProperty('--at', `${(100 * (v - low)) / (high - low)}%`);
      bar.append(tick);
    }
    this.peak = element('u', {});
    bar.append(this.peak);
  }

  #markPeak(times) {
    const most = Math.max(...this.shown.map((i) => {
      const peaks = this.models[i]?.peaks[this.field];
      if (!peaks) return this.fields[this.field].least;
      const from = Math.floor(times[i]);
      const to = Math.min(from + 1, peaks.length - 1);
      return peaks[from] + (peaks[to] - peaks[from]) * (times[i] - from);
    }));
    const [low, high] = this.range;
    this.peak.style.setProperty('--at', `${clamped((100 * (most - low)) / (high - low), 0, 100)}%`);
    const text = `largest now: ${joined(formatted(most), this.fields[this.field].unit)}`;
    this.peak.title = text;
    $('peak').textContent = text;
  }

  #probe() {
    const note = $('probe');
    const { canvas } = this.viewer;
    let waiting = false;
    const move = (event) => {
      if (waiting) return;
      waiting = true;
      requestAnimationFrame(() => {
        waiting = false;
        const found = this.viewer.probe(event.clientX, event.clientY);
        note.hidden = !found;
        if (!found) return;
        const value = found.value === null
          ? '' : `: ${joined(formatted(found.value), this.fields[this.field].unit)}`;
        note.textContent = found.part + value;
        const box = $('view').getBoundingClientRect();
        const left = Math.min(event.clientX - box.left + 14, box.width - note.offsetWidth - 4);
        note.style.left = `${left}px`;
        note.style.top = `${event.clientY - box.top + 12}px`;
      });
    };
    canvas.addEventListener('pointermove', move);
    canvas.addEventListener('pointerdown', move);
    canvas.addEventListener('pointerleave', () => (note.hidden = true));
  }

  #play() {
    this.playing = !this.playing;
    $('play').textContent = this.playing ? '❚❚' : '▶';
    $('play').setAttribute('aria-label', this.playing ? 'Pause' : 'Play');
    let ahead = 1;
    let before = performance.now();
    const go = (now) => {
      if (!this.playing) return;
      const last = this.scenes[this.lead].steps - 1;
      const time = this.time + ahead * Math.min(0.1, (now - before) / 1000) * STEPS_A_SECOND;
      before = now;
      if (time >= last) ahead = -1;
      if (time <= 0) ahead = 1;
      this.setTime(time);
      requestAnimationFrame(go);
    };
    requestAnimationFrame(go);
  }

  /** The film strip, once nothing else is to be done. */
  #film() {
    if (!$('film')) return;
    clearTimeout(this.filming);
    this.filming = setTimeout(() => {
      const strip = $('film');
      strip.replaceChildren();
      const { steps, control } = this.scenes[this.lead];
      const count = Math.min(FILM.count, steps);
      const kept = this.time;
      for (let i = 0; i < count; i++) {
        const step = Math.round((i * (steps - 1)) / Math.max(count - 1, 1));
        this.time = step;
        const times = this.times();
        this.viewer.setTimes(this.shown.map((s) => times[s]));
        const name = joined(formatted(control.values[step]), control.unit);
        const frame = element('button', { type: 'button' });
        const picture = element('img', { alt: `${control.label} ${name}` });
        picture.src = this.viewer.image(FILM.width, FILM.height, { plain: true });
        frame.append(picture, name);
        frame.addEventListener('click', () => this.setTime(step));
        strip.append(frame);
      }
      this.setTime(kept);
      document.documentElement.dataset.film = count;
    }, 60);
  }

  /** The picture that is printed, some time after the last change. */
  #later() {
    if (!$('printed')) return;
    clearTimeout(this.printing);
    this.printing = setTimeout(() => {
      $('printed').src = this.viewer.image(PRINT.width, PRINT.height);
      document.documentElement.dataset.printed = this.time;
    }, PRINT.afterMs);
  }
}
