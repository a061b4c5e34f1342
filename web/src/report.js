// The page of a report: reads its data and wires its parts to one another.

import { stackedChart } from './chart.js';
import { Front } from './front.js';
import { Stage } from './stage.js';
import { themes } from './theme.js';
import { webgl } from './viewer.js';

const root = document.documentElement;
const data = JSON.parse(document.getElementById('data').textContent);
const views = [];

async function begin() {
  root.classList.add('scripted');
  const apply = themes(views);
  const there = webgl().there;
  const stage = data.scenes.length ? new Stage(data.scenes, data.fields) : null;
  const charts = data.charts.map((spec) =>
    stackedChart(document.getElementById(spec.id), spec, {
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
  if (data.front) views.push(new Front(data.front, data.fields, there));
  apply();
  root.dataset.ready = there ? 'webgl' : 'flat';
}

begin();
