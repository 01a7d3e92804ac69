// A step fits the first mode of a model, or the page says that it does not.
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { coarseText, fittingStep } from '../src/coarse_step.js';
import { aloneScene } from '../src/scenes.js';

/** A model of these frequencies [Hz]; 0 is a coordinate that nothing holds. */
const modelOf = (...hertz) => ({ name: 'm', arrays: { omega2: Float64Array.from(hertz, (f) => (2 * Math.PI * f) ** 2) } });

test('a model by itself is shown with 20 steps in a period of its first mode at least', () => {
  assert.equal(fittingStep(modelOf(5, 400), 0.003), 0.003);
  assert.equal(fittingStep(modelOf(0, 5), 0.003), 0.003);
  assert.equal(fittingStep(modelOf(0), 0.003), 0.003);
  for (const first of [17, 123.4, 1000, 4.5e4]) {
    const steps = 1 / (first * fittingStep(modelOf(first, 2 * first), 0.003));
    assert.ok(steps >= 20 && steps < 22.3, `${steps} steps at ${first} Hz`);
  }
});

test('each model of a pack has a step of its own, but for one that a scene file gave', () => {
  const pack = { models: [modelOf(5), modelOf(1000)], scene: { dt: 0.003, bodies: [] } };
  assert.equal(aloneScene(pack, 0).dt, 0.003);
  assert.equal(aloneScene(pack, 1).dt, 5e-5);
  pack.scene.own_dt = true;
  assert.equal(aloneScene(pack, 1).dt, 0.003);
});

test('a step with too few in a period of the first mode is said, with one that would do', () => {
  assert.equal(coarseText(10, { dt: 0.01, integrator: 'energy' }), '');
  assert.equal(coarseText(undefined, { dt: 0.01, integrator: 'energy' }), '');
  assert.equal(coarseText(20, { dt: 0.01, integrator: 'energy' }),
    '; a period of mode 1 has only 5.0 steps: lower the time step, to 2.50 ms say');
  assert.match(coarseText(14, { dt: 0.01, integrator: 'newmark' }), /only 7\.1 steps.*1\.10 ms/);
  assert.equal(coarseText(14, { dt: 0.01, integrator: 'energy' }), '');
});
