// The explorer's page: what its controls ask the server for, and what the server's answers show.

import { lineChart, scatterChart } from './chart.js';
import { element, formatted, joined } from './format.js';
import { History } from './history.js';
import { Rig } from './rig.js';
import { Socket } from './socket.js';
import { Stage } from './stage.js';
import { themes } from './theme.js';
import { webgl } from './viewer.js';
import { Wish } from './wish.js';

const $ = (id) => document.getElementById(id);
const root = document.documentElement;
const data = JSON.parse($('data').textContent);
const GRIPPER = ['L_mm', 'W_mm', 'R_mm'];
const FOOD = ['friction', 'turn_deg'];
const EXPORTS = ['stl', 'step', 'toml'];
const DIGITS = 4; // of a slider's value
const REST_MS = 500; // without a change, after which a design is at rest
const CONTROLS = ['pose', 'alpha', ...GRIPPER, 'kind', ...FOOD];
const OF = data.sliders.map(({ key }) => key).join(); // what a state's values are of
const FOREIGN = 'The link is cut short or of an explorer with other sliders, so its design is not shown.';
const SOLVED = { bending: 'free bending', blocked_force: 'blocked force' };
const THUMB = { width: 220, height: 165 }; // pixels
const STEPS = /^(Arrow|Page|Home|End)/; // keys that change a slider or a box
const short = (value) => +(+value).toPrecision(DIGITS);

/** Copy a text; browsers have a clipboard of their own on this machine and with https alone. */
async function copied(text) {
  try {
    await navigator.clipboard.writeText(text);
    return true;
  } catch {
    const box = element('textarea', { readonly: '' });
    box.value = text;
    document.body.append(box);
    box.select();
    const done = document.execCommand('copy');
    box.remove();
    return done;
  }
}

class Explorer {
  constructor() {
    root.classList.add('scripted');
    const shared = data.sliders.map((slider, at) => ({ ...slider, id: `${at}`, at }));
    if (data.pressure) shared.push({ ...data.pressure, id: 'pressure', at: shared.length });
    this.start = shared.map((slider) => short(slider.value));
    this.sliders = shared.flatMap((slider) => {
      const chambers = slider.chambers ?? [];
      return [slider, ...chambers.map((one, i) => ({ ...one, id: `${slider.id}-${i + 1}`, of: slider }))];
    });
    this.asked = 0;
    this.showing = Promise.resolve(); // of the answers so far: each is shown whole, then the next
    this.charts = [];
    this.kept = null;
    this.views = [];
    this.history = new History($('history'), { undo: $('undo'), redo: $('redo') }, (state) => this.#restore(state));
    this.there = webgl().there;
    root.classList.toggle('webgl', this.there);
    this.apply = themes(this.views);
    this.#controls();
    this.#front();
    this.socket = new Socket('/tab', {
      hear: (message) => this.#hear(message),
      state: (open) => this.#connection(open),
    });
    const send = (message) => this.socket.send({ ...message, ...this.design() });
    this.rig = new Rig(send);
    if ($('wish')) this.wish = new Wish(send);
    const own = { view: data.view, values: this.start, grasp_kPa: data.grasp_kPa, gripper: this.#gripper(), of: OF };
    const linked = this.history.linked();
    if (linked && this.#fits(linked)) this.#set(linked);
    else this.#set(own, false);
    if (linked && !this.#fits(linked)) this.notice = FOREIGN;
  }

  /** Whether a state is of this page's sliders; a link may be another server's. */
  #fits(state) {
    const { view, values, gripper, own = {}, of = OF, grasp_kPa: grasp } = state;
    const sliders = new Set(this.sliders.map(({ key }) => key));
    return of === OF && Boolean(document.querySelector(`[data-view="${CSS.escape(view)}"]`))
      && Array.isArray(values) && values.length === this.start.length && values.every(Number.isFinite)
      && Number.isFinite(grasp) && Object.keys(own).every((key) => sliders.has(key))
      && Object.keys(gripper ?? { none: 0 }).every((name) => CONTROLS.includes(name));
  }

  #restore(state) {
    if (this.#fits(state)) this.#set(state);
    else this.#fail(FOREIGN);
  }

  /** The design that the controls say, as the server reads it. */
  design() {
    const { view, values, own } = this.state;
    const inputs = { ...Object.fromEntries(data.sliders.map(({ key }, i) => [key, values[i]])), ...own };
    if (view !== 'grasp') return { view, inputs, pressure_kPa: data.pressure ? values.at(-1) : null };
    const number = (text) => (text === '' ? null : +text);
    const { pose, alpha, kind, ...rest } = this.state.gripper;
    const numbers = (names) => Object.fromEntries(names.map((n) => [n, number(rest[n])]));
    return {
      view, inputs, pressure_kPa: this.state.grasp_kPa,
      gripper: { pose, alpha_deg: +alpha, ...numbers(GRIPPER) },
      food: { kind, ...numbers(FOOD) },
    };
  }

  /** Ask for the design; until it comes nothing of another one is seen. */
  ask() {
    this.asked += 1;
    root.dataset.asked = this.asked;
    root.classList.add('stale');
    $('shape').inert = $('keep').disabled = true;
    this.known = null;
    this.wish?.clear();
    this.#badge('rebuilding');
    this.#solvable('The design is being rebuilt');
    this.socket.send({ do: 'show', id: this.asked, ...this.design() });
    const text = encodeURIComponent(JSON.stringify(this.design()));
    for (const suffix of EXPORTS) $(suffix).href = `/export/${suffix}?design=${text}`;
    clearTimeout(this.resting);
    this.rested = false;
  }

  /** Take up a design in the history, and solve it if that is wanted. */
  #rest() {
    clearTimeout(this.resting);
    if (this.rested) return;
    this.rested = true;
    this.history.add(this.state, this.#changed(this.history.present), this.touched);
    if (this.none === this.asked) this.history.refused();
    this.#solveAtRest();
  }

  #restSoon() {
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.#rest(), REST_MS);
  }

  #solveAtRest() {
    const wanted = this.rested && this.touched && $('auto').checked && this.state.view !== 'grasp';
    if (!wanted || !this.known || this.solved || this.sent === this.known) return;
    this.#solve();
  }

  #solve() {
    this.sent = this.known;
    $('error').hidden = true;
    this.socket.send({ do: 'solve', ...this.design() });
  }

  #controls() {
    for (const slider of this.sliders) {
      for (const input of [$(`p-${slider.id}`), $(`n-${slider.id}`)]) {
        input.addEventListener('input', () => {
          if (input.value === '') return;
          this.#change(slider, short(input.value), input);
          this.#restSoon();
        });
        // a box that is left with the value it was entered with has no change of its own
        let steps = false; // each step by a key is a change; a design is at rest after the last one
        input.addEventListener('keydown', ({ key }) => (steps = STEPS.test(key)));
        input.addEventListener('pointerdown', () => (steps = false));
        input.addEventListener('change', () => (steps ? this.#restSoon() : this.#rest()));
        input.addEventListener('blur', () => {
          this.#labels(); // an empty box has changed nothing
          this.#rest();
        });
      }
    }
    for (const button of document.querySelectorAll('.each')) {
      button.addEventListener('click', () => this.#open(button));
    }
    for (const button of document.querySelectorAll('[data-view]')) {
      button.addEventListener('click', () => this.#set({ ...this.state, view: button.dataset.view }));
    }
    for (const name of CONTROLS) {
      $(name).addEventListener(name === 'alpha' ? 'input' : 'change', () => {
        if (name === 'pose') $('alpha').value = data.alpha_deg[$('pose').value];
        if ($(name).value === '' && $(name).defaultValue) $(name).value = $(name).defaultValue;
        this.state = { ...this.state, gripper: this.#gripper() };
        this.#alpha();
        this.touched = true;
        this.ask();
        this.#restSoon();
      });
    }
    $('solve').addEventListener('click', () => {
      this.touched = true;
      this.#rest();
      this.#solve();
    });
    $('auto').addEventListener('change', () => this.#solveAtRest());
    $('cancel').addEventListener('click', () => this.socket.send({ do: 'cancel' }));
    $('reset').addEventListener('click', () => this.#set({ ...this.state, values: this.start, own: {} }));
    $('keep').addEventListener('click', () => {
      this.kept = this.kept || !this.scene ? null : { ...this.scene, title: `kept: ${this.#named()}` };
      $('keep').setAttribute('aria-pressed', this.kept !== null);
      this.#stage();
    });
    $('link').addEventListener('click', async () => {
      $('link').textContent = (await copied(location.href)) ? 'Copied' : 'Copy it from the address bar';
      setTimeout(() => ($('link').textContent = 'Copy link'), 1500);
    });
  }

  /** What the gripper's and the food's controls say. */
  #gripper() {
    return Object.fromEntries(CONTROLS.map((name) => [name, $(name).value]));
  }

  #change(slider, value, input) {
    const { view, values, own } = this.state;
    if (slider.of) {
      const { [slider.key]: _, ...others } = own; // what is as without a value of its own has none
      this.state = { ...this.state, own: others };
      if (value !== this.#value(slider)) this.state.own = { ...others, [slider.key]: value };
    } else if (view === 'grasp' && slider.id === 'pressure') {
      this.state = { ...this.state, grasp_kPa: value };
    } else this.state = { ...this.state, values: values.with(slider.at, value) };
    this.touched = true;
    this.#labels(input);
    this.ask();
  }

  /** The value of a slider: its own, of a chamber without one that of the sliders' base or of all. */
  #value(slider, { view, values, own, grasp_kPa: grasp } = this.state) {
    if (slider.of) return own[slider.key] ?? slider.value ?? values[slider.of.at];
    return view === 'grasp' && slider.id === 'pressure' ? grasp : values[slider.at];
  }

  #text(slider) {
    return `${slider.label} ${joined(formatted(this.#value(slider)), slider.unit)}`;
  }

  #named() {
    const told = this.sliders.filter(({ of, key }) => !of || key in this.state.own);
    return told.map((slider) => this.#text(slider)).join(', ');
  }

  /** Open the slider of all chambers into one for each; closed, no chamber has a value of its own. */
  #open(button) {
    const chambers = this.sliders.filter(({ of }) => of?.id === button.dataset.of);
    const opens = button.getAttribute('aria-expanded') === 'false';
    this.#opened(button, opens);
    const own = { ...this.state.own };
    for (const { key } of opens ? [] : chambers) delete own[key];
    if (Object.keys(own).length < Object.keys(this.state.own).length) this.#set({ ...this.state, own });
  }

  #opened(button, opens) {
    if ((button.getAttribute('aria-expanded') === 'true') === opens) return;
    const { textContent: text, dataset } = button;
    [button.textContent, dataset.other] = [dataset.other, text];
    button.setAttribute('aria-expanded', opens);
    $(`c-${dataset.of}`).hidden = !opens;
  }

  /** What differs from a state before, in words. */
  #changed(before) {
    const { view } = this.state;
    const title = document.querySelector(`[data-view="${view}"]`).textContent;
    if (!before || before.view !== view) return title;
    const set = ({ at, key, of }, state) => (of ? state.own[key] : state.values[at]);
    const differ = this.sliders.filter((slider) => set(slider, before) !== set(slider, this.state));
    return differ.length === 1 ? this.#text(differ[0]) : title;
  }

  /** Show the sliders' values, but not in what is typed in. */
  #labels(typed = null) {
    for (const slider of this.sliders) {
      const [range, box] = [$(`p-${slider.id}`), $(`n-${slider.id}`)];
      const value = this.#value(slider);
      if (range !== typed) range.value = value;
      if (box !== typed) box.value = value;
      range.setAttribute('aria-valuetext', joined(formatted(value), slider.unit));
      range.parentElement.classList.toggle('own', slider.key in this.state.own);
    }
  }

  #alpha() {
    $('o-alpha').textContent = joined(formatted(+$('alpha').value), '°');
  }

  /** Show a state: of the history, of a link, of a point of the front. */
  #set(state, touched = true) {
    this.state = { own: {}, ...state };
    this.touched ||= touched;
    for (const [name, value] of Object.entries(state.gripper)) $(name).value = value;
    this.#alpha();
    this.#labels();
    for (const button of document.querySelectorAll('.each')) {
      const own = this.sliders.some(({ of, key }) => of?.id === button.dataset.of && key in this.state.own);
      if (own) this.#opened(button, true);
    }
    for (const button of document.querySelectorAll('[data-view]')) {
      button.setAttribute('aria-pressed', button.dataset.view === state.view);
    }
    $('gripper').hidden = $('food').hidden = state.view !== 'grasp';
    if (this.wish) $('wish').hidden = state.view === 'grasp';
    this.ask();
    this.#rest();
  }

  #front() {
    if (!data.front) return;
    this.front = scatterChart($('front-chart'), data.front, {
      take: (i) => {
        const { inputs } = data.front.points[i];
        const values = this.state.values.map((value, n) => inputs[data.sliders[n]?.key] ?? value);
        this.#set({ ...this.state, values, own: {} });
      },
    });
  }

  #connection(open) {
    root.dataset.connected = open;
    if (open && this.lost) {
      this.sent = null;
      this.ask();
      this.rested = true;
    }
    this.lost = !open;
    if (!open) $('state').textContent = 'not connected: is dolfingrip explore running?';
  }

  #hear(message) {
    const { is, about } = message;
    if (is === 'state') this.#state(message);
    else if (is === 'shown') this.showing = this.showing.then(() => this.#show(message));
    else if (is === 'replaced') {
      const mine = message.design === this.known && message.by !== this.known;
      if (mine) this.#fail('Another request took the place of this design: it is not solved. Solve asks for it again.');
    } else if (is === 'error' && about === 'show') this.#refused(message);
    else if (is === 'error' && about === 'solve' && (message.design ?? this.known) !== this.known) {
      return; // of another tab's design
    } else if (is === 'error' && ['solve', 'message'].includes(about)) this.#fail(message.text);
    else if (is === 'followed' || about === 'follow') this.wish.hear(message);
    else this.rig.hear(message);
  }

  /** A refusal with the labels of the page in place of keys. */
  #worded(text) {
    return this.sliders.reduce((found, { key, label }) => found.replaceAll(key, label), text);
  }

  #fail(text) {
    $('error').textContent = this.#worded(text);
    $('error').title = text;
    $('error').hidden = false;
  }

  /** There is no such design: nothing is shown but why. */
  #refused({ id, text }) {
    if (id !== this.asked) return;
    this.#fail(text);
    this.none = id;
    if (this.rested) this.history.refused();
    this.#badge('no such design');
    this.#solvable(this.#worded(text));
    for (const suffix of EXPORTS) $(suffix).removeAttribute('href');
    this.scene = null;
    $('where').textContent = '';
    this.#numbers([]);
    this.#curves([]);
    this.front?.here(null);
    root.dataset.origin = '';
    root.dataset.shown = id;
  }

  #solvable(reason) {
    $('solve').disabled = Boolean(reason);
    $('solve').title = reason;
    $('solve').textContent = this.solved && !root.classList.contains('stale') ? 'Solved' : 'Solve';
  }

  #badge(text) {
    $('badge').textContent = text;
    $('badge').hidden = !text;
  }

  #state({ counts, working }) {
    const told = Object.entries(counts).map(([kind, n]) => `${n} of ${SOLVED[kind]}`);
    $('state').textContent = `solved: ${told.join(', ')}`;
    $('working').hidden = !working;
    root.dataset.working = Boolean(working);
    if (!working) return;
    const { done, total, note } = working;
    if (total) $('bar-work').value = done / total;
    else $('bar-work').removeAttribute('value');
    const view = SOLVED[working.view] ?? 'grasp';
    const which = working.design === this.known || !this.known ? view : `${view} of another design`;
    const mesh = working.coarse ? ', coarse mesh' : '';
    $('work-said').textContent = `${which}${mesh}: ${total ? `${done} of ${total}, ` : ''}${note}`;
  }

  /** Show what is known of a design: its numbers and where they come from, once its picture is there. */
  async #show(message) {
    if (message.id !== this.asked) return; // a newer one is on its way
    [this.scene] = message.scenes;
    await this.#stage(message.said);
    if (message.id !== this.asked) return;
    $('error').hidden ||= this.known !== message.design;
    if (this.notice) this.#fail(this.notice);
    this.notice = '';
    this.known = message.design;
    this.solved = message.solved;
    $('where').textContent = message.said;
    this.#numbers(message.numbers);
    this.#curves(message.charts);
    if (this.front) {
      const [x, y] = data.axes;
      const { place } = message;
      this.front.here(place[x] === undefined ? null : [place[x], place[y]]);
    }
    root.classList.remove('stale');
    $('shape').inert = $('keep').disabled = false;
    this.#badge(message.badge);
    this.#solvable(message.solved ? 'It is solved' : '');
    root.dataset.origin = message.said;
    root.dataset.shown = message.id;
    this.#picture();
    this.#solveAtRest();
  }

  /** The supply's commands and the picture in the history, once nothing else is to be done. */
  #picture() {
    clearTimeout(this.drawing);
    const { asked } = this;
    this.drawing = setTimeout(() => {
      if (asked !== this.asked) return;
      this.wish?.ask();
      if (!this.stage?.viewer) return;
      this.history.picture(this.stage.viewer.image(THUMB.width, THUMB.height, { plain: true }));
    }, REST_MS);
  }

  #numbers(numbers) {
    const cards = numbers.map(({ name, value, said }) => {
      const card = element('div', { class: 'card' });
      card.append(element('span', { class: 'name' }, name), element('b', {}, value));
      card.append(element('span', { class: 'verdict none' }, said));
      return card;
    });
    $('numbers').replaceChildren(...cards);
  }

  #curves(specs) {
    for (const chart of this.charts) chart.dispose();
    $('curves').replaceChildren();
    this.charts = specs.map((spec) => {
      const card = element('figure', { class: 'card' });
      const plot = element('div', { class: 'plot' });
      const box = element('div', { class: 'chart' });
      plot.append(box);
      card.append(element('h3', {}, `${spec.title}, ${spec.series[0].name}`), plot);
      if (spec.note) card.append(element('p', { class: 'note' }, spec.note));
      $('curves').append(card);
      return lineChart(box, spec, { pick: (scene, index) => this.stage?.setTime(index) });
    });
    this.#mark();
  }

  /** Mark the picture's pressure in the curves. */
  #mark() {
    for (const chart of this.charts) chart.mark({ 0: this.stage.times()[0] });
  }

  async #stage(said) {
    const scenes = this.kept && this.kept.kind === this.scene.kind
      ? [this.scene, this.kept] : [this.scene];
    if (this.stage) {
      await this.stage.replace(scenes);
    } else {
      this.stage = new Stage(scenes, data.fields);
      this.stage.onTime(() => this.#mark());
      this.stage.setTime(scenes[0].steps - 1);
      if (this.there) {
        await this.stage.begin(root.dataset.theme === 'dark');
        this.views.push(this.stage);
      }
    }
    this.stage.note = [this.#named(), said].filter(Boolean).join('; ');
    root.dataset.ready = this.there ? 'webgl' : 'flat';
  }
}

new Explorer();
