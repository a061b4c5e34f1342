// The form that makes the files of a measurement, and the plan of it.

const $ = (id) => document.getElementById(id);
const PROTOCOL = ['highest_pressure_kPa', 'step_kPa', 'cycles', 'hold_s'];
const RIG = ['rate_kPa_per_s', 'gap_mm', 'angle_deg', 'force_N', 'gauge_length_mm', 'area_mm2'];

export class Rig {
  constructor(send) {
    $('make').addEventListener('click', () => this.#filled() && send({ do: 'rig', answers: this.#answers() }));
    $('plan').addEventListener('click', () => {
      if (!this.#filled()) return;
      $('planning').textContent = 'planning';
      send({ do: 'plan', answers: this.#answers() });
      send({ do: 'rig', answers: this.#answers() });
    });
    $('rig').addEventListener('submit', (event) => event.preventDefault());
  }

  /** Whether every box that began with a number has one; else the first without is told. */
  #filled() {
    const empty = [...PROTOCOL, ...RIG].map($).find(({ value, defaultValue, validity }) =>
      validity.badInput || (value === '' && defaultValue !== ''));
    if (empty) this.#refused(`${empty.labels[0].textContent}: empty; allowed: a number`);
    return !empty;
  }

  #refused(text) {
    $('planning').textContent = '';
    $('rig-error').textContent = text;
    $('rig-error').hidden = false;
  }

  #answers() {
    const value = (name) => ($(name).value === '' ? null : +$(name).value);
    const numbers = (names) => Object.fromEntries(names.map((name) => [name, value(name)]));
    const boxes = document.querySelectorAll('[name=experiments]:checked');
    const protocol = { ...numbers(PROTOCOL), unload: $('unload').checked, tip: $('tip').checked };
    const experiments = [...boxes].map((box) => box.value);
    return { experiments, ...numbers(RIG), protocol };
  }

  hear(message) {
    if (message.is === 'rig') this.#made(message);
    else if (message.is === 'planning') $('planning').textContent = message.text;
    else if (message.is === 'planned') {
      $('planning').textContent = `written to ${message.folder}`;
      $('plan-text').textContent = message.text;
      $('planned').hidden = false;
    } else if (message.is === 'error') this.#refused(message.text);
  }

  #made({ setup, header, readings }) {
    $('rig-error').hidden = true;
    $('made').hidden = false;
    $('setup').textContent = setup;
    $('csv-header').textContent = header;
    $('readings').textContent = `The protocol has ${readings} readings. Fill in a row for each.`;
    this.#link('get-toml', setup);
    this.#link('get-csv', `${header}\n`);
  }

  #link(id, text) {
    URL.revokeObjectURL($(id).href);
    $(id).href = URL.createObjectURL(new Blob([text], { type: 'text/plain' }));
  }
}
