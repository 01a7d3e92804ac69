// The sound of a strike, against its modes.
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { haste, strikeSamples, strikeWeights } from '../src/strike.js';
import { partOf } from './spectrum.mjs';

const RATE = 8000;
const part = partOf(RATE);

test('a strike has the modes of the body, each by its weight', () => {
  const samples = strikeSamples([200, 330, 5000], [1, 0.25, 9], 0, RATE); // the last is out of range
  assert.ok(samples.every(Number.isFinite));
  assert.ok(Math.abs(part(samples, 330) / part(samples, 200) - 0.25) < 0.02);
  assert.ok(part(samples, 265) < 0.05 * part(samples, 200));
  assert.ok(Math.abs(samples[0] - 0.5) < 0.01); // all begin together, as loud as may be
});

test('it falls off as damping says, and low bodies are played faster as a whole', () => {
  const end = (samples) => Math.max(...samples.slice(RATE, RATE + 80).map(Math.abs));
  const ratio = end(strikeSamples([200], [1], 8, RATE)) / end(strikeSamples([200], [1], 4, RATE));
  assert.ok(Math.abs(ratio / Math.exp(-2) - 1) < 0.01, `${ratio}`);
  assert.equal(haste([200, 300]), 1);
  assert.equal(haste([11, 300]), 10);
  assert.ok(part(strikeSamples([11, 22], [1, 1], 0, RATE), 220) > 100);
});

test('a mode that does not move the place along the strike is not heard', () => {
  const model = { rank: 2, arrays: { basis: Float32Array.of(9, 9, 9, 9, 9, 9, 1, 0, 0, 3, 0, 0) } };
  assert.deepEqual(strikeWeights(model, 1, [1, 0, 0]), [1, 0]);
  assert.deepEqual(strikeWeights(model, 1, [0, 0.5, 0]), [0, 2.25]);
});
