// Stress at the surface of a body that nothing presses on there. The triangles of the surface give
// the strain in its plane; across it the stress is zero, as on any free surface, which leaves one
// plane stress state. Where the surface is held or touched this is not so.
// SPDX-License-Identifier: Apache-2.0

export class SurfaceStress {
  /** @param {import('./pack.js').Model} model @param {import('./smooth.js').Smooth} shape */
  constructor(model, { source, index }) {
    Object.assign(this, { index, source, young: model.young, poisson: model.poisson });
    const { positions } = model.arrays;
    const count = index.length / 3;
    this.area = new Float64Array(count);
    this.inverse = new Float64Array(4 * count); // of the sides at rest, in axes of each triangle
    this.weights = new Float64Array(source.length);
    for (let t = 0; t < count; t++) this.#rest(positions, t);
  }

  /** Where a side of triangle `t` goes. */
  #side(positions, t, corner) {
    const from = 3 * this.source[this.index[3 * t]];
    const to = 3 * this.source[this.index[3 * t + corner]];
    return [0, 1, 2].map((axis) => positions[to + axis] - positions[from + axis]);
  }

  #rest(positions, t) {
    const a = this.#side(positions, t, 1);
    const b = this.#side(positions, t, 2);
    const length = Math.hypot(...a);
    const along = dot(a, b) / length;
    const height = Math.sqrt(Math.max(0, dot(b, b) - along * along));
    this.area[t] = 0.5 * length * height;

    // the inverse of [length, along; 0, height]
    if (this.area[t] > 0)
      this.inverse.set([1 / length, -along / (length * height), 0, 1 / height], 4 * t);
    for (let corner = 0; corner < 3; corner++)
      this.weights[this.index[3 * t + corner]] += this.area[t];
  }

  /** Von Mises' equivalent of the Cauchy stress, of Saint Venant-Kirchhoff material, at each split
   * vertex: the mean of its triangles by area. @param {Float64Array} positions displaced
   * @param {number} stiffness factor of Young's modulus @param {Float32Array} out [Pa] */
  read(positions, stiffness, out) {
    out.fill(0);
    for (let t = 0; t < this.area.length; t++) {
      if (!(this.area[t] > 0)) continue;
      const stress = this.#ofTriangle(positions, t) * stiffness * this.area[t];
      for (let corner = 0; corner < 3; corner++) out[this.index[3 * t + corner]] += stress;
    }
    for (let v = 0; v < out.length; v++) out[v] /= this.weights[v] || 1;
  }

  #ofTriangle(positions, t) {
    const a = this.#side(positions, t, 1);
    const b = this.#side(positions, t, 2);
    const [p, q, , s] = this.inverse.subarray(4 * t, 4 * t + 4);

    // columns of F in the plane, C = F^T F, E = (C - 1) / 2
    const f = a.map((x) => p * x);
    const g = b.map((x, axis) => q * a[axis] + s * x);
    const [c11, c12, c22] = [dot(f, f), dot(f, g), dot(g, g)];
    const [e11, e12, e22] = [(c11 - 1) / 2, c12 / 2, (c22 - 1) / 2];

    // S = Y / (1 - nu^2) ((1 - nu) E + nu tr(E) 1), and the stretch across that leaves S_33 = 0
    const { poisson: nu, young } = this;
    const factor = young / (1 - nu * nu);
    const trace = nu * (e11 + e22);
    const s11 = factor * ((1 - nu) * e11 + trace);
    const s22 = factor * ((1 - nu) * e22 + trace);
    const s12 = factor * (1 - nu) * e12;
    const across = 1 - (2 * trace) / (1 - nu);
    const j = Math.sqrt(Math.max(1e-12, (c11 * c22 - c12 * c12) * across));

    // the invariants of sigma = F S F^T / J are those of S C / J
    const m11 = s11 * c11 + s12 * c12;
    const m12 = s11 * c12 + s12 * c22;
    const m21 = s12 * c11 + s22 * c12;
    const m22 = s12 * c12 + s22 * c22;
    const first = m11 + m22;
    const second = m11 * m11 + 2 * m12 * m21 + m22 * m22;
    return Math.sqrt(Math.max(0, (3 * second - first * first) / 2)) / j;
  }
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
