// A model with a finer surface: each triangle in four, basis rows of the midpoints interpolated.
// The body is the same, its picture has more vertices.
// SPDX-License-Identifier: Apache-2.0

/** Every edge's midpoint as a new vertex; the mean of rows of `width` numbers at its ends.
 * @param {Float32Array} rows @param {number} width @param {[number, number][]} edges */
function withMidpoints(rows, width, edges) {
  const all = new Float32Array(rows.length + width * edges.length);
  all.set(rows);
  edges.forEach(([a, b], n) => {
    for (let i = 0; i < width; i++)
      all[rows.length + n * width + i] = (rows[a * width + i] + rows[b * width + i]) / 2;
  });
  return all;
}

/** @param {import('../src/pack.js').Model} model @returns {import('../src/pack.js').Model} */
export function subdivide(model) {
  const { positions, basis, triangles, fixed } = model.arrays;
  const edges = [];
  const seen = new Map();
  const midpoint = (a, b) => {
    const key = Math.min(a, b) * model.vertex_count + Math.max(a, b);
    if (!seen.has(key)) {
      seen.set(key, model.vertex_count + edges.length);
      edges.push([a, b]);
    }
    return seen.get(key);
  };
  const finer = [];
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = triangles.subarray(t, t + 3);
    const [ab, bc, ca] = [midpoint(a, b), midpoint(b, c), midpoint(c, a)];
    finer.push(a, ab, ca, ab, b, bc, ca, bc, c, ab, bc, ca);
  }
  return {
    ...model,
    vertex_count: model.vertex_count + edges.length,
    triangle_count: finer.length / 3,
    arrays: {
      ...model.arrays,
      positions: withMidpoints(positions, 3, edges),
      basis: withMidpoints(basis, 3 * model.rank, edges),
      triangles: new Int32Array(finer),
      fixed: new Uint8Array([...fixed, ...edges.map(([a, b]) => fixed[a] & fixed[b])]),
    },
  };
}
