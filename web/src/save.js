// "Save picture" and "Save video": the 3D view with its title, load and colour scale, as a file.

import { formatted, ticks } from './format.js';

const $ = (id) => document.getElementById(id);
const VIEW_PX = { picture: 900, video: 640 }; // height of the view in the file
const SCALE = { width: 150, bar: 16, edge: 14, top: 62 }; // px, as on the screen
const TITLE_PX = 64;
const VIDEO = { fps: 25, leastS: 4, mostS: 10, stepS: 0.5, holdS: 1, longestS: 0.1, bits: 8e6 };
// what players want first: MP4 with H.264 alone, as none plays VP9 in it
const KINDS = ['video/mp4;codecs=avc1.640028', 'video/mp4;codecs=avc1.42E028', 'video/webm'];
const ending = (kind) => (kind.startsWith('video/mp4') ? 'mp4' : 'webm');

/** A text in lines that fit into a room. */
function lines(context, text, room) {
  const found = [''];
  for (const word of text.split(' ')) {
    const longer = found.at(-1) ? `${found.at(-1)} ${word}` : word;
    if (found.at(-1) && context.measureText(longer).width > room) found.push(word);
    else found[found.length - 1] = longer;
  }
  return found;
}

export class Saver {
  constructor(stage) {
    this.stage = stage;
    this.kind = KINDS.find((kind) => globalThis.MediaRecorder?.isTypeSupported(kind));
    $('picture').addEventListener('click', () => this.#picture());
    $('video').addEventListener('click', () => (this.recorder ? this.recorder.stop() : this.#video()));
    if (!this.kind) $('video').title = 'This browser records no video';
  }

  /** A canvas for the present view, what draws on it, and what lets the screen go on. */
  #begin(height) {
    const { viewer } = this.stage;
    const box = $('view').getBoundingClientRect();
    const enlarged = height / box.height;
    const even = (px) => 2 * Math.round(px / 2); // as codecs want it
    const [w, h] = [even(box.width * enlarged), height];
    const canvas = document.createElement('canvas');
    canvas.width = w + even(SCALE.width * enlarged);
    canvas.height = h + even(TITLE_PX * enlarged);
    const context = canvas.getContext('2d');
    const release = viewer.hold(w, h);
    const draw = () => {
      const style = getComputedStyle(document.documentElement);
      const [back, ink] = ['--stage', '--ink'].map((name) => style.getPropertyValue(name).trim());
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
    context.textBaseline = 'alphabetic';
    context.textAlign = 'left';
    context.font = '600 13px system-ui, sans-serif';
    const ink = context.strokeStyle;
    context.strokeStyle = getComputedStyle(document.documentElement).getPropertyValue('--stage').trim();
    context.lineWidth = 4;
    context.lineJoin = 'round';
    if (titles.length > 1) {
      titles.forEach((title, i) => {
        const [x, y, share] = places[i];
        lines(context, title, share * width - 24).forEach((line, n) => {
          const at = [line, x * width + 12, y * height + 20 + 16 * n, share * width - 24];
          context.strokeText(...at); // a title of two lines may lie over the finger
          context.fillText(...at);
        });
      });
    }
    context.strokeStyle = ink;
    const now = $('now').textContent;
    const first = [titles.length > 1 ? '' : titles[0], now].filter(Boolean).join(', ');
    context.font = '600 16px system-ui, sans-serif';
    const room = width + SCALE.width - 2 * SCALE.edge;
    context.fillText(first, SCALE.edge, height + 24, room);
    context.font = '13px system-ui, sans-serif';
    const second = [this.stage.note, now && $('said').textContent].filter(Boolean).join('; ');
    context.fillText(second, SCALE.edge, height + 46, room);
  }

  #scale(context, left, height) {
    const { field, fields, range } = this.stage;
    const { label, unit, rgb } = fields[field];
    const [low, high] = range;
    const [x, top, bottom] = [left + SCALE.edge, SCALE.top, height - SCALE.edge];
    context.font = '600 12px system-ui, sans-serif';
    lines(context, `${label} (${unit})`, SCALE.width - SCALE.edge)
      .forEach((line, n) => context.fillText(line, x, 20 + 15 * n));
    const ink = context.fillStyle;
    for (let i = 0; i < 256; i++) {
      const part = (bottom - top) / 256;
      context.fillStyle = `rgb(${rgb.slice(3 * i, 3 * i + 3).join()})`;
      context.fillRect(x, bottom - (i + 1) * part, SCALE.bar, part + 0.6);
    }
    context.fillStyle = ink;
    context.lineWidth = 1;
    context.strokeRect(x, top, SCALE.bar, bottom - top);
    context.font = '12px system-ui, sans-serif';
    context.textBaseline = 'middle';
    for (const value of ticks(low, high, 5)) {
      context.fillText(formatted(value), x + SCALE.bar + 7, bottom - ((value - low) / (high - low)) * (bottom - top));
    }
  }

  #picture() {
    const { canvas, draw, release } = this.#begin(VIEW_PX.picture);
    draw();
    release();
    canvas.toBlob((blob) => this.#download(blob, 'png'), 'image/png');
  }

  /** Record the way from the first step to the last, while it is drawn. */
  #video() {
    const { stage } = this;
    const { canvas, draw, release } = this.#begin(VIEW_PX.video);
    const kept = stage.time;
    const last = stage.scenes[stage.lead].steps - 1;
    const lasts = Math.min(VIDEO.mostS, Math.max(VIDEO.leastS, last * VIDEO.stepS));
    const recorder = new MediaRecorder(canvas.captureStream(VIDEO.fps), {
      mimeType: this.kind, videoBitsPerSecond: VIDEO.bits,
    });
    const pieces = [];
    let [done, before] = [0, performance.now()];
    this.recorder = recorder;
    recorder.addEventListener('dataavailable', ({ data }) => pieces.push(data));
    recorder.addEventListener('stop', () => {
      this.recorder = null;
      release();
      stage.setTime(kept);
      $('video').textContent = 'Save video';
      this.#download(new Blob(pieces, { type: this.kind }), ending(this.kind));
    });
    const go = (now) => {
      if (recorder.state === 'inactive') return;
      // where drawing is slow the video lasts longer: no part of the way is jumped over
      done += Math.min(VIDEO.longestS, (now - before) / 1000);
      before = now;
      stage.setTime(last * Math.min(1, done / lasts));
      draw();
      $('video').textContent = `Stop (${Math.min(100, Math.round((100 * done) / (lasts + VIDEO.holdS)))} %)`;
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
    const link = document.createElement('a');
    link.href = URL.createObjectURL(blob);
    link.download = `${title.replace(/[^\p{L}\p{N}]+/gu, '_').slice(0, 60)}.${suffix}`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
  }
}
