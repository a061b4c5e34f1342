// What is drawn over the 3D view: a scale bar and the model's axes, on the screen and in pictures.

import { Vector3 } from './three-global.js';

const ROUND = [1, 2, 5];
const BAR = { least: 60, part: 0.13, edge: 16, tick: 5 }; // px
const AXES = { length: 26, edge: 44, text: 11 }; // px
const NAMES = ['x', 'y', 'z'];

/** The shortest round length that is not below this one, in mm. */
function roundLength(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return [...ROUND, 10].map((factor) => factor * power).find((length) => length >= least * 0.999);
}

/**
 * Draw a scale bar, which holds at the distance of what the eye looks at, and the axes.
 *
 * @param {CanvasRenderingContext2D} context
 * @param {number[]} tile x, y, width, height of a pane in px
 * @param {{eye: object, target: Vector3, axes: number[], ink: string}} seen camera, the place that it
 *     looks at, the directions of the model's axes in the scene (1 or -1 each), colour of the lines
 */
export function overlay(context, [x, y, width, height], { eye, target, axes, ink }) {
  const slope = Math.tan((eye.fov * Math.PI) / 360);
  const pxPerMm = height / (2 * slope * eye.position.distanceTo(target));
  const length = roundLength(Math.min(BAR.least, BAR.part * width) / pxPerMm);
  const [left, base] = [x + BAR.edge, y + height - BAR.edge];
  const right = left + length * pxPerMm;
  Object.assign(context, {
    strokeStyle: ink, fillStyle: ink, lineWidth: 1.5, textBaseline: 'bottom', textAlign: 'center',
    font: '12px system-ui, sans-serif',
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
    name, ahead: new Vector3().setComponent(axis, axes[axis]).applyQuaternion(turned),
  }));
  directions.sort((one, other) => one.ahead.z - other.ahead.z); // what is nearer comes later
  context.textBaseline = 'middle';
  for (const { name, ahead } of directions) {
    const [dx, dy] = [ahead.x, -ahead.y];
    context.globalAlpha = ahead.z < -0.2 ? 0.55 : 1;
    context.beginPath();
    context.moveTo(atX, atY);
    context.lineTo(atX + AXES.length * dx, atY + AXES.length * dy);
    context.stroke();
    const far = AXES.length + AXES.text;
    const short = Math.hypot(dx, dy) < 0.25; // it points at the reader: the letter stands beside
    context.fillText(name, atX + (short ? AXES.text : far * dx), atY + (short ? AXES.text : far * dy));
  }
  context.globalAlpha = 1;
}
