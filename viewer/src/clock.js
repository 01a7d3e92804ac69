// Steps of a fixed length in real time: what a frame has to catch up, bounded.
// SPDX-License-Identifier: Apache-2.0

const CATCH_UP = 0.25; // the most time that one frame makes up for [s]
const BUDGET = { least: 12, most: 50 }; // of a frame, for steps; between them as long as drawing takes [ms]
const SHARE = 0.5; // of a drawing that takes longer than twice the most, for steps
const SMOOTHING = 0.05; // weight of the newest frame in the running means of durations
const PACE_TIME = 0.5; // over which the pace is a mean, so that few frames a second show it soon, too [s]

/** Simulated over real time, as one may ask for it. */
export const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 4];

export class Clock {
  constructor() {
    this.missing = 0; // simulated time not yet stepped [s]
    this.pace = 1; // simulated over real time, running mean
  }

  /** Takes the steps that `elapsed` seconds ask for, as far as the budget goes: where drawing is slow, steps get as much time.
   * @param {number} elapsed [s] @param {number} dt [s]
   * @param {() => boolean} step false: stop @param {number} drawing how long the last drawing took [ms]
   * @returns {number} steps taken */
  advance(elapsed, dt, step, drawing) {
    const budget = Math.max(BUDGET.least, Math.min(drawing, BUDGET.most), SHARE * drawing);
    const real = Math.min(elapsed, CATCH_UP);
    this.missing += real;
    const begin = performance.now();
    let steps = 0;
    let going = true;
    // half a step is not worth an uneven frame
    while (going && this.missing >= dt / 2 && performance.now() - begin < budget) {
      going = step();
      this.missing -= dt;
      steps++;
    }
    if (real > 0) this.pace += (elapsed / (elapsed + PACE_TIME)) * ((steps * dt) / elapsed - this.pace);
    if (this.missing >= dt) this.missing = 0; // time that cannot be made up is dropped, and the pace shows it
    return steps;
  }

  /** Is the simulation behind real time? */
  get behind() {
    return this.pace < 0.9;
  }

  /** Forgets the missing time: after a pause or a reset. */
  restart() {
    this.missing = 0;
    this.pace = 1;
  }
}

/** A running mean of durations [ms]. */
export class Meter {
  constructor() {
    this.mean = 0;
    this.count = 0;
  }

  /** @param {number} value [ms] */
  add(value) {
    this.count++;
    this.mean += Math.max(SMOOTHING, 1 / this.count) * (value - this.mean);
  }
}
