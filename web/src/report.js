// The page of a report: reads its data and wires its parts to one another.

import { lineChart } from './chart.js';
import { Front } from './front.js';
import { Stage } from './stage.js';
import { webgl } from './viewer.js';

const root = document.documentElement;
const data = JSON.parse(document.getElementById('data').textContent);
const KEY = 'dolfingrip-theme';
const NEXT = { auto: 'light', light: 'dark', dark: 'auto' };
const SIGN = { auto: '◐ Auto', light: '☀ Light', dark: '☾ Dark' };

const views = [];

/** The reader's choice of light or dark; a page from a file may have no memory for it. */
function themes() {
  const system = matchMedia('(prefers-color-scheme: dark)');
  const button = document.getElementById('theme');
  let choice = 'auto';
  try {
    choice = localStorage.getItem(KEY) ?? 'auto';
  } catch {
    // no memory: the system's choice
  }
  const apply = () => {
    const dark = choice === 'dark' || (choice === 'auto' && system.matches);
    root.dataset.theme = dark ? 'dark' : 'light';
    button.textContent = SIGN[choice] ?? SIGN.auto;
    for (const view of views) view.setTheme(dark);
  };
  button.addEventListener('click', () => {
    choice = NEXT[choice] ?? 'auto';
    try {
      localStorage.setItem(KEY, choice);
    } catch {
      // this page alone
    }
    apply();
  });
  system.addEventListener('change', apply);
  apply();
  return apply;
}

async function begin() {
  root.classList.add('scripted');
  const apply = themes();
  const there = webgl().there;
  const stage = data.scenes.length ? new Stage(data.scenes, data.palettes) : null;
  const charts = data.charts.map((spec) =>
    lineChart(document.getElementById(spec.id), spec, {
      pick: (scene, index) => stage?.pick(scene, index),
    }),
  );
  if (stage) {
    stage.onTime((times) => {
      const now = Object.fromEntries(times.map((time, i) => [i, time]));
      for (const chart of charts) chart.mark(now);
    });
    stage.setTime(data.scenes[stage.lead].steps - 1);
    root.classList.toggle('webgl', there);
    if (there) {
      await stage.begin(root.dataset.theme === 'dark');
      views.push(stage);
    }
  }
  if (data.front) views.push(new Front(data.front, data.palettes, there));
  apply();
  root.dataset.ready = there ? 'webgl' : 'flat';
}

begin();
