// Unpacks models that dolfingrip/report/page/scene.py packed. Both files say the same format.

const bytesOf = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));

async function inflated(text) {
  const stream = new Blob([bytesOf(text)]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/**
 * Numbers of 16 or 32 bits from byte planes, with differences along each row and between rows.
 *
 * @param {{data: string, bytes: number, rows: number, columns: number, stride: number}} packed
 * @returns {Promise<Uint16Array|Uint32Array>} of `rows` rows one after another
 */
export async function unpackNumbers(packed) {
  const { bytes, rows, columns, stride } = packed;
  const raw = await inflated(packed.data);
  const count = rows * columns;
  const out = bytes === 2 ? new Uint16Array(count) : new Uint32Array(count);
  for (let plane = 0; plane < bytes; plane++) {
    for (let i = 0; i < count; i++) out[i] |= raw[plane * count + i] << (8 * plane);
  }
  for (let row = 0; row < rows; row++) {
    const start = row * columns;
    for (let i = stride; i < columns; i++) out[start + i] += out[start + i - stride];
  }
  for (let i = columns; i < count; i++) out[i] += out[i - columns];
  return out;
}

/** Distances of all vertices of each frame from their places in frame 0, in mm. */
function displacements(part) {
  const { positions, vertices, frames, low, high } = part;
  const scale = high.map((top, axis) => (top - low[axis]) / 65535);
  const found = new Float32Array(vertices * frames);
  for (let frame = 1; frame < frames; frame++) {
    for (let i = 0; i < vertices; i++) {
      let sum = 0;
      for (let axis = 0; axis < 3; axis++) {
        const at = 3 * i + axis;
        const moved = positions[3 * vertices * frame + at] - positions[at];
        sum += (scale[axis] * moved) ** 2;
      }
      found[vertices * frame + i] = Math.sqrt(sum);
    }
  }
  return found;
}

async function unpackPart(part, ends, fields) {
  const names = Object.keys(part.fields);
  const [triangles, lines, creases, positions, ...told] = await Promise.all([
    unpackNumbers(part.triangles),
    unpackNumbers(part.lines),
    unpackNumbers(part.creases),
    unpackNumbers(part.positions),
    ...names.map((name) => unpackNumbers(part.fields[name])),
  ]);
  const found = { ...part, triangles, lines, creases, positions, values: {} };
  if (part.colour !== null) return found;
  names.forEach((name, at) => {
    const [low, high] = ends[name];
    const all = new Float32Array(part.vertices * part.frames).fill(fields[name].least);
    told[at].forEach((v, i) => (all[part.vertices + i] = low + ((high - low) * v) / 65535));
    found.values[name] = all;
  });
  found.values.displacement ??= displacements(found);
  return found;
}

/**
 * A model that is ready to be shown.
 *
 * Frame 0 of each part is the unloaded shape; frame k + 1 is step k.
 *
 * @param {object} packed as `scene.py` writes it
 * @param {Object<string, {least: number}>} fields value of each field in the unloaded shape
 * @returns {Promise<object>} `parts`, and the largest value of each field at each step in `peaks`
 */
export async function unpack(packed, fields) {
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
