// A beam is struck and swings for a minute: its energy stays. Run: node node.mjs MODEL.npz
// SPDX-License-Identifier: Apache-2.0
import { readFile } from 'node:fs/promises';
import { load } from 'thrum';

const thrum = await load();
const model = thrum.model(await readFile(process.argv[2] ?? 'beam.npz'));

// a blow of 0.1 s at the tip, then nothing more acts
const state = model.state({ integrator: 'energy', dt: 0.003 });
state.setForce(model.externalLoad({ force: [0, 0, -40], group: 'tip' }));
state.step(33);
state.setForce();

const before = state.energies.total;
const start = performance.now();
state.step(20000);
const microseconds = (performance.now() - start) / 20; // ms of 20,000 steps
console.log(`${model.rank} coordinates, ${microseconds.toFixed(2)} us a step`);
console.log(`energy ${before.toFixed(6)} J, after a minute ${state.energies.total.toFixed(6)} J`);
