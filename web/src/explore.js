// The explorer's page: what its controls ask the server for, and what the server's answers show.

import { lineChart, scatterChart } from './chart.js';
import { element, formatted, joined } from './format.js';
import { Rig } from './rig.js';
import { Socket } from './socket.js';
import { Stage } from './stage.js';
import { themes } from './theme.js';
import { webgl } from './viewer.js';

const $ = (id) => document.getElementById(id);
const root = document.documentElement;
const data = JSON.parse($('data').textContent);
const GRIPPER = ['L_mm', 'W_mm', 'R_mm'];
const FOOD = ['friction', 'turn_deg'];
const DIGITS = 4; // of a slider's value
const SOLVED = { bending: 'free bending', blocked_force: 'blocked force' };

class Explorer {
  constructor() {
    root.classList.add('scripted');
    this.view = data.view;
    this.values = data.sliders.map((slider) => slider.value);
    this.asked = 0;
    this.charts = [];
    this.kept = null;
    this.views = [];
    this.there = webgl().there;
    root.classList.toggle('webgl', this.there);
    this.apply = themes(this.views);
    this.#controls();
    this.#front();
    this.socket = new Socket('/tab', {
      hear: (message) => this.#hear(message),
      state: (open) => this.#connection(open),
    });
    this.rig = new Rig((message) => this.socket.send({ ...message, ...this.design() }));
    this.ask();
  }

  /** The design that the controls say, as the server reads it. */
  design() {
    const inputs = Object.fromEntries(data.sliders.map(({ key }, i) => [key, this.values[i]]));
    const found = { view: this.view, inputs };
    if (this.view !== 'grasp') return found;
    const numbers = (names) =>
      Object.fromEntries(names.map((n) => [n, $(n).value === '' ? null : +$(n).value]));
    found.gripper = { pose: $('pose').value, alpha_deg: +$('alpha').value, ...numbers(GRIPPER) };
    found.food = { kind: $('kind').value, ...numbers(FOOD) };
    found.pressure_kPa = +$('pressure_kPa').value;
    return found;
  }

  ask() {
    this.asked += 1;
    root.dataset.asked = this.asked;
    this.socket.send({ do: 'show', id: this.asked, ...this.design() });
    const text = encodeURIComponent(JSON.stringify(this.design()));
    for (const suffix of ['stl', 'step', 'toml']) $(suffix).href = `/export/${suffix}?design=${text}`;
  }

  #controls() {
    data.sliders.forEach((slider, i) => {
      const input = $(`p-${i}`);
      input.addEventListener('input', () => {
        this.values[i] = +(+input.value).toPrecision(DIGITS);
        this.#label(i);
        this.ask();
      });
      this.#label(i);
    });
    for (const button of document.querySelectorAll('[data-view]')) {
      button.addEventListener('click', () => this.#show(button.dataset.view));
    }
    $('pose').addEventListener('change', () => {
      $('alpha').value = data.alpha_deg[$('pose').value];
      this.#alpha();
      this.ask();
    });
    $('alpha').addEventListener('input', () => {
      this.#alpha();
      this.ask();
    });
    this.#alpha();
    for (const name of [...GRIPPER, ...FOOD, 'kind', 'pressure_kPa']) {
      $(name).addEventListener('change', () => this.ask());
    }
    $('solve').addEventListener('click', () => {
      $('error').hidden = true;
      this.socket.send({ do: 'solve', ...this.design() });
    });
    $('cancel').addEventListener('click', () => this.socket.send({ do: 'cancel' }));
    $('reset').addEventListener('click', () => this.#set(data.sliders.map((s) => s.value)));
    $('keep').addEventListener('click', () => {
      this.kept = this.kept || !this.scene ? null : { ...this.scene, title: `kept: ${this.#named()}` };
      $('keep').setAttribute('aria-pressed', this.kept !== null);
      this.#stage();
    });
  }

  #named() {
    return data.sliders.map((s, i) => `${s.label} ${formatted(this.values[i])}`).join(', ');
  }

  #label(i) {
    const { unit } = data.sliders[i];
    const text = joined(formatted(this.values[i]), unit);
    $(`o-${i}`).textContent = text;
    $(`p-${i}`).setAttribute('aria-valuetext', text);
  }

  #alpha() {
    $('o-alpha').textContent = joined(formatted(+$('alpha').value), '°');
  }

  #set(values) {
    this.values = values;
    values.forEach((value, i) => {
      $(`p-${i}`).value = value;
      this.#label(i);
    });
    this.ask();
  }

  #show(view) {
    this.view = view;
    for (const button of document.querySelectorAll('[data-view]')) {
      button.setAttribute('aria-pressed', button.dataset.view === view);
    }
    $('gripper').hidden = $('food').hidden = view !== 'grasp';
    this.ask();
  }

  #front() {
    if (!data.front) return;
    this.front = scatterChart($('front-chart'), data.front, {
      take: (i) => {
        const { inputs } = data.front.points[i];
        this.#set(data.sliders.map(({ key }, n) => inputs[key] ?? this.values[n]));
      },
    });
  }

  #connection(open) {
    root.dataset.connected = open;
    if (open && this.lost) this.ask();
    this.lost = !open;
    if (!open) $('state').textContent = 'not connected: is dolfingrip explore running?';
  }

  #hear(message) {
    if (message.is === 'state') this.#state(message);
    else if (message.is === 'shown') this.#shown(message);
    else if (message.is === 'solved') {
      root.dataset.solved = +(root.dataset.solved ?? 0) + 1;
      this.ask();
    } else if (message.is === 'replaced') $('state').textContent = 'a newer request took its place';
    else if (message.is === 'error' && ['show', 'solve', 'message'].includes(message.about)) {
      $('error').textContent = message.text;
      $('error').hidden = false;
      root.dataset.shown = message.id ?? root.dataset.shown;
    } else this.rig.hear(message);
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
    $('work-said').textContent = `${view}: ${total ? `${done} of ${total}, ` : ''}${note}`;
  }

  #shown(message) {
    if (message.id !== this.asked) return; // a newer one is on its way
    $('error').hidden = true;
    [this.scene] = message.scenes;
    $('where').textContent = message.said;
    $('solve').textContent = message.solved ? 'Solved' : 'Solve';
    $('solve').disabled = message.solved;
    this.#numbers(message.numbers);
    this.#curves(message.charts);
    if (this.front) {
      const [x, y] = data.axes;
      const { place } = message;
      this.front.here(place[x] === undefined ? null : [place[x], place[y]]);
    }
    this.#stage().then(() => {
      root.dataset.origin = message.said;
      root.dataset.shown = message.id;
    });
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
  }

  async #stage() {
    const scenes = this.kept && this.kept.kind === this.scene.kind
      ? [this.scene, this.kept] : [this.scene];
    if (this.stage) {
      await this.stage.replace(scenes);
    } else {
      this.stage = new Stage(scenes, data.fields);
      this.stage.onTime(([time]) => {
        for (const chart of this.charts) chart.mark({ 0: time });
      });
      this.stage.setTime(scenes[0].steps - 1);
      if (this.there) {
        await this.stage.begin(root.dataset.theme === 'dark');
        this.views.push(this.stage);
      }
    }
    root.dataset.ready = this.there ? 'webgl' : 'flat';
  }
}

new Explorer();
