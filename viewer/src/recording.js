// The recorded motion of a finished run: where its bodies are at any moment between its first row
// and its last. It answers what the page asks the engine of bodies that are stepped.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';
import { LINK_NUMBERS } from './pack.js';

const PLACE = 7; // numbers of a place: position, rotation w, x, y, z

/** The last row at or before a time, and how far it is to the next one, 0 to 1.
 * @param {Float64Array} times ascending @param {number} time */
function rowAt(times, time) {
  let low = 0;
  let high = times.length - 1;
  while (low < high) {
    const middle = Math.ceil((low + high) / 2);
    if (times[middle] <= time) low = middle;
    else high = middle - 1;
  }
  const next = Math.min(low + 1, times.length - 1);
  const length = times[next] - times[low];
  return { row: low, next, share: length > 0 ? Math.min(1, Math.max(0, (time - times[low]) / length)) : 0 };
}

export class Recording {
  /** @param {object[]} rows of each body, from the pack @param {import('./pack.js').Pack} pack */
  constructor(rows, pack) {
    this.rows = rows;
    this.title = 'the run';
    this.scene = pack.scene;
    this.recordedLinks = pack.recordedLinks;
    this.times = rows[0].arrays.times;
    this.shapes = pack.scene.bodies.map(({ model }) => new Float32Array(pack.models[model].rank));
    this.seek(this.begin);
  }

  get begin() {
    return this.times[0];
  }

  get end() {
    return this.times.at(-1);
  }

  /** Moves to a time, or to the nearest end. @param {number} time [s] */
  seek(time) {
    this.time = Math.min(this.end, Math.max(this.begin, time));
    return this.time;
  }

  /** Moves by whole rows, from the row that is shown. @param {number} count */
  move(count) {
    const { row, share } = rowAt(this.times, this.time);
    const from = count < 0 && share > 0 ? row + 1 : row;
    const last = this.times.length - 1;
    return this.seek(this.times[Math.min(last, Math.max(0, from + count))]);
  }

  get slider() {
    return { min: this.begin, max: this.end, step: 'any', value: this.time };
  }

  slide(value) {
    this.seek(value);
  }

  /** The next row. */
  tick() {
    this.move(1);
  }

  /** Goes on as real time does. @param {number} elapsed [s] @returns {boolean} false: it is at its end */
  advance(elapsed) {
    return this.seek(this.time + elapsed) < this.end;
  }

  /** A row of an array and the next one, mixed. */
  #mixed(body, name, width, out) {
    const { arrays } = this.rows[body];
    const { row, next, share } = rowAt(arrays.times, this.time);
    for (let i = 0; i < width; i++)
      out[i] = (1 - share) * arrays[name][row * width + i] + share * arrays[name][next * width + i];
    return out;
  }

  /** q of the model's full rank. @returns {Float32Array} valid until the next call */
  shape(body) {
    return this.#mixed(body, 'q', this.rows[body].rank, this.shapes[body]);
  }

  /** Column-major 4 x 4 into the world. */
  matrix(body) {
    const { position, rotation, scale } = this.scene.bodies[body];
    const moves = this.rows[body].arrays.places !== undefined;
    const place = moves ? this.#mixed(body, 'places', PLACE, new Array(PLACE)) : [...position, ...rotation];
    const [w, x, y, z] = place.slice(3);
    return new THREE.Matrix4().compose(new THREE.Vector3(...place),
      new THREE.Quaternion(x, y, z, w).normalize(), new THREE.Vector3(scale, scale, scale)).elements;
  }

  /** The links as they were in the row at or before now, and between rows where their places went.
   * @returns {{kind: string, name?: string, holds: boolean, drift: number, largestDrift: number, places: number[]}[]} */
  links() {
    const { links = [], arrays } = this.recordedLinks ?? {};
    const { row, next, share } = rowAt(this.times, this.time);
    return links.map((link, n) => {
      const first = (which) => LINK_NUMBERS * (which * links.length + n);
      const at = (which) => arrays.links.subarray(first(which), first(which) + LINK_NUMBERS);
      const [holds, drift, ...from] = at(row);
      const to = at(next).subarray(2);
      const places = from.map((x, i) => (1 - share) * x + share * to[i]);
      return { ...link, holds: holds > 0, drift, largestDrift: drift, places };
    });
  }

  /** Of the body by itself; the run's rows have no energy of gravity. */
  energies(body) {
    const [kinetic, potential] = this.#mixed(body, 'energies', 2, [0, 0]);
    return { kinetic, potential, gravity: 0, total: kinetic + potential };
  }

  /** Where an obstacle of the scene is by its path or its velocity; null: where it began.
   * @param {object} obstacle of the pack @returns {number[]|null} 4 x 4 by columns */
  obstacleMatrix({ centre, rotation = [1, 0, 0, 0], velocity = [0, 0, 0], times = [], places }) {
    const turned = ([w, x, y, z]) => new THREE.Quaternion(x, y, z, w).normalize();
    let at = new THREE.Vector3(...centre).addScaledVector(new THREE.Vector3(...velocity), this.time);
    let turn = turned(rotation);
    if (times.length > 0) {
      const { row, next, share } = rowAt(times, this.time);
      const place = (n) => places.slice(PLACE * n, PLACE * (n + 1));
      at = new THREE.Vector3(...place(row)).lerp(new THREE.Vector3(...place(next)), share);
      turn = turned(place(row).slice(3)).slerp(turned(place(next).slice(3)), share);
    }
    return new THREE.Matrix4().compose(at, turn, new THREE.Vector3(1, 1, 1)).elements;
  }
}
