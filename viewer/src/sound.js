// The sound of a struck body by its whole model, stepped once a sample: the velocity of the struck
// place along the strike. The model is that of the page at scale 1, whose time is stretched so that
// its lowest mode sounds as that of the body does; the strike is so hard that it bends audibly.
// SPDX-License-Identifier: Apache-2.0
import { fewestStepped } from './pack.js';
import { FADE, LOUDNESS, SECONDS, haste } from './strike.js';

export const STRENGTH = 0.02; // of the size of the body: how far the struck place moves, by its linear modes
const TRIED = 64; // samples by which a step is timed, the least of
const TIMES = 4; // such times, as other work takes its turns
const SHARE = 0.7; // of the time of a sample that a step may take
const FEWER = 0.75; // of the coordinates, where it takes longer

/** What is struck. @typedef {{model: import('./pack.js').Model, frequencies: number[], damping: number, vertex: number,
 *   direction: number[], rate: number}} Strike frequencies: of the body as it is stepped [Hz]; damping: its alpha [1/s];
 *   direction: in the axes of the body; rate: of samples [Hz] */

/** The largest extent of a model. @param {import('./pack.js').Model} model */
function sizeOf({ arrays: { positions } }) {
  const along = [0, 1, 2].map((axis) => positions.filter((_, n) => n % 3 === axis));
  return Math.max(...along.map((x) => x.reduce((a, b) => Math.max(a, b)) - x.reduce((a, b) => Math.min(a, b))));
}

export class StruckSound {
  /** @param {import('./engine.js').Engine} engine without models, which this sound has for itself
   * @param {Strike} strike @param {number} strength */
  constructor(engine, strike, strength = STRENGTH) {
    const { model, frequencies, vertex, direction, rate } = strike;
    Object.assign(this, { engine, strike });
    this.number = engine.addModel(model);
    const { basis, omega2 } = model.arrays;
    this.along = Array.from({ length: model.rank }, (_, i) =>
      direction.reduce((sum, n, axis) => sum + n * basis[(3 * vertex + axis) * model.rank + i], 0));

    // all frequencies of the body are those of the model times a factor
    const own = Array.from(omega2, (w2) => Math.sqrt(w2) / (2 * Math.PI));
    this.faster = haste(frequencies);
    this.pace = (this.faster * frequencies[0]) / own[0]; // time of the model in one of the listener's
    this.audible = own.filter((f) => f * this.pace < rate / 2).length;
    const bend = this.along.reduce((sum, a, i) => sum + (a * a) / Math.sqrt(omega2[i]), 0);
    this.impulse = bend > 0 ? (strength * sizeOf(model)) / bend : 0; // none at a place that is held
    this.rank = 0;
  }

  /** Begins with so many coordinates. @param {number} rank */
  begin(rank) {
    const { engine, strike, pace, along, impulse } = this;
    const dt = pace / strike.rate;
    const damping = Math.max((strike.damping * this.faster) / pace, (2 * FADE) / (SECONDS * pace));
    engine.build({ dt, integrator: 'imexv', gravity: [0, 0, 0], damping, obstacles: [], bodies: [{ name: 'struck',
      model: this.number, position: [0, 0, 0], rotation: [1, 0, 0, 0], scale: 1, stiffness: 1, density: 1, free: false,
      rank, p: along.map((a) => impulse * a) }] });
    this.rank = rank;
    this.before = new Float64Array(strike.model.rank); // with those that follow
    const first = along.slice(0, rank).reduce((sum, a) => sum + a * a, 0) * impulse * dt;
    this.loudness = first > 0 ? LOUDNESS / first : 0;
  }

  /** The next samples; what fails is silent from there on. @param {number} count @returns {Float32Array} */
  next(count) {
    const { engine, along, before } = this;
    const samples = new Float32Array(count);
    for (let n = 0; n < count; n++) {
      engine.step();
      const q = engine.shown(0);
      let way = 0;
      for (let i = 0; i < before.length; i++) {
        way += along[i] * (q[i] - before[i]);
        before[i] = q[i];
      }
      samples[n] = Math.max(-1, Math.min(1, this.loudness * way));
    }
    return samples;
  }

  /** Takes as many coordinates as are heard and stepped in time. @param {() => number} now [ms]
   * @returns {{rank: number, step: number}} rank 0: a step [s] takes too long with any number of them */
  fit(now = () => performance.now()) {
    const most = SHARE / this.strike.rate;
    let step = Infinity;
    const fewest = fewestStepped(this.strike.model);
    for (let rank = Math.max(this.audible, fewest); rank >= fewest; rank = Math.floor(FEWER * rank)) {
      this.begin(rank);
      this.next(TRIED); // what is compiled while it runs is not timed
      step = Infinity;
      for (let n = 0; n < TIMES; n++) {
        const began = now();
        this.next(TRIED);
        step = Math.min(step, (now() - began) / (1000 * TRIED));
      }
      if (step > most) continue;
      this.begin(rank);
      return { rank, step };
    }
    return { rank: 0, step };
  }
}
