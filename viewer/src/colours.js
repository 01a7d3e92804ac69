// Colours of a surface by displacement or stress, and their scale.
// SPDX-License-Identifier: Apache-2.0
import { SurfaceStress } from './surface_stress.js';

/** What a surface may show; `unit` is that of its scale. */
export const QUANTITIES = {
  own: { title: 'its own' },
  displacement: { title: 'displacement', unit: 'm' },
  stress: { title: 'stress', unit: 'Pa' },
};

/** What the bodies of a pack may be coloured by: a stress needs the one material of each.
 * @param {import('./pack.js').Pack} pack @returns {string[]} */
export function quantitiesOf({ models }) {
  const known = models.every(({ regions, poisson }) => regions === 1 && poisson !== undefined);
  return Object.keys(QUANTITIES).filter((name) => name !== 'stress' || known);
}

/** From 0 to the top of the scale, red, green and blue as of sRGB. */
const STOPS = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];

export const GRADIENT = `linear-gradient(to right, ${STOPS.map((c) => `rgb(${c})`).join(', ')})`;

const linear = (byte) => (byte / 255 <= 0.04045 ? byte / 255 / 12.92
  : ((byte / 255 + 0.055) / 1.055) ** 2.4);

/** colourOf(share) for shaders, with the share of the scale from 0 to 1, in linear light. */
export const COLOUR_OF = /* glsl */ `
  vec3 colourOf(float share) {
    vec3 stops[${STOPS.length}] = vec3[](${STOPS.map((c) =>
    `vec3(${c.map((b) => linear(b).toFixed(5)).join(', ')})`).join(', ')});
    float at = clamp(share, 0.0, 1.0) * ${(STOPS.length - 1).toFixed(1)};
    int below = min(int(at), ${STOPS.length - 2});
    return mix(stops[below], stops[below + 1], at - float(below));
  }`;

const LEAST = 1e-9; // of Young's modulus, or of a body's size: what is smaller in all of a scene may be rounding

/** The least top of a scale for a body: a strain of a billionth, or a displacement of that share of its diagonal, so that a body
 * at rest is not coloured by rounding. @param {import('./pack.js').Model} model @param {string} quantity
 * @param {number} size diagonal of the body [m] @param {number} stiffness factor of Young's modulus @returns {number} */
export const leastTop = ({ young }, quantity, size, stiffness) => LEAST * (quantity === 'stress' ? young * stiffness : size);

/** The quantity at each split vertex of one body. */
export class SurfaceValues {
  /** @param {import('./pack.js').Model} model @param {import('./smooth.js').Smooth} shape */
  constructor(model, shape) {
    Object.assign(this, { model, shape });
    this.positions = new Float64Array(3 * model.vertex_count);
    this.values = new Float32Array(shape.source.length);
  }

  #displace(q) {
    const { rank, arrays: { basis, positions } } = this.model;
    for (let row = 0; row < positions.length; row++) {
      let sum = positions[row];
      for (let i = 0; i < rank; i++) sum += basis[row * rank + i] * q[i];
      this.positions[row] = sum;
    }
  }

  /** @param {string} quantity @param {Float32Array} q @param {number} scale of the body's lengths
   * @param {number} stiffness factor of Young's modulus @returns {number} the largest value */
  read(quantity, q, scale, stiffness) {
    this.#displace(q);
    if (quantity === 'stress') {
      this.stress ??= new SurfaceStress(this.model, this.shape);
      this.stress.read(this.positions, stiffness, this.values);
    } else {
      this.#lengths(scale);
    }
    return this.values.reduce((most, value) => Math.max(most, value), 0);
  }

  #lengths(scale) {
    const rest = this.model.arrays.positions;
    this.shape.source.forEach((vertex, n) => {
      const [x, y, z] = [0, 1, 2].map((axis) => this.positions[3 * vertex + axis] - rest[3 * vertex + axis]);
      this.values[n] = scale * Math.hypot(x, y, z);
    });
  }
}
