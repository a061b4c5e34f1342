// Numbers as people read them, ticks of axes, and elements of the page.

const MINUS = '−';

/** A number with as many digits as a reader needs: three or four. */
export function formatted(value) {
  if (value === null || !Number.isFinite(value)) return '–';
  const size = Math.abs(value);
  let text = '0';
  if (size >= 1e5 || (size > 0 && size < 1e-3)) text = size.toExponential(1);
  else if (size >= 100) text = size.toFixed(0);
  else if (size >= 10) text = String(+size.toFixed(1));
  else if (size >= 1) text = String(+size.toFixed(2));
  else if (size > 0) text = String(+size.toPrecision(3));
  return (value < 0 && +text !== 0 ? MINUS : '') + text;
}

/** A number with its unit; a degree sign follows it at once. */
export function joined(number, unit) {
  if (!unit || unit === '–') return number;
  return unit === '°' ? number + unit : `${number} ${unit}`;
}

/** Round numbers between two ends, about so many. */
export function ticks(low, high, count) {
  const least = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(least));
  const step = [1, 2, 2.5, 5, 10].map((factor) => factor * power).find((s) => s >= least * 0.999);
  const found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-6 * step; i++) {
    found.push(i === 0 ? 0 : i * step);
  }
  return found;
}

/** An element of the page; text is never read as markup. */
export function element(name, attributes = {}, text = null) {
  const made = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== null) made.textContent = text;
  return made;
}
