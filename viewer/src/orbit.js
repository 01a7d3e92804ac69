// A periodic motion of a curve that `thrum response` found: where its body is at any phase. It answers what the page asks
// of recorded motions (recording.js), and which point of the curve is shown.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';

const SECONDS = 2; // that a period is shown in
const PHASES = 24; // of a period: one is a step
const SEEN = 0.1; // of the body's size, to which the largest displacement is magnified

/** The largest displacement of a vertex [m]. @param {import('./pack.js').Model} model @param {Float32Array} q */
function largestDisplacement({ rank, arrays: { basis } }, q) {
  let most = 0;
  for (let row = 0; row < basis.length; row += 3 * rank) {
    let square = 0;
    for (let axis = 0; axis < 3; axis++) {
      let u = 0;
      for (let i = 0; i < rank; i++) u += basis[row + axis * rank + i] * q[i];
      square += u * u;
    }
    most = Math.max(most, square);
  }
  return Math.sqrt(most);
}

export class Orbit {
  /** @param {object} curve of the pack @param {import('./pack.js').Pack} pack */
  constructor(curve, pack) {
    const [body] = pack.scene.bodies;
    Object.assign(this, { curve, body, title: 'the curve', time: 0, begin: 0, end: 1, model: pack.models[body.model] });
    this.count = curve.arrays.frequency.length;
    this.shown = new Float32Array(this.model.rank);
    const { peak } = curve.arrays;
    this.choose(peak.indexOf(peak.reduce((most, value) => Math.max(most, value))));
  }

  /** Shows a motion of the curve. @param {number} row from 0; beyond the ends the nearest */
  choose(row) {
    this.row = Math.min(this.count - 1, Math.max(0, Math.round(row)));
  }

  /** Goes along the curve. @param {number} rows */
  move(rows) {
    this.choose(this.row + rows);
  }

  get slider() {
    return { min: 1, max: this.count, step: 1, value: this.row + 1 };
  }

  slide(value) {
    this.choose(value - 1);
  }

  /** Goes to a phase, in periods. @param {number} time */
  seek(time) {
    this.time = time - Math.floor(time);
  }

  /** A little on in the period. */
  tick() {
    this.seek(this.time + 1 / PHASES);
  }

  /** Goes on as real time does. @param {number} elapsed [s] @returns {boolean} true: it has no end */
  advance(elapsed) {
    this.seek(this.time + elapsed / SECONDS);
    return true;
  }

  /** q of the model's full rank. @returns {Float32Array} valid until the next call */
  shape() {
    const { rank } = this.model;
    const { harmonics, arrays: { motion } } = this.curve;
    const from = this.row * (2 * harmonics + 1) * rank;
    for (let i = 0; i < rank; i++) this.shown[i] = motion[from + i];
    for (let k = 1; k <= harmonics; k++) {
      const [cosine, sine] = [Math.cos(2 * Math.PI * k * this.time), Math.sin(2 * Math.PI * k * this.time)];
      for (let i = 0; i < rank; i++)
        this.shown[i] += cosine * motion[from + k * rank + i] + sine * motion[from + (harmonics + k) * rank + i];
    }
    return this.shown;
  }

  matrix() {
    const { position, rotation: [w, x, y, z], scale } = this.body;
    return new THREE.Matrix4().compose(new THREE.Vector3(...position), new THREE.Quaternion(x, y, z, w),
      new THREE.Vector3(scale, scale, scale)).elements;
  }

  links() {
    return [];
  }

  /** By how much displacements are drawn larger, so that the largest of the curve is seen. @param {number} size of the body [m] */
  magnification(size) {
    const { row, time } = this;
    const { peak } = this.curve.arrays;
    this.choose(peak.indexOf(peak.reduce((most, value) => Math.max(most, value))));
    let largest = 0;
    for (let n = 0; n < PHASES; n++) {
      this.seek(n / PHASES);
      largest = Math.max(largest, largestDisplacement(this.model, this.shape()));
    }
    Object.assign(this, { row, time });
    return largest > 0 ? Math.max(1, (SEEN * size) / largest) : 1;
  }
}
