/**
 * Charts in SVG, drawn at their real width so that text never shrinks.
 *
 *     const chart = lineChart(box, spec, { pick: (series, index) => … });
 *     chart.mark({ 0: 2.5 });   // scene 0 is at its time 2.5: a dot on each of its series
 *
 * A spec is what `dolfingrip/charts/chart.py` calls a Chart.
 */

import { element, formatted, joined, ticks } from './format.js';

const NAMESPACE = 'http://www.w3.org/2000/svg';
const MARGIN = { right: 16, top: 14, bottom: 44, shared: 6 }; // shared: the axis stands below
const LEFT = { beside: 30, letter: 7, least: 56 }; // pixels: the label, a letter of a tick's number
const LETTER = { size: 13, width: 0.56, least: 9.5 }; // of labels: pixels, width by size
const NARROW = 420; // pixels below which an axis has fewer ticks
const NEAR = 26; // pixels within which the pointer means a point
const CAP = 3; // pixels: half the width of an error bar's ends
const EQUAL = { least: 200, most: 460 }; // pixels: height of a chart whose axes have one scale
const LOWER = 170; // pixels: height of a chart below another one
const FEW = 80; // points of a series, up to which each has a ring
const DENSE = 300; // points of a series, from which marks are smallest

export function svg(parent, name, attributes = {}, text = null) {
  const made = document.createElementNS(NAMESPACE, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== null) made.textContent = text;
  parent.append(made);
  return made;
}

/** Ends of an axis: those of the numbers and a little more, from zero if they are close to it. */
function ends(numbers) {
  const known = numbers.filter((v) => v !== null && Number.isFinite(v));
  let low = Math.min(...known, Infinity);
  let high = Math.max(...known, -Infinity);
  if (!known.length) return [0, 1];
  if (low === high) [low, high] = [low - (Math.abs(low) || 1) / 2, high + (Math.abs(high) || 1) / 2];
  const span = high - low;
  if (low >= -0.02 * span && low < 0.4 * span) low = 0;
  else low -= 0.04 * span;
  return [low, high + 0.05 * span];
}

/** Ends so far apart, about the same middle. */
function widened([low, high], span) {
  return [(low + high - span) / 2, (low + high + span) / 2];
}

/** Pixels to the left of an axis with these ends. */
function leftOf(yEnds) {
  const longest = Math.max(...ticks(...yEnds, 5).map((v) => formatted(v).length), 1);
  return Math.max(LEFT.least, LEFT.beside + LEFT.letter * longest);
}

/** Axes, grid and labels in an empty box; functions from numbers to pixels. */
export function frame(box, { alt, x, y, xEnds, yEnds, height, left = leftOf(yEnds), below, equal }) {
  const width = Math.max(240, box.clientWidth);
  let tall = height ?? Math.round(Math.min(320, Math.max(230, width * 0.6)));
  if (equal) { // one scale for both axes: what is steep or flat leaves room beside it
    const [w, edges] = [width - left - MARGIN.right, MARGIN.top + MARGIN.bottom];
    const [spanX, spanY] = [xEnds, yEnds].map(([low, high]) => high - low);
    tall = Math.min(EQUAL.most, Math.max(EQUAL.least, (w * spanY) / spanX + edges));
    const pixel = Math.max(spanX / w, spanY / (tall - edges));
    xEnds = widened(xEnds, pixel * w);
    yEnds = widened(yEnds, pixel * (tall - edges));
  }
  box.replaceChildren();
  const root = svg(box, 'svg', { viewBox: `0 0 ${width} ${tall}`, role: 'img', 'aria-label': alt });
  const [right, bottom] = [width - MARGIN.right, tall - (below ? MARGIN.shared : MARGIN.bottom)];
  const ups = ticks(...yEnds, 5);
  const across = (v) => left + ((v - xEnds[0]) / (xEnds[1] - xEnds[0])) * (right - left);
  const up = (v) => bottom - ((v - yEnds[0]) / (yEnds[1] - yEnds[0])) * (bottom - MARGIN.top);
  const grid = svg(root, 'g', { class: 'grid' });
  for (const v of ticks(...xEnds, width < NARROW ? 4 : 6)) {
    svg(grid, 'line', { x1: across(v), x2: across(v), y1: MARGIN.top, y2: bottom });
    if (below) continue;
    svg(root, 'text', { x: across(v), y: bottom + 17, class: 'tick middle' }, formatted(v));
  }
  for (const v of ups) {
    svg(grid, 'line', { x1: left, x2: right, y1: up(v), y2: up(v) });
    svg(root, 'text', { x: left - 7, y: up(v) + 4, class: 'tick end' }, formatted(v));
  }
  const [cx, cy] = [(left + right) / 2, (MARGIN.top + bottom) / 2];
  const label = (text, room, attributes) => {
    const fits = room / (LETTER.width * Math.max(text.length, 1));
    const made = svg(root, 'text', { class: 'axis middle', ...attributes }, text);
    made.style.fontSize = `${Math.max(LETTER.least, Math.min(LETTER.size, fits))}px`;
  };
  if (!below) label(x.label, right - left, { x: cx, y: tall - 7 });
  label(y.label, tall, { x: 14, y: cy, transform: `rotate(-90 14 ${cy})` });
  const inverse = (clientX, clientY) => {
    const place = root.getBoundingClientRect();
    const scale = width / place.width;
    return [(clientX - place.left) * scale, (clientY - place.top) * scale];
  };
  return { root, across, up, width, tall, right, bottom, top: MARGIN.top, left, inverse };
}

/** A box beside the pointer; it never leaves its chart. */
export class Tip {
  constructor(box) {
    this.box = box;
    this.node = element('div', { class: 'tip', role: 'status', hidden: '' });
    box.after(this.node);
  }

  show(x, y, title, rows) {
    this.node.replaceChildren(element('b', {}, title));
    for (const { cls, text } of rows) {
      const row = element('div', {});
      if (cls) row.append(element('i', { class: cls }));
      row.append(text);
      this.node.append(row);
    }
    this.node.hidden = false;
    const room = this.box.clientWidth - this.node.offsetWidth;
    const left = x > this.box.clientWidth / 2 ? x - this.node.offsetWidth - 14 : x + 14;
    this.node.style.left = `${Math.max(0, Math.min(room, left))}px`;
    this.node.style.top = `${Math.max(0, y - 12)}px`;
  }

  hide() {
    this.node.hidden = true;
  }
}

/** Draw again whenever the width of a box changes. */
export function onWidth(box, draw) {
  let width = 0;
  const observer = new ResizeObserver(() => {
    if (Math.abs(box.clientWidth - width) < 2) return;
    width = box.clientWidth;
    draw();
  });
  observer.observe(box);
  draw();
  return observer;
}

/** Error bars of points; those of many have no ends. */
function bars(f, { x, low, high }, many) {
  const one = (at, from, to) => `M${at - CAP} ${from}h${2 * CAP}M${at} ${from}V${to}M${at - CAP} ${to}h${2 * CAP}`;
  const plain = (at, from, to) => `M${at} ${from}V${to}`;
  return x
    .map((v, i) => (v === null || low[i] === null ? '' : (many ? plain : one)(
      ...[f.across(v), f.up(low[i]), f.up(high[i])].map((px) => +px.toFixed(1)))))
    .join('');
}

function path(points) {
  let text = '';
  let pen = 'M';
  for (const [x, y] of points) {
    if (x === null || y === null) {
      pen = 'M';
      continue;
    }
    text += `${pen}${x.toFixed(1)} ${y.toFixed(1)}`;
    pen = 'L';
  }
  return text;
}

/** The point of a curve at a time of its scene, between two of its points. */
function pointAt(series, time) {
  const last = series.x.length - 1;
  const from = Math.max(0, Math.min(Math.floor(time), last));
  const to = Math.min(from + 1, last);
  const share = Math.max(0, Math.min(time - from, 1));
  const between = (all) =>
    all[from] === null || all[to] === null ? null : all[from] + (all[to] - all[from]) * share;
  return [between(series.x), between(series.y)];
}

const every = (spec, key) => spec.series.flatMap((s) => s[key] ?? []);
const yEndsOf = (spec) => spec.y.ends ?? ends([...every(spec, 'y'), ...every(spec, 'low'),
  ...every(spec, 'high'), ...(spec.limits ?? []).map((limit) => limit.y)]);

/** A chart, and the one below it on the same horizontal axis if it has one: a plot for each. */
export function stackedChart(box, spec, options = {}) {
  const all = [spec, spec.below].filter(Boolean);
  const xEnds = spec.x.ends ?? ends(all.flatMap((each) => every(each, 'x')));
  const left = Math.max(...all.map((each) => leftOf(yEndsOf(each))));
  const parts = all.map((each, i) =>
    lineChart(box.children[i].firstElementChild, {
      ...each, left, x: { ...each.x, ends: xEnds }, height: i ? LOWER : undefined,
    }, options),
  );
  return {
    mark: (now) => parts.forEach((part) => part.mark(now)),
    dispose: () => parts.forEach((part) => part.dispose()),
  };
}

/** Lines, points, bands and error bars over one axis. */
export function lineChart(box, spec, { pick = () => {} } = {}) {
  const tip = new Tip(box);
  let times = {};
  let drawn = null;
  const xEnds = spec.x.ends ?? ends(every(spec, 'x'));
  const yEnds = yEndsOf(spec);

  const draw = () => {
    const f = (drawn = frame(box, { ...spec, xEnds, yEnds }));
    for (const limit of spec.limits ?? []) {
      const y = f.up(limit.y);
      const kind = limit.label ? 'limit' : 'limit zero';
      svg(f.root, 'line', { x1: f.left, x2: f.right, y1: y, y2: y, class: kind });
      svg(f.root, 'text', { x: f.right - 4, y: y - 5, class: 'limit-text end' }, limit.label);
    }
    for (const s of spec.series) {
      if (!s.low || s.style === 'points') continue;
      const high = s.x.map((x, i) => [f.across(x), f.up(s.high[i])]);
      const low = s.x.map((x, i) => [f.across(x), f.up(s.low[i])]).reverse();
      svg(f.root, 'path', { class: `band ${s.colour}`, d: `${path([...high, ...low])}Z` });
    }
    const upwards = [...spec.series].sort((a, b) => (a.style === 'points') - (b.style === 'points'));
    for (const s of upwards) {
      const points = s.x.map((x, i) => [x === null ? null : f.across(x),
        s.y[i] === null ? null : f.up(s.y[i])]);
      if (s.style !== 'points') {
        svg(f.root, 'path', { class: `line ${s.colour} ${s.style}`, d: path(points) });
      }
      const many = s.x.length > FEW;
      if (!s.dots || s.style === 'dash' || (many && s.style !== 'points')) continue; // the line shows them
      if (s.low && s.style === 'points') {
        const kind = `bars-of ${s.colour}${many ? ' many' : ''}`;
        svg(f.root, 'path', { class: kind, d: bars(f, s, many) });
      }
      const r = !many ? 3 : s.x.length < DENSE ? 1.8 : 1.2;
      const there = new Set(); // of thousands of points, those that lie on others add nothing
      for (const [x, y] of points) {
        const place = `${Math.round(x)} ${Math.round(y)}`;
        if (x === null || y === null || (many && there.has(place))) continue;
        there.add(place);
        svg(f.root, 'circle', { cx: x, cy: y, r, class: `dot ${s.colour}${many ? ' full' : ''}` });
      }
    }
    drawn.cursor = svg(f.root, 'g', { class: 'cursor' });
    drawn.marks = svg(f.root, 'g', { class: 'marks' });
    f.root.addEventListener('pointermove', hover);
    f.root.addEventListener('pointerdown', hover);
    f.root.addEventListener('pointerleave', () => {
      drawn.cursor.replaceChildren();
      tip.hide();
    });
    f.root.addEventListener('click', (event) => {
      const found = nearest(event);
      if (found && found.series.scene !== null) pick(found.series.scene, found.index);
    });
    mark(times);
  };

  /** The point that the pointer means: across the chart for curves over a load, else nearest. */
  const nearest = (event) => {
    const [px, py] = drawn.inverse(event.clientX, event.clientY);
    let best = null;
    for (const series of spec.series) {
      series.x.forEach((x, index) => {
        if (x === null || series.y[index] === null) return;
        const dx = drawn.across(x) - px;
        const dy = (drawn.up(series.y[index]) - py) * 0.3;
        const distance = Math.hypot(dx, dy);
        if (!best || distance < best.distance) best = { series, index, distance };
      });
    }
    return best;
  };

  const hover = (event) => {
    const found = nearest(event);
    if (!found) return;
    const x = found.series.x[found.index];
    drawn.cursor.replaceChildren();
    const at = drawn.across(x);
    svg(drawn.cursor, 'line', { x1: at, x2: at, y1: drawn.top, y2: drawn.bottom });
    const rows = [];
    for (const series of spec.series) {
      const index = closest(series, x, series === found.series ? found.index : null, xEnds);
      if (index === null) continue;
      const [sx, sy] = [series.x[index], series.y[index]];
      svg(drawn.cursor, 'circle', {
        cx: drawn.across(sx), cy: drawn.up(sy), r: 4.5, class: `dot ${series.colour}`,
      });
      const band = series.low
        ? ` (${formatted(series.low[index])} to ${formatted(series.high[index])})`
        : '';
      const elsewhere = Math.abs(sx - x) > 1e-6 * (xEnds[1] - xEnds[0])
        ? ` at ${joined(formatted(sx), spec.x.unit)}` : '';
      rows.push({
        cls: series.colour,
        text: `${series.name}: ${joined(formatted(sy), spec.y.unit)}${band}${elsewhere}`,
      });
    }
    const title = joined(formatted(x), spec.x.unit);
    tip.show(at, drawn.up(found.series.y[found.index]), title, rows);
  };

  const mark = (now) => {
    times = now;
    if (!drawn) return;
    drawn.marks.replaceChildren();
    const lines = new Set();
    for (const series of spec.series) {
      if (series.scene === null || now[series.scene] === undefined) continue;
      const [x, y] = pointAt(series, now[series.scene]);
      if (x === null) continue;
      const at = drawn.across(x).toFixed(1);
      if (!lines.has(at)) {
        svg(drawn.marks, 'line', { x1: at, x2: at, y1: drawn.top, y2: drawn.bottom, class: 'mark' });
        lines.add(at);
      }
      if (y === null) continue;
      svg(drawn.marks, 'circle', { cx: at, cy: drawn.up(y), r: 5.5, class: `now ${series.colour}` });
    }
  };

  const observer = onWidth(box, draw);
  const dispose = () => {
    observer.disconnect();
    tip.node.remove();
    box.replaceChildren();
  };
  return { mark, spec, dispose };
}

/** The index of a series' point at the place of another one's; null if it has none close to it. */
function closest(series, x, known, [low, high]) {
  if (known !== null) return known;
  let best = null;
  series.x.forEach((each, i) => {
    if (each === null || series.y[i] === null) return;
    if (best === null || Math.abs(each - x) < Math.abs(series.x[best] - x)) best = i;
  });
  return best !== null && Math.abs(series.x[best] - x) <= 0.06 * (high - low) ? best : null;
}

/**
 * Designs in the plane of two objectives; pointing at one, or focusing it, tells which.
 *
 * `choose` is called with the design that is pointed at, `take` with one that is clicked on.
 */
export function scatterChart(box, spec, { choose = () => {}, take = () => {} } = {}) {
  const tip = new Tip(box);
  let chosen = -1;
  let place = null;
  const { points, line } = spec;
  const xEnds = ends([...points.map((p) => p.x), ...(line?.x ?? [])]);
  const yEnds = ends([...points.map((p) => p.y), ...(line?.y ?? [])]);
  let nodes = [];
  let f = null;

  const select = (index, tell = true) => {
    nodes[chosen]?.classList.remove('on');
    chosen = index;
    nodes[index]?.classList.add('on');
    if (tell) choose(index);
  };
  const say = (index) => {
    const p = points[index];
    const values = [
      { text: `${spec.x.short}: ${joined(formatted(p.x), spec.x.unit)}` },
      { text: `${spec.y.short}: ${joined(formatted(p.y), spec.y.unit)}` },
    ];
    tip.show(f.across(p.x), f.up(p.y), p.label, values);
  };
  const draw = () => {
    f = frame(box, { ...spec, xEnds, yEnds, height: Math.min(360, Math.max(260, box.clientWidth * 0.7)) });
    f.root.removeAttribute('role'); // its points are buttons, which a picture cannot have
    if (line) {
      const way = path(line.x.map((x, i) => [f.across(x), f.up(line.y[i])]));
      svg(f.root, 'path', { class: 'line c1', d: way });
    }
    nodes = points.map((p, i) => {
      const node = svg(f.root, 'circle', {
        cx: f.across(p.x), cy: f.up(p.y), r: p.group === 'design' ? 4 : 6,
        class: `point ${p.group}`, role: 'button', 'aria-label': p.label,
        tabindex: p.group === 'design' ? -1 : 0,
      });
      node.addEventListener('focus', () => {
        select(i);
        say(i);
      });
      node.addEventListener('blur', () => tip.hide());
      node.addEventListener('keydown', (event) => event.key === 'Enter' && take(i));
      return node;
    });
    nodes[chosen]?.classList.add('on');
    f.root.addEventListener('pointermove', (event) => {
      const best = under(event);
      if (best < 0) return tip.hide();
      if (best !== chosen) select(best);
      return say(best);
    });
    f.root.addEventListener('pointerleave', () => tip.hide());
    f.root.addEventListener('click', (event) => {
      const found = under(event);
      if (found >= 0) take(found);
    });
    cross();
  };

  /** The design under the pointer; -1 if there is none. */
  const under = (event) => {
    const [px, py] = f.inverse(event.clientX, event.clientY);
    let best = -1;
    let least = NEAR;
    points.forEach((p, i) => {
      const distance = Math.hypot(f.across(p.x) - px, f.up(p.y) - py);
      if (distance < least) [best, least] = [i, distance];
    });
    return best;
  };

  const cross = () => {
    f.root.querySelector('.here')?.remove();
    if (!place) return;
    const [x, y] = [f.across(place[0]), f.up(place[1])];
    svg(f.root, 'path', { class: 'here', d: `M${x - 6} ${y - 6}l12 12M${x - 6} ${y + 6}l12-12` });
  };

  /** Mark a place by a cross; null takes it away. */
  const here = (at) => {
    place = at;
    cross();
  };
  onWidth(box, draw);
  return { select, here };
}
