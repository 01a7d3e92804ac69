// Normals of a surface that bends: vertices are split where the surface has an edge, and the normal
// of each follows the modes, n(q) = N + sum_i dN_i q_i, the linearisation of the normals of its
// triangles weighted by area: exact for a turn about an axis in the surface.
// SPDX-License-Identifier: Apache-2.0

const CREASE = Math.cos((40 * Math.PI) / 180); // a sharper angle between triangles is an edge

/** @typedef {object} Smooth
 * @property {Int32Array} source the vertex of the model that each split vertex is
 * @property {Uint32Array} index of split vertices, three of a triangle
 * @property {Float32Array} normals at rest, of unit length
 * @property {Float32Array} normalModes dN over |N|, three for each split vertex and mode */

/** @param {import('./pack.js').Model} model @returns {Smooth} */
export function smooth(model) {
  const { positions, triangles, basis } = model.arrays;
  const rest = areas(positions, triangles);
  const { source, index } = split(triangles, rest);
  const normals = new Float32Array(3 * source.length);
  scatter(index, normals, 3, 0, rest);
  const normalModes = new Float32Array(3 * source.length * model.rank);
  const change = new Float32Array(triangles.length);
  for (let mode = 0; mode < model.rank; mode++) {
    changes(positions, triangles, basis, model.rank, mode, change);
    scatter(index, normalModes, 3 * model.rank, 3 * mode, change);
  }
  normalise(normals, normalModes, model.rank);
  return { source, index, normals, normalModes };
}

/** Adds a x b, sides of a triangle, to three numbers of `out`. */
function addCross(out, at, a, b) {
  out[at] += a[1] * b[2] - a[2] * b[1];
  out[at + 1] += a[2] * b[0] - a[0] * b[2];
  out[at + 2] += a[0] * b[1] - a[1] * b[0];
}

/** Twice the area vector of each triangle. */
function areas(positions, triangles) {
  const out = new Float32Array(triangles.length);
  const side = (from, to) =>
    [0, 1, 2].map((axis) => positions[3 * to + axis] - positions[3 * from + axis]);
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = triangles.subarray(t, t + 3);
    addCross(out, t, side(a, b), side(a, c));
  }
  return out;
}

/** How these change with one mode, to first order. */
function changes(positions, triangles, basis, rank, mode, out) {
  const [e1, e2, d1, d2] = [0, 0, 0, 0].map(() => new Float64Array(3));
  out.fill(0);
  for (let t = 0; t < triangles.length; t += 3) {
    const a = 3 * triangles[t];
    const b = 3 * triangles[t + 1];
    const c = 3 * triangles[t + 2];
    for (let axis = 0; axis < 3; axis++) {
      e1[axis] = positions[b + axis] - positions[a + axis];
      e2[axis] = positions[c + axis] - positions[a + axis];
      const still = basis[(a + axis) * rank + mode];
      d1[axis] = basis[(b + axis) * rank + mode] - still;
      d2[axis] = basis[(c + axis) * rank + mode] - still;
    }
    addCross(out, t, d1, e2);
    addCross(out, t, e1, d2);
  }
}

/** Adds the vector of each triangle to its three corners. */
function scatter(index, out, stride, offset, vectors) {
  for (let corner = 0; corner < index.length; corner++) {
    const at = stride * index[corner] + offset;
    const from = corner - (corner % 3);
    for (let axis = 0; axis < 3; axis++) out[at + axis] += vectors[from + axis];
  }
}

function normalise(normals, normalModes, rank) {
  for (let v = 0; v < normals.length / 3; v++) {
    const length = Math.hypot(normals[3 * v], normals[3 * v + 1], normals[3 * v + 2]) || 1;
    for (let i = 0; i < 3; i++) normals[3 * v + i] /= length;
    for (let i = 0; i < 3 * rank; i++) normalModes[3 * rank * v + i] /= length;
  }
}

/** Joins corners of triangles that meet at a vertex without a crease between them. */
function split(triangles, areaVectors) {
  const parent = Int32Array.from(triangles, (_, corner) => corner);
  const root = (corner) => {
    while (parent[corner] !== corner) corner = parent[corner] = parent[parent[corner]];
    return corner;
  };
  for (const [corners, others] of sharedEdges(triangles)) {
    if (!isFlat(areaVectors, corners[0], others[0])) continue;
    // the neighbour has the edge the other way round
    parent[root(corners[0])] = root(others[1]);
    parent[root(corners[1])] = root(others[0]);
  }
  const number = new Map();
  const source = [];
  const index = Uint32Array.from(triangles, (vertex, corner) => {
    const group = root(corner);
    if (!number.has(group)) number.set(group, source.push(vertex) - 1);
    return number.get(group);
  });
  return { source: Int32Array.from(source), index };
}

/** Pairs of triangles with a common edge, as the corners at its two ends in each. */
function* sharedEdges(triangles) {
  const open = new Map();
  const key = (from, to) => from * 2 ** 26 + to;
  for (let corner = 0; corner < triangles.length; corner++) {
    const next = corner % 3 === 2 ? corner - 2 : corner + 1;
    const other = open.get(key(triangles[next], triangles[corner]));
    if (other) yield [[corner, next], other];
    open.set(key(triangles[corner], triangles[next]), [corner, next]);
  }
}

function isFlat(areaVectors, corner, other) {
  const a = areaVectors.subarray(corner - (corner % 3), corner - (corner % 3) + 3);
  const b = areaVectors.subarray(other - (other % 3), other - (other % 3) + 3);
  const dot = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  return dot > CREASE * Math.hypot(...a) * Math.hypot(...b);
}
