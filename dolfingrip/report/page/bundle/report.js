(() => {
  // src/format.js
  var MINUS = "−";
  function formatted(value) {
    if (value === null || !Number.isFinite(value)) return "–";
    const size = Math.abs(value);
    let text = "0";
    if (size >= 1e5 || size > 0 && size < 1e-3) text = size.toExponential(1);
    else if (size >= 100) text = size.toFixed(0);
    else if (size >= 10) text = String(+size.toFixed(1));
    else if (size >= 1) text = String(+size.toFixed(2));
    else if (size > 0) text = String(+size.toPrecision(3));
    return (value < 0 && +text !== 0 ? MINUS : "") + text;
  }
  function joined(number, unit) {
    if (!unit || unit === "–") return number;
    return unit === "°" ? number + unit : `${number} ${unit}`;
  }
  function ticks(low, high, count) {
    const least = (high - low) / count;
    const power = 10 ** Math.floor(Math.log10(least));
    const step = [1, 2, 2.5, 5, 10].map((factor) => factor * power).find((s) => s >= least * 0.999);
    const found = [];
    for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-6 * step; i++) {
      found.push(i === 0 ? 0 : i * step);
    }
    return found;
  }
  function element(name, attributes = {}, text = null) {
    const made = document.createElement(name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== null) made.textContent = text;
    return made;
  }

  // src/chart.js
  var NAMESPACE = "http://www.w3.org/2000/svg";
  var MARGIN = { right: 16, top: 14, bottom: 44, shared: 6 };
  var LEFT = { beside: 30, letter: 7, least: 56 };
  var LETTER = { size: 13, width: 0.56, least: 9.5 };
  var NARROW = 420;
  var NEAR = 26;
  var CAP = 3;
  var EQUAL = { least: 200, most: 460 };
  var LOWER = 170;
  var FEW = 80;
  var DENSE = 300;
  function svg(parent, name, attributes = {}, text = null) {
    const made = document.createElementNS(NAMESPACE, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== null) made.textContent = text;
    parent.append(made);
    return made;
  }
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
  function widened([low, high], span) {
    return [(low + high - span) / 2, (low + high + span) / 2];
  }
  function leftOf(yEnds) {
    const longest = Math.max(...ticks(...yEnds, 5).map((v) => formatted(v).length), 1);
    return Math.max(LEFT.least, LEFT.beside + LEFT.letter * longest);
  }
  function frame(box, { alt, x, y, xEnds, yEnds, height, left = leftOf(yEnds), below, equal }) {
    const width = Math.max(240, box.clientWidth);
    let tall = height ?? Math.round(Math.min(320, Math.max(230, width * 0.6)));
    if (equal) {
      const [w, edges] = [width - left - MARGIN.right, MARGIN.top + MARGIN.bottom];
      const [spanX, spanY] = [xEnds, yEnds].map(([low, high]) => high - low);
      tall = Math.min(EQUAL.most, Math.max(EQUAL.least, w * spanY / spanX + edges));
      const pixel = Math.max(spanX / w, spanY / (tall - edges));
      xEnds = widened(xEnds, pixel * w);
      yEnds = widened(yEnds, pixel * (tall - edges));
    }
    box.replaceChildren();
    const root3 = svg(box, "svg", { viewBox: `0 0 ${width} ${tall}`, role: "img", "aria-label": alt });
    const [right, bottom] = [width - MARGIN.right, tall - (below ? MARGIN.shared : MARGIN.bottom)];
    const ups = ticks(...yEnds, 5);
    const across = (v) => left + (v - xEnds[0]) / (xEnds[1] - xEnds[0]) * (right - left);
    const up = (v) => bottom - (v - yEnds[0]) / (yEnds[1] - yEnds[0]) * (bottom - MARGIN.top);
    const grid2 = svg(root3, "g", { class: "grid" });
    for (const v of ticks(...xEnds, width < NARROW ? 4 : 6)) {
      svg(grid2, "line", { x1: across(v), x2: across(v), y1: MARGIN.top, y2: bottom });
      if (below) continue;
      svg(root3, "text", { x: across(v), y: bottom + 17, class: "tick middle" }, formatted(v));
    }
    for (const v of ups) {
      svg(grid2, "line", { x1: left, x2: right, y1: up(v), y2: up(v) });
      svg(root3, "text", { x: left - 7, y: up(v) + 4, class: "tick end" }, formatted(v));
    }
    const [cx, cy] = [(left + right) / 2, (MARGIN.top + bottom) / 2];
    const label = (text, room, attributes) => {
      const fits = room / (LETTER.width * Math.max(text.length, 1));
      const made = svg(root3, "text", { class: "axis middle", ...attributes }, text);
      made.style.fontSize = `${Math.max(LETTER.least, Math.min(LETTER.size, fits))}px`;
    };
    if (!below) label(x.label, right - left, { x: cx, y: tall - 7 });
    label(y.label, tall, { x: 14, y: cy, transform: `rotate(-90 14 ${cy})` });
    const inverse = (clientX, clientY) => {
      const place = root3.getBoundingClientRect();
      const scale = width / place.width;
      return [(clientX - place.left) * scale, (clientY - place.top) * scale];
    };
    return { root: root3, across, up, width, tall, right, bottom, top: MARGIN.top, left, inverse };
  }
  var Tip = class {
    constructor(box) {
      this.box = box;
      this.node = element("div", { class: "tip", role: "status", hidden: "" });
      box.after(this.node);
    }
    show(x, y, title, rows) {
      this.node.replaceChildren(element("b", {}, title));
      for (const { cls, text } of rows) {
        const row = element("div", {});
        if (cls) row.append(element("i", { class: cls }));
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
  };
  function onWidth(box, draw) {
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
  function bars(f, { x, low, high }, many) {
    const one = (at, from, to) => `M${at - CAP} ${from}h${2 * CAP}M${at} ${from}V${to}M${at - CAP} ${to}h${2 * CAP}`;
    const plain = (at, from, to) => `M${at} ${from}V${to}`;
    return x.map((v, i) => v === null || low[i] === null ? "" : (many ? plain : one)(
      ...[f.across(v), f.up(low[i]), f.up(high[i])].map((px) => +px.toFixed(1))
    )).join("");
  }
  function path(points) {
    let text = "";
    let pen = "M";
    for (const [x, y] of points) {
      if (x === null || y === null) {
        pen = "M";
        continue;
      }
      text += `${pen}${x.toFixed(1)} ${y.toFixed(1)}`;
      pen = "L";
    }
    return text;
  }
  function pointAt(series, time) {
    const last = series.x.length - 1;
    const from = Math.max(0, Math.min(Math.floor(time), last));
    const to = Math.min(from + 1, last);
    const share = Math.max(0, Math.min(time - from, 1));
    const between = (all) => all[from] === null || all[to] === null ? null : all[from] + (all[to] - all[from]) * share;
    return [between(series.x), between(series.y)];
  }
  var every = (spec, key) => spec.series.flatMap((s) => s[key] ?? []);
  var yEndsOf = (spec) => spec.y.ends ?? ends([
    ...every(spec, "y"),
    ...every(spec, "low"),
    ...every(spec, "high"),
    ...(spec.limits ?? []).map((limit) => limit.y)
  ]);
  function stackedChart(box, spec, options = {}) {
    const all = [spec, spec.below].filter(Boolean);
    const xEnds = spec.x.ends ?? ends(all.flatMap((each) => every(each, "x")));
    const left = Math.max(...all.map((each) => leftOf(yEndsOf(each))));
    const parts = all.map(
      (each, i) => lineChart(box.children[i].firstElementChild, {
        ...each,
        left,
        x: { ...each.x, ends: xEnds },
        height: i ? LOWER : void 0
      }, options)
    );
    return {
      mark: (now) => parts.forEach((part) => part.mark(now)),
      dispose: () => parts.forEach((part) => part.dispose())
    };
  }
  function lineChart(box, spec, { pick = () => {
  } } = {}) {
    const tip = new Tip(box);
    let times = {};
    let drawn = null;
    const xEnds = spec.x.ends ?? ends(every(spec, "x"));
    const yEnds = yEndsOf(spec);
    const draw = () => {
      const f = drawn = frame(box, { ...spec, xEnds, yEnds });
      for (const limit of spec.limits ?? []) {
        const y = f.up(limit.y);
        const kind = limit.label ? "limit" : "limit zero";
        svg(f.root, "line", { x1: f.left, x2: f.right, y1: y, y2: y, class: kind });
        svg(f.root, "text", { x: f.right - 4, y: y - 5, class: "limit-text end" }, limit.label);
      }
      for (const s of spec.series) {
        if (!s.low || s.style === "points") continue;
        const high = s.x.map((x, i) => [f.across(x), f.up(s.high[i])]);
        const low = s.x.map((x, i) => [f.across(x), f.up(s.low[i])]).reverse();
        svg(f.root, "path", { class: `band ${s.colour}`, d: `${path([...high, ...low])}Z` });
      }
      const upwards = [...spec.series].sort((a, b) => (a.style === "points") - (b.style === "points"));
      for (const s of upwards) {
        const points = s.x.map((x, i) => [
          x === null ? null : f.across(x),
          s.y[i] === null ? null : f.up(s.y[i])
        ]);
        if (s.style !== "points") {
          svg(f.root, "path", { class: `line ${s.colour} ${s.style}`, d: path(points) });
        }
        const many = s.x.length > FEW;
        if (!s.dots || s.style === "dash" || many && s.style !== "points") continue;
        if (s.low && s.style === "points") {
          const kind = `bars-of ${s.colour}${many ? " many" : ""}`;
          svg(f.root, "path", { class: kind, d: bars(f, s, many) });
        }
        const r = !many ? 3 : s.x.length < DENSE ? 1.8 : 1.2;
        const there = /* @__PURE__ */ new Set();
        for (const [x, y] of points) {
          const place = `${Math.round(x)} ${Math.round(y)}`;
          if (x === null || y === null || many && there.has(place)) continue;
          there.add(place);
          svg(f.root, "circle", { cx: x, cy: y, r, class: `dot ${s.colour}${many ? " full" : ""}` });
        }
      }
      drawn.cursor = svg(f.root, "g", { class: "cursor" });
      drawn.marks = svg(f.root, "g", { class: "marks" });
      f.root.addEventListener("pointermove", hover);
      f.root.addEventListener("pointerdown", hover);
      f.root.addEventListener("pointerleave", () => {
        drawn.cursor.replaceChildren();
        tip.hide();
      });
      f.root.addEventListener("click", (event) => {
        const found = nearest(event);
        if (found && found.series.scene !== null) pick(found.series.scene, found.index);
      });
      mark(times);
    };
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
      svg(drawn.cursor, "line", { x1: at, x2: at, y1: drawn.top, y2: drawn.bottom });
      const rows = [];
      for (const series of spec.series) {
        const index = closest(series, x, series === found.series ? found.index : null, xEnds);
        if (index === null) continue;
        const [sx, sy] = [series.x[index], series.y[index]];
        svg(drawn.cursor, "circle", {
          cx: drawn.across(sx),
          cy: drawn.up(sy),
          r: 4.5,
          class: `dot ${series.colour}`
        });
        const band = series.low ? ` (${formatted(series.low[index])} to ${formatted(series.high[index])})` : "";
        const elsewhere = Math.abs(sx - x) > 1e-6 * (xEnds[1] - xEnds[0]) ? ` at ${joined(formatted(sx), spec.x.unit)}` : "";
        rows.push({
          cls: series.colour,
          text: `${series.name}: ${joined(formatted(sy), spec.y.unit)}${band}${elsewhere}`
        });
      }
      const title = joined(formatted(x), spec.x.unit);
      tip.show(at, drawn.up(found.series.y[found.index]), title, rows);
    };
    const mark = (now) => {
      times = now;
      if (!drawn) return;
      drawn.marks.replaceChildren();
      const lines2 = /* @__PURE__ */ new Set();
      for (const series of spec.series) {
        if (series.scene === null || now[series.scene] === void 0) continue;
        const [x, y] = pointAt(series, now[series.scene]);
        if (x === null) continue;
        const at = drawn.across(x).toFixed(1);
        if (!lines2.has(at)) {
          svg(drawn.marks, "line", { x1: at, x2: at, y1: drawn.top, y2: drawn.bottom, class: "mark" });
          lines2.add(at);
        }
        if (y === null) continue;
        svg(drawn.marks, "circle", { cx: at, cy: drawn.up(y), r: 5.5, class: `now ${series.colour}` });
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
  function closest(series, x, known, [low, high]) {
    if (known !== null) return known;
    let best = null;
    series.x.forEach((each, i) => {
      if (each === null || series.y[i] === null) return;
      if (best === null || Math.abs(each - x) < Math.abs(series.x[best] - x)) best = i;
    });
    return best !== null && Math.abs(series.x[best] - x) <= 0.06 * (high - low) ? best : null;
  }
  function scatterChart(box, spec, { choose = () => {
  }, take = () => {
  } } = {}) {
    const tip = new Tip(box);
    let chosen = -1;
    let place = null;
    const { points, line } = spec;
    const xEnds = ends([...points.map((p) => p.x), ...line?.x ?? []]);
    const yEnds = ends([...points.map((p) => p.y), ...line?.y ?? []]);
    let nodes = [];
    let f = null;
    const select = (index, tell = true) => {
      nodes[chosen]?.classList.remove("on");
      chosen = index;
      nodes[index]?.classList.add("on");
      if (tell) choose(index);
    };
    const say = (index) => {
      const p = points[index];
      const values = [
        { text: `${spec.x.short}: ${joined(formatted(p.x), spec.x.unit)}` },
        { text: `${spec.y.short}: ${joined(formatted(p.y), spec.y.unit)}` }
      ];
      tip.show(f.across(p.x), f.up(p.y), p.label, values);
    };
    const draw = () => {
      f = frame(box, { ...spec, xEnds, yEnds, height: Math.min(360, Math.max(260, box.clientWidth * 0.7)) });
      f.root.removeAttribute("role");
      if (line) {
        const way = path(line.x.map((x, i) => [f.across(x), f.up(line.y[i])]));
        svg(f.root, "path", { class: "line c1", d: way });
      }
      nodes = points.map((p, i) => {
        const node = svg(f.root, "circle", {
          cx: f.across(p.x),
          cy: f.up(p.y),
          r: p.group === "design" ? 4 : 6,
          class: `point ${p.group}`,
          role: "button",
          "aria-label": p.label,
          tabindex: p.group === "design" ? -1 : 0
        });
        node.addEventListener("focus", () => {
          select(i);
          say(i);
        });
        node.addEventListener("blur", () => tip.hide());
        node.addEventListener("keydown", (event) => event.key === "Enter" && take(i));
        return node;
      });
      nodes[chosen]?.classList.add("on");
      f.root.addEventListener("pointermove", (event) => {
        const best = under(event);
        if (best < 0) return tip.hide();
        if (best !== chosen) select(best);
        return say(best);
      });
      f.root.addEventListener("pointerleave", () => tip.hide());
      f.root.addEventListener("click", (event) => {
        const found = under(event);
        if (found >= 0) take(found);
      });
      cross();
    };
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
      f.root.querySelector(".here")?.remove();
      if (!place) return;
      const [x, y] = [f.across(place[0]), f.up(place[1])];
      svg(f.root, "path", { class: "here", d: `M${x - 6} ${y - 6}l12 12M${x - 6} ${y + 6}l12-12` });
    };
    const here = (at) => {
      place = at;
      cross();
    };
    onWidth(box, draw);
    return { select, here };
  }

  // src/packed.js
  var bytesOf = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  async function inflated(text) {
    const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream("deflate"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  }
  async function unpackNumbers(packed) {
    const { bytes, rows, columns, stride } = packed;
    const raw = await inflated(packed.data);
    const count = rows * columns;
    const out = bytes === 2 ? new Uint16Array(count) : new Uint32Array(count);
    for (let plane = 0; plane < bytes; plane++) {
      for (let i = 0; i < count; i++) out[i] |= raw[plane * count + i] << 8 * plane;
    }
    for (let row = 0; row < rows; row++) {
      const start = row * columns;
      for (let i = stride; i < columns; i++) out[start + i] += out[start + i - stride];
    }
    for (let i = columns; i < count; i++) out[i] += out[i - columns];
    return out;
  }
  function displacements(part) {
    const { positions, vertices, frames, low, high } = part;
    const scale = high.map((top, axis) => (top - low[axis]) / 65535);
    const found = new Float32Array(vertices * frames);
    for (let frame2 = 1; frame2 < frames; frame2++) {
      for (let i = 0; i < vertices; i++) {
        let sum = 0;
        for (let axis = 0; axis < 3; axis++) {
          const at = 3 * i + axis;
          const moved = positions[3 * vertices * frame2 + at] - positions[at];
          sum += (scale[axis] * moved) ** 2;
        }
        found[vertices * frame2 + i] = Math.sqrt(sum);
      }
    }
    return found;
  }
  async function unpackPart(part, ends2, fields) {
    const names = Object.keys(part.fields);
    const [triangles, lines2, creases, positions, ...told] = await Promise.all([
      unpackNumbers(part.triangles),
      unpackNumbers(part.lines),
      unpackNumbers(part.creases),
      unpackNumbers(part.positions),
      ...names.map((name) => unpackNumbers(part.fields[name]))
    ]);
    const found = { ...part, triangles, lines: lines2, creases, positions, values: {} };
    if (part.colour !== null) return found;
    names.forEach((name, at) => {
      const [low, high] = ends2[name];
      const all = new Float32Array(part.vertices * part.frames).fill(fields[name].least);
      told[at].forEach((v, i) => all[part.vertices + i] = low + (high - low) * v / 65535);
      found.values[name] = all;
    });
    found.values.displacement ??= displacements(found);
    return found;
  }
  async function unpack(packed, fields) {
    const parts = await Promise.all(packed.parts.map((p) => unpackPart(p, packed.fields, fields)));
    const peaks = {};
    for (const part of parts) {
      for (const [name, values] of Object.entries(part.values)) {
        peaks[name] ??= new Array(packed.steps).fill(0);
        for (let step = 0; step < packed.steps; step++) {
          const start = part.vertices * Math.min(step + 1, part.frames - 1);
          for (let i = start; i < start + part.vertices; i++) {
            if (values[i] > peaks[name][step]) peaks[name][step] = values[i];
          }
        }
      }
    }
    return { ...packed, parts, peaks };
  }

  // src/three-global.js
  var {
    BufferAttribute,
    BufferGeometry,
    CustomBlending,
    DataTexture,
    DoubleSide,
    LinearFilter,
    LineSegments,
    Mesh,
    OneFactor,
    OneMinusSrcAlphaFactor,
    OrbitControls,
    PerspectiveCamera,
    Scene,
    ShaderMaterial,
    Vector2,
    Vector3,
    Vector4,
    WebGLRenderer
  } = globalThis.DolfingripThree;

  // src/overlay.js
  var ROUND = [1, 2, 5];
  var BAR = { least: 60, part: 0.13, edge: 16, tick: 5 };
  var AXES = { length: 26, edge: 44, text: 11 };
  var NAMES = ["x", "y", "z"];
  function roundLength(least) {
    const power = 10 ** Math.floor(Math.log10(least));
    return [...ROUND, 10].map((factor) => factor * power).find((length) => length >= least * 0.999);
  }
  function overlay(context, [x, y, width, height], { eye, target, axes, ink }) {
    const slope = Math.tan(eye.fov * Math.PI / 360);
    const pxPerMm = height / (2 * slope * eye.position.distanceTo(target));
    const length = roundLength(Math.min(BAR.least, BAR.part * width) / pxPerMm);
    const [left, base] = [x + BAR.edge, y + height - BAR.edge];
    const right = left + length * pxPerMm;
    Object.assign(context, {
      strokeStyle: ink,
      fillStyle: ink,
      lineWidth: 1.5,
      textBaseline: "bottom",
      textAlign: "center",
      font: "12px system-ui, sans-serif"
    });
    context.beginPath();
    context.moveTo(left, base - BAR.tick);
    context.lineTo(left, base);
    context.lineTo(right, base);
    context.lineTo(right, base - BAR.tick);
    context.stroke();
    context.fillText(`${+length.toPrecision(1)} mm`, (left + right) / 2, base - 2);
    const turned = eye.quaternion.clone().invert();
    const [atX, atY] = [left + AXES.edge - BAR.edge, base - AXES.edge - 22];
    const directions = NAMES.map((name, axis) => ({
      name,
      ahead: new Vector3().setComponent(axis, axes[axis]).applyQuaternion(turned)
    }));
    directions.sort((one, other) => one.ahead.z - other.ahead.z);
    context.textBaseline = "middle";
    for (const { name, ahead } of directions) {
      const [dx, dy] = [ahead.x, -ahead.y];
      context.globalAlpha = ahead.z < -0.2 ? 0.55 : 1;
      context.beginPath();
      context.moveTo(atX, atY);
      context.lineTo(atX + AXES.length * dx, atY + AXES.length * dy);
      context.stroke();
      const far = AXES.length + AXES.text;
      const short = Math.hypot(dx, dy) < 0.25;
      context.fillText(name, atX + (short ? AXES.text : far * dx), atY + (short ? AXES.text : far * dy));
    }
    context.globalAlpha = 1;
  }

  // src/shaders.js
  var VERTEX = `
attribute vec3 rest; attribute vec3 from; attribute vec3 to;
attribute vec3 normalFrom; attribute vec3 normalTo;
attribute float valueFrom; attribute float valueTo;
uniform vec3 uLow, uSize, uMirror; uniform float uPart;
varying vec3 vNormal, vPlace; varying float vValue, vRestY;
void main() {
  vRestY = uLow.y + uSize.y * rest.y;
  vec3 place = uMirror * (uLow + uSize * mix(from, to, uPart));
  vNormal = normalMatrix * (uMirror * mix(normalFrom, normalTo, uPart));
  vValue = mix(valueFrom, valueTo, uPart);
  vec4 seen = modelViewMatrix * vec4(place, 1.0);
  vPlace = seen.xyz;
  gl_Position = projectionMatrix * seen;
}`;
  var CUT = `if (uCut > 0.5 && vRestY < -1.0e-4) discard;`;
  var SURFACE = `
uniform sampler2D uPalette; uniform vec2 uRange; uniform vec4 uFlat; uniform float uCut;
varying vec3 vNormal, vPlace; varying float vValue, vRestY;
void main() {
  ${CUT}
  vec3 n = normalize(vNormal), v = normalize(-vPlace);
  if (dot(n, v) < 0.0) n = -n;
  float share = clamp((vValue - uRange.x) / max(uRange.y - uRange.x, 1.0e-12), 0.0, 1.0);
  vec3 colour = texture2D(uPalette, vec2((share * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  if (uFlat.a > 0.0) colour = uFlat.rgb;
  float light = 0.5 + 0.5 * dot(n, normalize(vec3(0.35, 0.75, 0.65)));
  float rim = pow(1.0 - max(dot(n, v), 0.0), 4.0);
  vec3 lit = colour * (0.62 + 0.44 * light) * (1.0 - 0.15 * rim);
  gl_FragColor = vec4(lit, uFlat.a > 0.0 ? uFlat.a : 1.0);
}`;
  var LINE = `
uniform vec4 uFlat; uniform float uCut;
varying float vRestY;
void main() { ${CUT} gl_FragColor = uFlat; }`;

  // src/strike.js
  var PARALLEL = 1e-12;
  function strike(places, triangles, [ox, oy, oz], [dx, dy, dz], cut) {
    let best = null;
    let nearest = Infinity;
    for (let i = 0; i < triangles.length; i += 3) {
      const [a, b, c] = [3 * triangles[i], 3 * triangles[i + 1], 3 * triangles[i + 2]];
      const ux = places[b] - places[a];
      const uy = places[b + 1] - places[a + 1];
      const uz = places[b + 2] - places[a + 2];
      const vx = places[c] - places[a];
      const vy = places[c + 1] - places[a + 1];
      const vz = places[c + 2] - places[a + 2];
      const px = dy * vz - dz * vy;
      const py = dz * vx - dx * vz;
      const pz = dx * vy - dy * vx;
      const determinant = ux * px + uy * py + uz * pz;
      if (Math.abs(determinant) < PARALLEL) continue;
      const [tx, ty, tz] = [ox - places[a], oy - places[a + 1], oz - places[a + 2]];
      const u = (tx * px + ty * py + tz * pz) / determinant;
      if (u < 0 || u > 1) continue;
      const qx = ty * uz - tz * uy;
      const qy = tz * ux - tx * uz;
      const qz = tx * uy - ty * ux;
      const v = (dx * qx + dy * qy + dz * qz) / determinant;
      if (v < 0 || u + v > 1) continue;
      const distance = (vx * qx + vy * qy + vz * qz) / determinant;
      if (distance <= 0 || distance >= nearest) continue;
      if (cut && restY(cut, triangles[i]) < 0) continue;
      nearest = distance;
      best = {
        distance,
        corners: [triangles[i], triangles[i + 1], triangles[i + 2]],
        shares: [1 - u - v, u, v]
      };
    }
    return best;
  }
  function restY(part, vertex) {
    const scale = (part.high[1] - part.low[1]) / 65535;
    return part.low[1] + scale * part.positions[3 * vertex + 1];
  }

  // src/pane.js
  function normals(part, frame2) {
    const { positions, triangles, vertices, low, high } = part;
    const sum = new Float32Array(3 * vertices);
    const scale = high.map((top, axis) => (top - low[axis]) / 65535);
    const start = 3 * vertices * frame2;
    const side = (from, to, axis) => (positions[start + 3 * to + axis] - positions[start + 3 * from + axis]) * scale[axis];
    for (let i = 0; i < triangles.length; i += 3) {
      const [a, b, c] = [triangles[i], triangles[i + 1], triangles[i + 2]];
      const [ux, uy, uz] = [side(a, b, 0), side(a, b, 1), side(a, b, 2)];
      const [vx, vy, vz] = [side(a, c, 0), side(a, c, 1), side(a, c, 2)];
      const normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
      for (const vertex of [a, b, c]) {
        for (let axis = 0; axis < 3; axis++) sum[3 * vertex + axis] += normal[axis];
      }
    }
    const out = new Int8Array(4 * vertices);
    for (let i = 0; i < vertices; i++) {
      const length = Math.hypot(sum[3 * i], sum[3 * i + 1], sum[3 * i + 2]) || 1;
      for (let axis = 0; axis < 3; axis++) out[4 * i + axis] = 127 * sum[3 * i + axis] / length;
    }
    return out;
  }
  var Part = class {
    constructor(part, scene) {
      this.part = part;
      const { vertices, frames } = part;
      this.positions = [];
      this.normals = [];
      this.values = {};
      for (let frame2 = 0; frame2 < frames; frame2++) {
        const padded = new Uint16Array(4 * vertices);
        for (let i = 0; i < vertices; i++) {
          const from = 3 * (vertices * frame2 + i);
          padded.set(part.positions.subarray(from, from + 3), 4 * i);
        }
        this.positions.push(new BufferAttribute(padded, 4, true));
        this.normals.push(new BufferAttribute(normals(part, frame2), 4, true));
      }
      this.none = new BufferAttribute(new Float32Array(vertices), 1);
      for (const [name, all] of Object.entries(part.values)) {
        this.values[name] = this.positions.map(
          (_, frame2) => new BufferAttribute(all.subarray(vertices * frame2, vertices * (frame2 + 1)), 1)
        );
      }
      this.uniforms = {
        uLow: { value: new Vector3(...part.low) },
        uSize: { value: new Vector3(...part.high.map((h, axis) => h - part.low[axis])) },
        uPart: { value: 0 },
        uRange: { value: new Vector2(0, 1) },
        uPalette: { value: null },
        uCut: { value: 0 }
      };
      const flat = part.colour ? [...part.colour, 1] : [0, 0, 0, 0];
      this.moving = { surface: this.#geometry(part.triangles), lines: this.#geometry(part.lines) };
      this.still = { surface: this.#geometry(part.triangles), creases: this.#geometry(part.creases) };
      for (const geometry of Object.values(this.still)) this.#bind(geometry, 0, 0);
      this.objects = [];
      for (const mirror of part.mirrored ? [1, -1] : [1]) {
        const made = {
          mirror,
          surface: new Mesh(this.moving.surface, this.#material(SURFACE, mirror, flat, 1)),
          lines: new LineSegments(this.moving.lines, this.#material(LINE, mirror, [0, 0, 0, 0.3], 0))
        };
        if (frames > 1 && !part.section) {
          const ghost = { uPart: { value: 0 } };
          made.ghost = new Mesh(
            this.still.surface,
            this.#material(SURFACE, mirror, [0.5, 0.5, 0.5, 0.13], 3, ghost)
          );
          made.ghost.material.depthWrite = false;
          made.outline = new LineSegments(
            this.still.creases,
            this.#material(LINE, mirror, [0.4, 0.4, 0.4, 0.6], 0, ghost)
          );
          made.outline.material.depthWrite = false;
          for (const { material } of [made.ghost, made.outline]) {
            material.transparent = false;
            material.blending = CustomBlending;
            material.blendSrcAlpha = OneFactor;
            material.blendDstAlpha = OneMinusSrcAlphaFactor;
          }
        }
        this.objects.push(made);
        ["ghost", "outline", "surface", "lines"].forEach((name, order) => {
          if (!made[name]) return;
          made[name].frustumCulled = false;
          made[name].renderOrder = order;
          scene.add(made[name]);
        });
      }
      this.setTime(0);
    }
    #geometry(index) {
      const geometry = new BufferGeometry();
      geometry.setIndex(new BufferAttribute(index, 1));
      return geometry;
    }
    #material(fragmentShader, mirror, flat, behind, further = {}) {
      return new ShaderMaterial({
        vertexShader: VERTEX,
        fragmentShader,
        side: DoubleSide,
        transparent: flat[3] > 0 && flat[3] < 1,
        polygonOffset: behind > 0,
        // so that lines in the surface are seen
        polygonOffsetFactor: behind,
        polygonOffsetUnits: behind,
        uniforms: {
          ...this.uniforms,
          uMirror: { value: new Vector3(1, mirror, 1) },
          uFlat: { value: new Vector4(...flat) },
          ...further
        }
      });
    }
    #bind(geometry, from, to) {
      const values = this.values[this.field];
      geometry.setAttribute("position", this.positions[from]);
      geometry.setAttribute("rest", this.positions[0]);
      geometry.setAttribute("from", this.positions[from]);
      geometry.setAttribute("to", this.positions[to]);
      geometry.setAttribute("normalFrom", this.normals[from]);
      geometry.setAttribute("normalTo", this.normals[to]);
      geometry.setAttribute("valueFrom", values ? values[from] : this.none);
      geometry.setAttribute("valueTo", values ? values[to] : this.none);
    }
    /** The two frames between which a time lies, and how far on it is. */
    frames(time) {
      const last = this.part.frames - 1;
      if (last === 0) return [0, 0, 0];
      const from = Math.min(Math.floor(time) + 1, last);
      return [from, Math.min(from + 1, last), Math.min(Math.max(time - Math.floor(time), 0), 1)];
    }
    setTime(time) {
      this.time = time;
      const [from, to, share] = this.frames(time);
      for (const geometry of Object.values(this.moving)) this.#bind(geometry, from, to);
      this.uniforms.uPart.value = share;
    }
    setField(name, range, palette) {
      this.field = name;
      this.uniforms.uRange.value.set(...range);
      this.uniforms.uPalette.value = palette;
      this.setTime(this.time);
    }
    setLayers({ ghost, lines: lines2, section }) {
      const { part } = this;
      this.uniforms.uCut.value = section && !part.mirrored && !part.section && part.cut ? 1 : 0;
      for (const made of this.objects) {
        const there = part.section ? section : !(section && made.mirror < 0);
        made.surface.visible = there;
        made.lines.visible = there && lines2 && part.lines.length > 0;
        if (made.ghost) made.ghost.visible = made.outline.visible = ghost && there;
      }
    }
    setTheme(dark) {
      const ghost = dark ? [0.78, 0.82, 0.88, 0.16] : [0.35, 0.4, 0.48, 0.13];
      for (const made of this.objects) {
        made.lines.material.uniforms.uFlat.value.set(0, 0, 0, 0.2);
        if (!made.ghost) continue;
        made.ghost.material.uniforms.uFlat.value.set(...ghost);
        made.outline.material.uniforms.uFlat.value.set(...ghost.slice(0, 3), 0.65);
      }
    }
    /** Places of all vertices at the present time, in mm. */
    places() {
      const { part, time } = this;
      if (this.known === time) return this.kept;
      const [from, to, share] = this.frames(time);
      const size = 3 * part.vertices;
      const found = new Float32Array(size);
      for (let i = 0; i < size; i++) {
        const axis = i % 3;
        const a = part.positions[size * from + i];
        const b = part.positions[size * to + i];
        const scale = (part.high[axis] - part.low[axis]) / 65535;
        found[i] = part.low[axis] + scale * (a + (b - a) * share);
      }
      [this.known, this.kept] = [time, found];
      return found;
    }
    /** Value of the field at a point of a triangle, by the shares of its corners. */
    valueAt(corners, shares) {
      const all = this.part.values[this.field];
      if (!all) return null;
      const [from, to, share] = this.frames(this.time);
      const { vertices } = this.part;
      return corners.reduce((sum, vertex, i) => {
        const [a, b] = [all[vertices * from + vertex], all[vertices * to + vertex]];
        return sum + shares[i] * (a + (b - a) * share);
      }, 0);
    }
    dispose() {
      for (const group of [this.moving, this.still]) {
        for (const geometry of Object.values(group)) geometry.dispose();
      }
      for (const made of this.objects) {
        for (const name of ["surface", "lines", "ghost", "outline"]) made[name]?.material.dispose();
      }
    }
  };
  var Pane = class {
    constructor(model) {
      this.model = model;
      this.scene = new Scene();
      this.parts = model.parts.map((part) => new Part(part, this.scene));
      this.low = [0, 1, 2].map((axis) => Math.min(...model.parts.map((p) => this.#end(p, axis, -1))));
      this.high = [0, 1, 2].map((axis) => Math.max(...model.parts.map((p) => this.#end(p, axis, 1))));
    }
    #end(part, axis, sign) {
      const own = sign < 0 ? part.low[axis] : part.high[axis];
      if (axis !== 1 || !part.mirrored) return own;
      const most = Math.max(Math.abs(part.low[1]), Math.abs(part.high[1]));
      return sign * most;
    }
    setTime(time) {
      for (const part of this.parts) part.setTime(Math.min(Math.max(time, 0), this.model.steps - 1));
    }
    setField(name, range, palette) {
      for (const part of this.parts) part.setField(name, range, palette);
    }
    setLayers(layers) {
      for (const part of this.parts) part.setLayers(layers);
    }
    setTheme(dark) {
      for (const part of this.parts) part.setTheme(dark);
    }
    /** What a ray through a point of the picture meets first: `{part, value}` or null. */
    probe(at, camera) {
      const start = camera.position;
      const ahead = new Vector3(at[0], at[1], 0.5).unproject(camera).sub(start).normalize();
      let best = null;
      for (const part of this.parts) {
        const cut = part.uniforms.uCut.value > 0.5 ? part.part : null;
        for (const made of part.objects) {
          if (!made.surface.visible) continue;
          const mirrored = ([x, y, z]) => [x, made.mirror * y, z];
          const hit = strike(
            part.places(),
            part.part.triangles,
            mirrored(start.toArray()),
            mirrored(ahead.toArray()),
            cut
          );
          if (hit && (!best || hit.distance < best.distance)) {
            best = { ...hit, part };
          }
        }
      }
      if (!best) return null;
      return { part: best.part.part.name, value: best.part.valueAt(best.corners, best.shares) };
    }
    dispose() {
      for (const part of this.parts) part.dispose();
    }
  };

  // src/viewer.js
  var TURN = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] };
  var MARGIN2 = 1.06;
  var FIELD_OF_VIEW_DEG = 26;
  var COARSE = 0.75;
  var STILL_MS = 350;
  function webgl() {
    const context = document.createElement("canvas").getContext("webgl2");
    if (!context) return { there: false, software: false };
    const info = context.getExtension("WEBGL_debug_renderer_info");
    const name = info ? context.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
    context.getExtension("WEBGL_lose_context")?.loseContext();
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
  var Viewer = class {
    /**
     * @param {HTMLElement} box which the canvas fills
     * @param {{fields: Object<string, {rgb: number[]}>, label?: string}} options colours of each field
     *     as 256 times red, green, blue; `label`: what the canvas is called for those who cannot see
     */
    constructor(box, { fields, label = "" }) {
      this.box = box;
      this.panes = [];
      this.field = "displacement";
      this.range = [0, 1];
      this.layers = { ghost: true, lines: true, section: false };
      this.dark = false;
      this.listeners = [];
      this.software = webgl().software;
      this.canvas = document.createElement("canvas");
      this.canvas.tabIndex = 0;
      this.canvas.setAttribute("role", "img");
      this.canvas.setAttribute("aria-label", label);
      this.sheet = document.createElement("canvas");
      this.sheet.className = "sheet";
      box.append(this.canvas, this.sheet);
      this.renderer = new WebGLRenderer({
        canvas: this.canvas,
        antialias: !this.software,
        alpha: true,
        powerPreference: "low-power"
      });
      this.renderer.setClearColor(0, 0);
      this.palettes = Object.fromEntries(
        Object.entries(fields).map(([name, { rgb }]) => [name, texture(rgb)])
      );
      this.eye = new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, 1, 5e3);
      this.eye.up.set(0, 0, 1);
      this.#orbits();
      this.observer = new ResizeObserver(() => this.#resize());
      this.observer.observe(box);
      this.#resize();
    }
    #orbits() {
      const { canvas } = this;
      this.controls = new OrbitControls(this.eye, canvas);
      this.controls.enableZoom = false;
      canvas.addEventListener("focus", () => this.controls.enableZoom = true);
      canvas.addEventListener("blur", () => this.controls.enableZoom = false);
      canvas.style.touchAction = "pan-y";
      this.controls.addEventListener("change", () => {
        this.draw();
        for (const listener of this.listeners) listener(this.camera);
      });
      canvas.addEventListener("keydown", (event) => {
        const turn = TURN[event.key];
        if (turn) this.turn(...turn);
        else if (event.key === "Home") this.home();
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
          const at = low.map((l, axis) => corner >> axis & 1 ? high[axis] : l);
          most = Math.max(most, Math.abs(new Vector3(...at).sub(middle).dot(direction)));
        }
        return most;
      });
      const slope = Math.tan(FIELD_OF_VIEW_DEG * Math.PI / 360);
      const far = MARGIN2 * Math.max(size[1] / slope, size[0] / (slope * this.#aspect())) + size[2] / 2;
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
        ([x2, y2, w2, h2]) => clientX - box.left >= x2 && clientX - box.left < x2 + w2 && clientY - box.top >= y2 && clientY - box.top < y2 + h2
      );
      if (found < 0) return null;
      const [x, y, w, h] = this.#tiles(box.width, box.height)[found];
      const at = [
        2 * (clientX - box.left - x) / w - 1,
        1 - 2 * (clientY - box.top - y) / h
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
      context.drawImage(this.canvas, 0, 0);
      this.#annotate(context, enlarged);
    }
    /** A PNG of the view as a data address, of so many pixels; the camera then shows everything. */
    image(width, height, { plain = false } = {}) {
      const kept = this.camera;
      const release = this.hold(width, height);
      this.home();
      const picture = Object.assign(document.createElement("canvas"), { width, height });
      const context = picture.getContext("2d");
      if (plain) this.render();
      if (plain) context.drawImage(this.canvas, 0, 0);
      else this.drawOn(context, width / 700);
      release();
      this.camera = kept;
      return picture.toDataURL("image/png");
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
      Object.assign(this.sheet, { width: width * fine, height: height * fine });
      this.#annotate(this.sheet.getContext("2d"), fine);
    }
    /** Scale bar and axes of each pane, so many times as large as on a screen. */
    #annotate(context, enlarged) {
      const extent = this.#extent().map((px) => this.size ? px / enlarged : px);
      context.save();
      context.scale(enlarged, enlarged);
      const ink = this.dark ? "#eceff3" : "#1d2126";
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
      return this.panes.map((_, i) => [i % columns * w, Math.floor(i / columns) * h, w, h]);
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
  };

  // src/front.js
  var $ = (id) => document.getElementById(id);
  var PRINT = { width: 900, height: 600 };
  var Front = class {
    constructor(spec, fields, there) {
      this.spec = spec;
      this.fields = fields;
      this.models = [];
      if (there && spec.models.length) {
        this.viewer = new Viewer($("design-view"), { fields, label: "Shape of the design" });
        this.viewer.setLayers({ ghost: false });
      } else {
        $("design-view").hidden = true;
      }
      const chart = scatterChart($("front-chart"), spec, { choose: (i) => this.#choose(i) });
      chart.select(spec.start);
    }
    setTheme(dark) {
      this.viewer?.setTheme(dark);
    }
    async #choose(index) {
      this.wanted = index;
      const { label, rows, model } = this.spec.points[index];
      $("design-name").textContent = label;
      const table = $("design-rows");
      table.replaceChildren();
      for (const [name, value] of rows) {
        const row = table.insertRow();
        row.append(element("th", { scope: "row" }, name));
        row.append(element("td", { class: "number" }, value));
      }
      const none = model === null || !this.viewer;
      $("design-view").classList.toggle("empty", none);
      $("design-printed").removeAttribute("src");
      if (none) return;
      const first = !this.models.some(Boolean);
      this.models[model] ??= await unpack(this.spec.models[model], this.fields);
      if (this.wanted !== index) return;
      this.viewer.show([this.models[model]], { keepCamera: !first });
      $("design-printed").src = this.viewer.image(PRINT.width, PRINT.height);
      document.documentElement.dataset.design = label;
    }
  };

  // src/save.js
  var $2 = (id) => document.getElementById(id);
  var VIEW_PX = { picture: 900, video: 640 };
  var SCALE = { width: 150, bar: 16, edge: 14, top: 62 };
  var TITLE_PX = 64;
  var VIDEO = { fps: 25, leastS: 4, mostS: 10, stepS: 0.5, holdS: 1, longestS: 0.1, bits: 8e6 };
  var KINDS = ["video/mp4;codecs=avc1.640028", "video/mp4;codecs=avc1.42E028", "video/webm"];
  var ending = (kind) => kind.startsWith("video/mp4") ? "mp4" : "webm";
  function lines(context, text, room) {
    const found = [""];
    for (const word of text.split(" ")) {
      const longer = found.at(-1) ? `${found.at(-1)} ${word}` : word;
      if (found.at(-1) && context.measureText(longer).width > room) found.push(word);
      else found[found.length - 1] = longer;
    }
    return found;
  }
  var Saver = class {
    constructor(stage) {
      this.stage = stage;
      this.kind = KINDS.find((kind) => globalThis.MediaRecorder?.isTypeSupported(kind));
      $2("picture").addEventListener("click", () => this.#picture());
      $2("video").addEventListener("click", () => this.recorder ? this.recorder.stop() : this.#video());
      if (!this.kind) $2("video").title = "This browser records no video";
    }
    /** A canvas for the present view, what draws on it, and what lets the screen go on. */
    #begin(height) {
      const { viewer } = this.stage;
      const box = $2("view").getBoundingClientRect();
      const enlarged = height / box.height;
      const even = (px) => 2 * Math.round(px / 2);
      const [w, h] = [even(box.width * enlarged), height];
      const canvas = document.createElement("canvas");
      canvas.width = w + even(SCALE.width * enlarged);
      canvas.height = h + even(TITLE_PX * enlarged);
      const context = canvas.getContext("2d");
      const release = viewer.hold(w, h);
      const draw = () => {
        const style = getComputedStyle(document.documentElement);
        const [back, ink] = ["--stage", "--ink"].map((name) => style.getPropertyValue(name).trim());
        context.fillStyle = back;
        context.fillRect(0, 0, canvas.width, canvas.height);
        viewer.drawOn(context, enlarged);
        context.save();
        context.scale(enlarged, enlarged);
        context.fillStyle = context.strokeStyle = ink;
        this.#words(context, box.width, box.height);
        if (this.stage.coloured) this.#scale(context, box.width, box.height);
        context.restore();
      };
      return { canvas, draw, release };
    }
    #words(context, width, height) {
      const titles = this.stage.shown.map((i) => this.stage.scenes[i].title);
      const { places } = this.stage.viewer;
      context.textBaseline = "alphabetic";
      context.textAlign = "left";
      context.font = "600 13px system-ui, sans-serif";
      const ink = context.strokeStyle;
      context.strokeStyle = getComputedStyle(document.documentElement).getPropertyValue("--stage").trim();
      context.lineWidth = 4;
      context.lineJoin = "round";
      if (titles.length > 1) {
        titles.forEach((title, i) => {
          const [x, y, share] = places[i];
          lines(context, title, share * width - 24).forEach((line, n) => {
            const at = [line, x * width + 12, y * height + 20 + 16 * n, share * width - 24];
            context.strokeText(...at);
            context.fillText(...at);
          });
        });
      }
      context.strokeStyle = ink;
      const now = $2("now").textContent;
      const first = [titles.length > 1 ? "" : titles[0], now].filter(Boolean).join(", ");
      context.font = "600 16px system-ui, sans-serif";
      const room = width + SCALE.width - 2 * SCALE.edge;
      context.fillText(first, SCALE.edge, height + 24, room);
      context.font = "13px system-ui, sans-serif";
      const second = [this.stage.note, now && $2("said").textContent].filter(Boolean).join("; ");
      context.fillText(second, SCALE.edge, height + 46, room);
    }
    #scale(context, left, height) {
      const { field, fields, range } = this.stage;
      const { label, unit, rgb } = fields[field];
      const [low, high] = range;
      const [x, top, bottom] = [left + SCALE.edge, SCALE.top, height - SCALE.edge];
      context.font = "600 12px system-ui, sans-serif";
      lines(context, `${label} (${unit})`, SCALE.width - SCALE.edge).forEach((line, n) => context.fillText(line, x, 20 + 15 * n));
      const ink = context.fillStyle;
      for (let i = 0; i < 256; i++) {
        const part = (bottom - top) / 256;
        context.fillStyle = `rgb(${rgb.slice(3 * i, 3 * i + 3).join()})`;
        context.fillRect(x, bottom - (i + 1) * part, SCALE.bar, part + 0.6);
      }
      context.fillStyle = ink;
      context.lineWidth = 1;
      context.strokeRect(x, top, SCALE.bar, bottom - top);
      context.font = "12px system-ui, sans-serif";
      context.textBaseline = "middle";
      for (const value of ticks(low, high, 5)) {
        context.fillText(formatted(value), x + SCALE.bar + 7, bottom - (value - low) / (high - low) * (bottom - top));
      }
    }
    #picture() {
      const { canvas, draw, release } = this.#begin(VIEW_PX.picture);
      draw();
      release();
      canvas.toBlob((blob) => this.#download(blob, "png"), "image/png");
    }
    /** Record the way from the first step to the last, while it is drawn. */
    #video() {
      const { stage } = this;
      const { canvas, draw, release } = this.#begin(VIEW_PX.video);
      const kept = stage.time;
      const last = stage.scenes[stage.lead].steps - 1;
      const lasts = Math.min(VIDEO.mostS, Math.max(VIDEO.leastS, last * VIDEO.stepS));
      const recorder = new MediaRecorder(canvas.captureStream(VIDEO.fps), {
        mimeType: this.kind,
        videoBitsPerSecond: VIDEO.bits
      });
      const pieces = [];
      let [done, before] = [0, performance.now()];
      this.recorder = recorder;
      recorder.addEventListener("dataavailable", ({ data: data2 }) => pieces.push(data2));
      recorder.addEventListener("stop", () => {
        this.recorder = null;
        release();
        stage.setTime(kept);
        $2("video").textContent = "Save video";
        this.#download(new Blob(pieces, { type: this.kind }), ending(this.kind));
      });
      const go = (now) => {
        if (recorder.state === "inactive") return;
        done += Math.min(VIDEO.longestS, (now - before) / 1e3);
        before = now;
        stage.setTime(last * Math.min(1, done / lasts));
        draw();
        $2("video").textContent = `Stop (${Math.min(100, Math.round(100 * done / (lasts + VIDEO.holdS)))} %)`;
        if (done > lasts + VIDEO.holdS) recorder.stop();
        else requestAnimationFrame(go);
      };
      stage.setTime(0);
      draw();
      recorder.start();
      requestAnimationFrame(go);
    }
    #download(blob, suffix) {
      const title = this.stage.scenes[this.stage.lead].title;
      const link = document.createElement("a");
      link.href = URL.createObjectURL(blob);
      link.download = `${title.replace(/[^\p{L}\p{N}]+/gu, "_").slice(0, 60)}.${suffix}`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 6e4);
    }
  };

  // src/stage.js
  var FILM = { count: 6, width: 220, height: 165 };
  var PRINT2 = { width: 1400, height: 800, afterMs: 700 };
  var STEPS_A_SECOND = 4;
  var WHOLE = 1e-6;
  var $3 = (id) => document.getElementById(id);
  var clamped = (v, low, high) => Math.max(low, Math.min(high, v));
  function valueAt({ control }, time) {
    const from = clamped(Math.floor(time), 0, control.values.length - 1);
    const to = Math.min(from + 1, control.values.length - 1);
    return control.values[from] + (control.values[to] - control.values[from]) * (time - from);
  }
  function timeOf({ control }, value) {
    const { values, monotone } = control;
    if (!monotone) return null;
    let i = 1;
    while (i < values.length - 1 && values[i] < value) i++;
    if (values.length < 2) return 0;
    const step = values[i] - values[i - 1] || 1;
    return clamped(i - 1 + (value - values[i - 1]) / step, 0, values.length - 1);
  }
  var Stage = class {
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
      this.slider = $3("time");
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
      const ended = this.time > before.steps - 1 - WHOLE;
      const loaded = before.steps > 1;
      const same = scenes[0].kind === before.kind && loaded === scenes[0].steps > 1 && scenes.length === this.scenes.length;
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
      this.viewer = new Viewer($3("view"), { fields: this.fields, label: this.scenes[0].alt });
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
        return found ?? this.time / Math.max(lead.steps - 1, 1) * (scene.steps - 1);
      });
    }
    /** Set the time of the lead, or of the scene whose curve was picked. */
    pick(scene, index) {
      if (scene === this.lead) return this.setTime(index);
      const value = valueAt(this.scenes[scene], index);
      const lead = this.scenes[this.lead];
      const same = this.scenes[scene].control.label === lead.control.label;
      const share = index / Math.max(this.scenes[scene].steps - 1, 1) * (lead.steps - 1);
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
      const step = solved ? "solved step" : "step";
      let said = `interpolated between the ${step}s at ${name(from)} and ${name(from + 1)}`;
      if (whole) said = `${step} ${at + 1} of ${steps}`;
      if (!control.label) said = "without load";
      $3("now").textContent = control.label ? joined(value, control.unit) : "";
      $3("said").textContent = branch ? `${branch}, ${said}` : said;
      this.slider.setAttribute("aria-valuetext", `${$3("now").textContent}, ${$3("said").textContent}`);
      $3("control").textContent = control.label;
    }
    #controls() {
      const { slider } = this;
      slider.max = this.scenes[this.lead].steps - 1;
      slider.addEventListener("input", () => this.setTime(+slider.value));
      slider.addEventListener("keydown", (event) => {
        const ahead = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 }[event.key];
        if (!ahead) return;
        event.preventDefault();
        const { time } = this;
        this.setTime(ahead > 0 ? Math.floor(time + WHOLE) + 1 : Math.ceil(time - WHOLE) - 1);
      });
      $3("play").addEventListener("click", () => this.#play());
      const choice = $3("field");
      for (const [name, { label }] of Object.entries(this.fields)) {
        choice.append(element("option", { value: name }, label));
      }
      choice.addEventListener("change", () => this.#setField(choice.value));
      for (const name of ["ghost", "lines", "section"]) {
        const button = $3(name);
        button.addEventListener("click", () => {
          const on = button.getAttribute("aria-pressed") !== "true";
          button.setAttribute("aria-pressed", on);
          this.viewer?.setLayers({ [name]: on });
          this.#film();
        });
      }
      $3("home").addEventListener("click", () => this.viewer?.home());
      for (const button of document.querySelectorAll("[data-scene]")) {
        const index = +button.dataset.scene;
        button.setAttribute("aria-pressed", this.shown.includes(index));
        button.addEventListener("click", () => this.#toggle(index));
      }
      this.#label();
    }
    async #toggle(index) {
      const on = this.shown.includes(index);
      const shown = on ? this.shown.filter((i) => i !== index) : [...this.shown, index].sort();
      if (!shown.length) return;
      for (const button of document.querySelectorAll("[data-scene]")) {
        button.setAttribute("aria-pressed", shown.includes(+button.dataset.scene));
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
      await Promise.all(shown.map(async (i) => this.models[i] ??= await unpack(this.scenes[i], this.fields)));
      if (shown !== this.shown) return;
      this.viewer.show(shown.map((i) => this.models[i]), { keepCamera });
      const captions = $3("captions");
      captions.replaceChildren();
      if (shown.length > 1) {
        this.viewer.places.forEach(([x, y, w], pane) => {
          const caption = element("span", {}, this.scenes[shown[pane]].title);
          Object.assign(caption.style, { left: `${100 * x}%`, top: `${100 * y}%`, width: `${100 * w}%` });
          captions.append(caption);
        });
      }
      for (const choice of $3("field").options) {
        choice.disabled = !shown.some((i) => this.models[i].peaks[choice.value]);
      }
      const cut = shown.some((i) => this.scenes[i].parts.some((part) => part.section || part.cut));
      $3("section").disabled = !cut;
      this.#setField($3("field").value);
    }
    #setField(name) {
      if (!this.viewer) return;
      const highest = Math.max(
        ...this.shown.flatMap((i) => this.models[i].peaks[name] ?? [this.fields[name].least])
      );
      this.coloured = this.scenes[this.lead].steps > 1;
      $3("video").disabled = !this.coloured || !this.saver.kind;
      $3("bar").parentElement.classList.toggle("still", !this.coloured);
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
        const at = 3 * Math.round(i * 255 / 32);
        return `rgb(${rgb[at]},${rgb[at + 1]},${rgb[at + 2]})`;
      });
      const bar = $3("bar");
      bar.replaceChildren();
      bar.style.setProperty("--colours", colours.join(","));
      $3("scale-title").textContent = `${label} (${unit})`;
      const [low, high] = this.range;
      for (const v of ticks(low, high, 5)) {
        const tick = element("i", {}, formatted(v));
        tick.style.setProperty("--at", `${100 * (v - low) / (high - low)}%`);
        bar.append(tick);
      }
      this.peak = element("u", {});
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
      this.peak.style.setProperty("--at", `${clamped(100 * (most - low) / (high - low), 0, 100)}%`);
      const text = `largest now: ${joined(formatted(most), this.fields[this.field].unit)}`;
      this.peak.title = text;
      $3("peak").textContent = text;
    }
    #probe() {
      const note = $3("probe");
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
          const value = found.value === null ? "" : `: ${joined(formatted(found.value), this.fields[this.field].unit)}`;
          note.textContent = found.part + value;
          const box = $3("view").getBoundingClientRect();
          const left = Math.min(event.clientX - box.left + 14, box.width - note.offsetWidth - 4);
          note.style.left = `${left}px`;
          note.style.top = `${event.clientY - box.top + 12}px`;
        });
      };
      canvas.addEventListener("pointermove", move);
      canvas.addEventListener("pointerdown", move);
      canvas.addEventListener("pointerleave", () => note.hidden = true);
    }
    #play() {
      this.playing = !this.playing;
      $3("play").textContent = this.playing ? "❚❚" : "▶";
      $3("play").setAttribute("aria-label", this.playing ? "Pause" : "Play");
      let ahead = 1;
      let before = performance.now();
      const go = (now) => {
        if (!this.playing) return;
        const last = this.scenes[this.lead].steps - 1;
        const time = this.time + ahead * Math.min(0.1, (now - before) / 1e3) * STEPS_A_SECOND;
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
      if (!$3("film")) return;
      clearTimeout(this.filming);
      this.filming = setTimeout(() => {
        const strip = $3("film");
        strip.replaceChildren();
        const { steps, control } = this.scenes[this.lead];
        const count = Math.min(FILM.count, steps);
        const kept = this.time;
        for (let i = 0; i < count; i++) {
          const step = Math.round(i * (steps - 1) / Math.max(count - 1, 1));
          this.time = step;
          const times = this.times();
          this.viewer.setTimes(this.shown.map((s) => times[s]));
          const name = joined(formatted(control.values[step]), control.unit);
          const frame2 = element("button", { type: "button" });
          const picture = element("img", { alt: `${control.label} ${name}` });
          picture.src = this.viewer.image(FILM.width, FILM.height, { plain: true });
          frame2.append(picture, name);
          frame2.addEventListener("click", () => this.setTime(step));
          strip.append(frame2);
        }
        this.setTime(kept);
        document.documentElement.dataset.film = count;
      }, 60);
    }
    /** The picture that is printed, some time after the last change. */
    #later() {
      if (!$3("printed")) return;
      clearTimeout(this.printing);
      this.printing = setTimeout(() => {
        $3("printed").src = this.viewer.image(PRINT2.width, PRINT2.height);
        document.documentElement.dataset.printed = this.time;
      }, PRINT2.afterMs);
    }
  };

  // src/theme.js
  var root = document.documentElement;
  var KEY = "dolfingrip-theme";
  var NEXT = { auto: "light", light: "dark", dark: "auto" };
  var SIGN = { auto: "◐ Auto", light: "☀ Light", dark: "☾ Dark" };
  function themes(views2) {
    const system = matchMedia("(prefers-color-scheme: dark)");
    const button = document.getElementById("theme");
    let choice = "auto";
    try {
      choice = localStorage.getItem(KEY) ?? "auto";
    } catch {
    }
    const apply = () => {
      const dark = choice === "dark" || choice === "auto" && system.matches;
      root.dataset.theme = dark ? "dark" : "light";
      button.textContent = SIGN[choice] ?? SIGN.auto;
      for (const view of views2) view.setTheme(dark);
    };
    button.addEventListener("click", () => {
      choice = NEXT[choice] ?? "auto";
      try {
        localStorage.setItem(KEY, choice);
      } catch {
      }
      apply();
    });
    system.addEventListener("change", apply);
    apply();
    return apply;
  }

  // src/report.js
  var root2 = document.documentElement;
  var data = JSON.parse(document.getElementById("data").textContent);
  var views = [];
  async function begin() {
    root2.classList.add("scripted");
    const apply = themes(views);
    const there = webgl().there;
    const stage = data.scenes.length ? new Stage(data.scenes, data.fields) : null;
    const charts = data.charts.map(
      (spec) => stackedChart(document.getElementById(spec.id), spec, {
        pick: (scene, index) => stage?.pick(scene, index)
      })
    );
    if (stage) {
      stage.onTime((times) => {
        const now = Object.fromEntries(times.map((time, i) => [i, time]));
        for (const chart of charts) chart.mark(now);
      });
      stage.setTime(data.scenes[stage.lead].steps - 1);
      root2.classList.toggle("webgl", there);
      if (there) {
        await stage.begin(root2.dataset.theme === "dark");
        views.push(stage);
      }
    }
    if (data.front) views.push(new Front(data.front, data.fields, there));
    apply();
    root2.dataset.ready = there ? "webgl" : "flat";
  }
  begin();
})();
