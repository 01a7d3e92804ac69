// What the colours of a surface stand for, against closed forms.
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { SurfaceValues, quantitiesOf } from '../src/colours.js';
import { quantityText } from '../src/numbers.js';

// a triangle in the plane through x and a direction at an angle to y, at rest; one mode each for
// stretches along x, y and z, and one that turns about x
const ANGLE = 0.7;
const [c, s] = [Math.cos(ANGLE), Math.sin(ANGLE)];
const POSITIONS = [[0.1, 0, 0], [0.9, 0.2 * c, 0.2 * s], [0.3, 0.8 * c, 0.8 * s]];

/** @param {number[][]} modes displacements, of each vertex in turn */
function model(modes) {
  const rank = modes.length;
  const basis = new Float32Array(9 * rank);
  modes.forEach((mode, i) => mode.forEach((x, row) => { basis[row * rank + i] = x; }));
  return { rank, vertex_count: 3, young: 2e6, poisson: 0.3,
    arrays: { positions: Float32Array.from(POSITIONS.flat()), basis } };
}

const SHAPE = { source: [0, 1, 2], index: [0, 1, 2] };

/** Displacements of the vertices under a linear map. @param {number[][]} f */
const under = (f) => POSITIONS.flatMap((x) =>
  f.map((row, axis) => row.reduce((sum, a, n) => sum + a * x[n], 0) - x[axis]));

test('a bar in tension has the stress of its material along it, however it is turned', () => {
  const stretch = 1.2;
  const strain = (stretch ** 2 - 1) / 2;
  const narrow = Math.sqrt(1 - 0.6 * strain); // the sides give way by nu times the strain
  const turn = [[0.6, -0.8, 0], [0.8, 0.6, 0], [0, 0, 1]];
  const turned = turn.map((row) => [row[0] * stretch, row[1] * narrow, row[2] * narrow]);
  const values = new SurfaceValues(model([under(turned)]), SHAPE);
  const most = values.read('stress', Float32Array.of(1), 1, 1.5);
  const exact = 1.5 * 2e6 * strain * stretch / narrow ** 2; // S stretch^2 / J
  assert.ok(Math.abs(most / exact - 1) < 1e-5, `${most}, not ${exact}`);
});

test('a body that turns has no stress, and displacements are in the lengths of the world', () => {
  const turn = [[0, -1, 0], [1, 0, 0], [0, 0, 1]];
  const values = new SurfaceValues(model([under(turn)]), SHAPE);
  assert.ok(values.read('stress', Float32Array.of(1), 1, 1) < 10);
  const most = values.read('displacement', Float32Array.of(1), 3, 1);
  const far = Math.max(...POSITIONS.map(([x, y]) => Math.hypot(x, y)));
  assert.ok(Math.abs(most / (3 * Math.SQRT2 * far) - 1) < 1e-6);
});

test('stress is offered where each body has one material', () => {
  const one = { regions: 1, poisson: 0.3 };
  assert.ok(quantitiesOf({ models: [one] }).includes('stress'));
  assert.ok(!quantitiesOf({ models: [one, { regions: 2, poisson: 0.3 }] }).includes('stress'));
});

test('numbers have three digits and a prefix', () => {
  assert.deepEqual([1234, 0.0123, 2.5e-6, 0, -1e9, 999.6].map((x) => quantityText(x, 'Pa')),
    ['1.23 kPa', '12.3 mPa', '2.50 µPa', '0.00 Pa', '-1.00 GPa', '1.00 kPa']);
});
