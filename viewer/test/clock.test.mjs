// How many steps a frame takes, with time that a test tells. SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { afterEach, beforeEach, test } from 'node:test';
import { Clock } from '../src/clock.js';

// the time of the machine cannot be written to in node 18, but the object that tells it can be another one
const real = Object.getOwnPropertyDescriptor(globalThis, 'performance');
let now = 0;
beforeEach(() => {
  Object.defineProperty(globalThis, 'performance', { configurable: true, writable: true, value: { now: () => now } });
});
afterEach(() => { Object.defineProperty(globalThis, 'performance', real); });

/** Frames of which each draws for `drawing` ms and steps for as long as the clock lets it, a step of 2 ms of simulated time
 * taking `cost` ms. @returns {{pace: number, true: number, frame: number}} as it is told, as it is, and the last frame [ms] */
function run(drawing, cost, frames = 200) {
  const clock = new Clock();
  let elapsed = 16.7;
  let [simulated, total] = [0, 0];
  for (let n = 0; n < frames; n++) {
    const from = now;
    const steps = clock.advance(elapsed / 1e3, 0.002, () => { now += cost; return true; }, drawing);
    now += drawing;
    elapsed = Math.max(16.7, now - from);
    if (n < frames / 2) continue;
    simulated += steps * 2;
    total += elapsed;
  }
  return { pace: clock.pace, true: simulated / total, frame: elapsed };
}

test('steps that are cheap follow real time, however slow the drawing is', () => {
  for (const drawing of [1, 40, 100, 200]) {
    const { pace, true: truth } = run(drawing, 0.02);
    assert.ok(Math.abs(truth - 1) < 0.1 && Math.abs(pace - 1) < 0.1, `${drawing} ms: ${truth}, told ${pace}`);
  }
});

test('steps that are dear get as much time as drawing, up to a bound, and the pace says what comes of it', () => {
  for (const [drawing, least, longest] of [[1, 0.55, 20], [30, 0.35, 66], [100, 0.25, 156], [600, 0.25, 910]]) {
    const { pace, true: truth, frame } = run(drawing, 2.4);
    assert.ok(truth > least, `${drawing} ms: ${truth} of real time`);
    assert.ok(Math.abs(pace - truth) < 0.05 * truth, `${pace} is told, ${truth} is true`);
    assert.ok(frame < longest, `a frame takes ${frame} ms`);
  }
});

test('what cannot be made up is dropped, and the pace shows it soon', () => {
  const clock = new Clock();
  let steps = 0;
  for (let n = 0; n < 5; n++) steps += clock.advance(0.4, 0.002, () => { now += 0.01; return true; }, 400);
  assert.equal(steps, 5 * 125); // a quarter of a second each
  assert.ok(clock.pace < 0.75, `${clock.pace}`);
});
