// The front of designs, and the shape and the numbers of the design that is pointed at.

import { scatterChart } from './chart.js';
import { element } from './format.js';
import { unpack } from './packed.js';
import { Viewer } from './viewer.js';

const $ = (id) => document.getElementById(id);
const PRINT = { width: 900, height: 600 }; // pixels of the picture that is printed

export class Front {
  constructor(spec, fields, there) {
    this.spec = spec;
    this.fields = fields;
    this.models = [];
    if (there && spec.models.length) {
      this.viewer = new Viewer($('design-view'), { fields, label: 'Shape of the design' });
      this.viewer.setLayers({ ghost: false });
    } else {
      $('design-view').hidden = true;
    }
    const chart = scatterChart($('front-chart'), spec, { choose: (i) => this.#choose(i) });
    chart.select(spec.start);
  }

  setTheme(dark) {
    this.viewer?.setTheme(dark);
  }

  async #choose(index) {
    this.wanted = index;
    const { label, rows, model } = this.spec.points[index];
    $('design-name').textContent = label;
    const table = $('design-rows');
    table.replaceChildren();
    for (const [name, value] of rows) {
      const row = table.insertRow();
      row.append(element('th', { scope: 'row' }, name));
      row.append(element('td', { class: 'number' }, value));
    }
    const none = model === null || !this.viewer;
    $('design-view').classList.toggle('empty', none);
    $('design-printed').removeAttribute('src');
    if (none) return;
    const first = !this.models.some(Boolean);
    this.models[model] ??= await unpack(this.spec.models[model], this.fields);
    if (this.wanted !== index) return;
    this.viewer.show([this.models[model]], { keepCamera: !first });
    $('design-printed').src = this.viewer.image(PRINT.width, PRINT.height);
    document.documentElement.dataset.design = label;
  }
}
