// The sound of a struck body by its whole model: that of its linear modes where the strike is weak, another one where it
// is strong, with as many coordinates as a machine steps in time.
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { Engine } from '../src/engine.js';
import { StruckSound } from '../src/sound.js';
import { heardText, haste, strikeSamples, strikeWeights } from '../src/strike.js';
import { packOf, thrum, wasmBytes } from './fixture.mjs';
import { partOf } from './spectrum.mjs';

const RATE = 8000;
thrum('precompute', 'beam:6x2x2@1x0.1x0.1,split=6', '--order', '1', '--fix', 'x<0.001', '--order', '1', '--modes', '4', '--rank', '6', '-o', 'struck.npz', '--quiet');
const [model] = packOf('struck.npz').models;
const tip = [...Array(model.vertex_count).keys()].reduce((best, v) =>
  (model.arrays.positions[3 * v] > model.arrays.positions[3 * best] ? v : best), 0);
const frequencies = Array.from(model.arrays.omega2, (w2) => 1.5 * Math.sqrt(w2) / (2 * Math.PI)); // of a stiffer body
const part = partOf(RATE);
const strike = { model, frequencies, damping: 3, vertex: tip, direction: [0, 0, 1], rate: RATE };
const made = async (strength) => new StruckSound(await Engine.load(wasmBytes()), strike, strength);

test('a weak strike sounds as the linear modes do', async () => {
  const sound = await made(1e-6);
  sound.begin(sound.audible);
  const heard = sound.next(RATE);
  const modes = strikeSamples(frequencies, strikeWeights(model, tip, [0, 0, 1]), 3, RATE).slice(0, RATE);
  const first = frequencies[0] * haste(frequencies);
  assert.ok(Math.abs(first - 110) < 1e-9);
  const ratio = part(heard, first) / part(modes, first);
  assert.ok(Math.abs(ratio - 1) < 0.02, `${ratio}`);

  // the others are as loud, though a step of order 2 detunes them
  const power = (samples) => samples.reduce((sum, x) => sum + x * x, 0);
  const louder = power(heard) / power(modes);
  assert.ok(Math.abs(louder - 1) < 0.1, `${louder}`);
});

test('a strong strike bends the body, and is heard to', async () => {
  const [weak, strong] = [await made(1e-6), await made(0.3)];
  for (const sound of [weak, strong]) sound.begin(sound.audible);
  const [soft, hard] = [weak.next(RATE), strong.next(RATE)];
  assert.ok(hard.every((x) => Math.abs(x) <= 1));
  const off = Math.sqrt(soft.reduce((sum, x, n) => sum + (x - hard[n]) ** 2, 0) / soft.reduce((sum, x) => sum + x * x, 0));
  assert.ok(off > 0.1, `${off}`);
});

test('as many coordinates sound as are stepped in time', async () => {
  const sound = await made();
  const every = (took) => { let [time, n] = [0, 0]; return () => { time += n++ % 2 ? took(n) : 0; return time; }; };
  const slow = 1000 * 64 / RATE; // [ms] of 64 samples
  assert.equal(sound.fit(every(() => 0.1 * slow)).rank, sound.audible);

  // four times are taken, of which the least counts; then it is tried with fewer
  assert.equal(sound.fit(every((n) => (n === 4 ? 0.1 : 1) * slow)).rank, sound.audible);
  const { rank, step } = sound.fit(every((n) => (n <= 8 ? 1 : 0.1) * slow));
  assert.equal(rank, Math.floor(0.75 * sound.audible));
  assert.ok(step < 1 / RATE);
  assert.equal(sound.fit(every(() => slow)).rank, 0);
});

test('a place that is held is silent', async () => {
  const held = new StruckSound(await Engine.load(wasmBytes()), { ...strike, vertex: model.arrays.fixed.indexOf(7) });
  held.begin(held.audible);
  assert.ok(held.next(100).every((x) => x === 0));
});

test('the page says what is heard', () => {
  assert.equal(heardText({ rank: 9, of: 20, faster: 12, step: 1e-5, rate: 48000 }), 'nonlinear, 9 of 20 coordinates, 12 times as fast');
  assert.equal(heardText({ rank: 0, faster: 1, step: 6e-5, rate: 48000 }), 'linear modes: a step takes 60 µs of the 21 µs of a sample');
  assert.equal(heardText({ rank: 0, faster: 2.5, step: 0, rate: 48000 }), 'linear modes, 2.5 times as fast');
});
