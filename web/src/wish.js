// The curve that the cavity's pressure should follow, and the supply's commands for it.

import { stackedChart } from './chart.js';
import { element } from './format.js';

const $ = (id) => document.getElementById(id);
const CURVE = ['rise_s', 'hold_s'];
const box = (name) => $(`wish-${name}`);

export class Wish {
  constructor(send) {
    this.send = send;
    this.asked = 0;
    for (const name of CURVE) {
      box(name).addEventListener('change', () => {
        if (box(name).value === '') box(name).value = box(name).defaultValue;
        this.ask();
      });
    }
  }

  /** Ask for the commands of the design that is shown. */
  ask() {
    if ($('wish').hidden) return;
    this.clear(['finding the commands']);
    const curve = Object.fromEntries(CURVE.map((name) => [name, +box(name).value]));
    this.send({ do: 'follow', id: this.asked, curve });
  }

  /** Show sentences alone; what was asked for before is of another design or curve. */
  clear(said = []) {
    this.asked += 1;
    this.#show(said);
  }

  hear({ id, text, said = [text], chart }) {
    if (id === this.asked) this.#show(said, chart);
  }

  #show(said, spec = null) {
    this.chart?.dispose();
    this.chart = spec && stackedChart($('follow-chart'), spec);
    $('follow-said').textContent = said.join('; ');
    const keys = [...(spec?.series ?? []), ...(spec?.below.series ?? [])].map(({ colour, style, name }) => {
      const key = element('span', { class: `${colour} ${style}` });
      key.append(element('i'), name);
      return key;
    });
    $('follow-key').replaceChildren(...keys);
  }
}
