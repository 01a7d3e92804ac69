// Links and coupled bodies on the page, of the surface alone: with the bits of thrum simulate, which has the mesh.
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { test } from 'node:test';
import * as THREE from 'three';
import { boundsOfMotion, boundsOfSwings } from '../src/bounds.js';
import { OPEN, stateOf } from '../src/link_marks.js';
import { LINK_NUMBERS } from '../src/pack.js';
import { Recording } from '../src/recording.js';
import { aloneScene, comparedScene, isComposed } from '../src/scenes.js';
import { folder, lastRow, packOf, stepped, thrum } from './fixture.mjs';

const BAR = { model: 'beam:4x2x2@0.4x0.1x0.1', free: true, collide: false };
const HELD = { name: 'held', model: 'beam:6x2x2@0.6x0.1x0.1', fix: ['x<0.001'], position: [0, 1, 0.5] };
const GRAVITY = [0, 0, -9.81];
const LINKED = {
  dt: 0.002, time: 0.6, gravity: GRAVITY, outputs: { record_every: 1, accept_error: '100%' },
  bodies: [{ name: 'upper', ...BAR }, { name: 'lower', ...BAR, position: [0.4, 0, 0], density: 0.7 },
    { name: 'weight', ...BAR, position: [2, 0, 0], rotation: { axis: [1, 2, 3], angle: 40 } }, HELD],
  links: [
    { name: 'pivot', kind: 'hinge', body: 'upper', place: [0, 0.05, 0.05], axis: [0, 1, 0] },
    { name: 'elbow', kind: 'ball', body: 'upper', place: [0.4, 0.05, 0.05], other: 'lower', until: 0.4 },
    { name: 'rope', kind: 'spring', body: 'weight', at: 'vertex=1', other_place: [2, 0, 1], stiffness: 400, damping: 4 },
    { name: 'handle', kind: 'weld', body: 'held', at: 'tip', until: 0.5,
      path: [{ time: 0.1, place: [0, 0, 0] }, { time: 0.4, place: [0, 0.02, 0.03] }] },
  ],
};
const SPINNING = {
  dt: 0.002, time: 0.4, outputs: { record_every: 1 },
  bodies: [{ name: 'wheel', ...BAR, coupled: true, spin: [200, 3000, -700] },
    { name: 'smaller', ...BAR, coupled: true, spin: [900, 100, 4000], position: [2, 0, 0], scale: 0.7, stiffness: 0.2 }],
  links: [],
};

/** Runs a scene in the program and in the page's engine. @returns {Promise<{pack: object, engine: Engine, report: object}>} */
async function both(name, scene) {
  writeFileSync(join(folder, `${name}.json`), JSON.stringify(scene));
  thrum('simulate', `${name}.json`, '-o', name, '--quiet');
  const pack = packOf(`${name}.json`);
  const engine = await stepped(pack, pack.scene, Math.round(scene.time / scene.dt));
  return { pack, engine, report: JSON.parse(readFileSync(join(folder, name, 'scene.json'), 'utf8')) };
}

/** q of a run is that of the model: U q_model scale = U' q with U' = U / sqrt(density scale^3). */
const asModel = (q, { scale, density }) => q.map((x) => x / (Math.sqrt(density * scale ** 3) * scale));

function assertBits(name, pack, engine) {
  pack.scene.bodies.forEach((body, n) => {
    const wanted = lastRow(join(folder, name, body.name, 'q.npy'), body.rank);
    assert.ok(wanted.some((x) => x !== 0), `${body.name} moves`);
    if (body.scale === 1 && body.density === 1) assert.deepEqual(engine.coordinates(n), wanted, body.name);
    else
      asModel(engine.coordinates(n), body).forEach((x, i) => // the factor rounds
        assert.ok(Math.abs(x - wanted[i]) <= 4 * Number.EPSILON * Math.abs(wanted[i]), `${body.name}: ${x} ${wanted[i]}`));
  });
}

test('links have the bits of the program, and what they did is what it reports', async () => {
  const { pack, engine, report } = await both('linked', LINKED);
  assertBits('linked', pack, engine);
  report.links.forEach((wanted, n) => {
    const link = engine.link(n);
    assert.equal(link.holds, wanted.holds);
    assert.deepEqual(link.places.slice(0, 3), wanted.place_m);
    assert.deepEqual(link.force, wanted.force_n);
    assert.equal(link.largestDrift, wanted.largest_drift_m);
    assert.equal(link.stored, wanted.stored_j);
  });
  assert.deepEqual(report.links.map(({ holds }) => holds), [true, false, true, false]);

  // and again after a reset
  const before = pack.scene.bodies.map((_, n) => engine.coordinates(n));
  engine.reset();
  for (let i = 0; i < 300; i++) engine.step();
  assert.deepEqual(pack.scene.bodies.map((_, n) => engine.coordinates(n)), before);
});

test('coupled bodies have the bits of the program, and stretch as they spin', async () => {
  const { pack, engine } = await both('spinning', SPINNING);
  assertBits('spinning', pack, engine);
  for (const body of [0, 1]) assert.ok(engine.energies(body).potential > 0);

  // without the coupling they turn as the body at rest would
  const apart = { ...pack.scene, bodies: pack.scene.bodies.map((body) => ({ ...body, coupled: false })) };
  assert.ok((await stepped(pack, apart, 200)).energies(0).potential === 0);

  // which is what they are compared with, as there is no other integrator for them
  const two = comparedScene(pack, pack.scene);
  assert.deepEqual(two.bodies.map(({ coupled, integrator }) => [coupled, integrator]),
    [[true, 'energy'], [true, 'energy'], [false, 'energy'], [false, 'energy']]);
  const side = await stepped(pack, two, 200);
  assert.ok(Math.abs(side.energies(0).potential / engine.energies(0).potential - 1) < 1e-9);
  assert.equal(side.energies(2).potential, 0);
});

test('beside bodies that are compared, coupled ones are stepped by energy in each copy', async () => {
  const [wheel, smaller] = SPINNING.bodies;
  writeFileSync(join(folder, 'beside.json'), JSON.stringify({ ...SPINNING, bodies: [wheel, { ...smaller, coupled: false }] }));
  const pack = packOf('beside.json');
  const three = comparedScene(pack, pack.scene);
  assert.deepEqual(three.bodies.map(({ coupled, integrator }) => [coupled ?? false, integrator]),
    ['imexv', 'newmark', 'energy'].flatMap((integrator) => [[true, 'energy'], [false, integrator]]));

  // each copy of it stretches as it does by itself
  const [engine, one] = [await stepped(pack, three, 50), await stepped(pack, pack.scene, 50)];
  for (const copy of [0, 2, 4])
    assert.ok(Math.abs(engine.energies(copy).potential / one.energies(0).potential - 1) < 1e-9);
});

test('a joint between coupled bodies has the bits of the program', async () => {
  const [wheel] = SPINNING.bodies;
  const { pack, engine } = await both('joined', { ...SPINNING, time: 0.1,
    bodies: [{ ...wheel, spin: [0, 200, 0] }, { ...wheel, name: 'other', position: [0.4, 0, 0], spin: [0, 0, 0] }],
    links: [{ kind: 'ball', body: 'wheel', place: [0.4, 0.05, 0.05], other: 'other' }] });
  assertBits('joined', pack, engine);
  assert.ok(engine.link(0).largestDrift < 1e-9);
});

test('only models of coupled bodies carry the numbers of an inertia', () => {
  writeFileSync(join(folder, 'plain.json'), JSON.stringify({ ...SPINNING,
    bodies: SPINNING.bodies.map((body) => ({ ...body, coupled: false })) }));
  assert.ok(packOf('spinning.json').models[0].arrays.inertia.length > 9);
  assert.equal(packOf('plain.json').models[0].arrays.inertia, undefined);
});

test('the recording of a run has its links in each of its rows, and their places between them', () => {
  const columns = LINK_NUMBERS * LINKED.links.length;
  writeFileSync(join(folder, 'tied.json'), JSON.stringify(LINKED));
  thrum('simulate', 'tied.json', '-o', 'tied', '--quiet');
  const report = JSON.parse(readFileSync(join(folder, 'tied', 'scene.json'), 'utf8'));
  const pack = packOf('tied');
  const recording = new Recording(pack.recording, pack);
  const flat = () => recording.links().flatMap(({ holds, drift, places }) => [Number(holds), drift, ...places]);

  // the file has a row for each step and one before them, of which the page shows 60 a second
  const bytes = readFileSync(join(folder, 'tied', 'links.npy'));
  const first = bytes.length - 8 * columns * (1 + Math.round(LINKED.time / LINKED.dt));
  assert.ok(recording.times.length < 40);
  for (const time of recording.times) {
    recording.seek(time);
    const row = first + 8 * columns * Math.round(time / LINKED.dt);
    assert.deepEqual(flat(), Array.from({ length: columns }, (_, i) => bytes.readDoubleLE(row + 8 * i)));
  }
  assert.deepEqual(recording.links().map(({ name, kind, holds, places }) => [name, kind, holds, ...places]),
    report.links.map((link) => [link.name, link.kind, link.holds, ...link.place_m, ...link.other_place_m]));

  // halfway between two rows a place is halfway
  const [t, u] = recording.times.slice(3);
  const [from, middle, to] = [t, (t + u) / 2, u].map((time) => { recording.seek(time); return recording.links()[2].places; });
  middle.forEach((x, i) => assert.ok(Math.abs(x - (from[i] + to[i]) / 2) < 1e-12));
  assert.notDeepEqual(from, to);

  // a file of other rows is refused
  writeFileSync(join(folder, 'tied', 'links.npy'), bytes.subarray(0, bytes.length - 8));
  const { status, stderr } = spawnSync(process.env.THRUM_PROGRAM, ['view', 'tied', '-o', 'tied.html'], { cwd: folder, encoding: 'utf8' });
  assert.notEqual(status, 0);
  assert.match(stderr, /links\.npy/);
});

test('thrum view warns of neither links nor coupled bodies', () => {
  writeFileSync(join(folder, 'all.json'), JSON.stringify({ ...LINKED,
    bodies: LINKED.bodies.map((body) => (body.free ? { ...body, coupled: true } : body)) }));
  const { status, stderr } = spawnSync(process.env.THRUM_PROGRAM, ['view', 'all.json', '-o', 'all.html'], { cwd: folder, encoding: 'utf8' });
  assert.equal(status, 0);
  assert.doesNotMatch(stderr, /leaves out/);
});

test('copies that are compared have links of their own, and a model by itself has none', async () => {
  const pack = packOf('linked.json');
  assert.ok(isComposed(pack));
  const three = comparedScene(pack, pack.scene);
  assert.equal(three.links.length, 12);
  const engine = await stepped(pack, three, 100);
  const one = await stepped(pack, pack.scene, 100);
  for (let n = 0; n < 4; n++) {
    const wanted = one.coordinates(n); // energy, as the scene; places round elsewhere in the world
    const size = Math.hypot(...wanted);
    assert.ok(Math.hypot(...engine.coordinates(8 + n).map((x, i) => x - wanted[i])) <= 1e-9 * size);
    const [copy, own] = [engine.link(8 + n), one.link(n)];
    assert.ok(Math.abs(copy.places[2] - own.places[2]) < 1e-9);
    assert.ok(copy.places[0] > own.places[0] + 1);
  }
  assert.equal((await stepped(pack, aloneScene(pack, 0), 10)).links.length, 0);
});

test('a link is shown as what it is', () => {
  assert.equal(stateOf({ kind: 'spring' }, { holds: true, drift: 0.1 }), 'spring');
  assert.equal(stateOf({ kind: 'ball' }, { holds: true, drift: OPEN }), 'joint');
  assert.equal(stateOf({ kind: 'weld' }, { holds: true, drift: 2 * OPEN }), 'open');
  assert.equal(stateOf({ kind: 'hinge' }, { holds: false, drift: 0 }), 'released');
});

const box = (...numbers) => new THREE.Box3(new THREE.Vector3(...numbers.slice(0, 3)), new THREE.Vector3(...numbers.slice(3)));
const assertBox = (found, ...wanted) => [...found.min.toArray(), ...found.max.toArray()]
  .forEach((x, n) => assert.ok(Math.abs(x - wanted[n]) < 1e-12, `${JSON.stringify(found)}, not ${wanted}`));

test('what hangs on a joint has room to swing, over the length of what hangs on it', () => {
  const upper = { box: box(0, 0, 1, 1, 0, 1), free: true };
  const lower = { box: box(1, 0, 1, 3, 0, 1), free: true };
  const held = { box: box(9, 0, 2, 10, 0, 2), free: false };
  const pivot = { kind: 'hinge', body: 0, place: new THREE.Vector3(0, 0, 1), axis: new THREE.Vector3(0, 1, 0) };
  const elbow = { kind: 'ball', body: 0, other: 1, place: new THREE.Vector3(1, 0, 1) };
  const down = new THREE.Vector3(0, 0, -9.81);

  // across the axis alone, and no higher than the beam that is held
  const rooms = boundsOfSwings([upper, lower, held], [pivot, elbow], down);
  assertBox(rooms[0], -1, 0, 0, 1, 0, 2);
  assertBox(rooms[1], -3, 0, -2, 3, 0, 2);
  assertBox(rooms[2], 9, 0, 2, 10, 0, 2);

  // held at its other end too, it leaves neither place farther than the bars are long
  const end = { kind: 'ball', body: 1, other: 2, place: new THREE.Vector3(3, 0, 1) };
  assertBox(boundsOfSwings([upper, lower, held], [pivot, elbow, end], down)[0], 0, 0, 0, 1, 0, 2);
  assertBox(boundsOfSwings([upper, lower, held], [{ ...pivot, kind: 'weld' }, elbow], down)[1], 1, 0, 1, 3, 0, 1);
  assertBox(boundsOfSwings([upper], [{ ...pivot, axis: undefined }], new THREE.Vector3())[0], -1, -1, 0, 1, 1, 2);
});

test('what moves in a run has room for its way, unless it falls out of the world', () => {
  const recording = { begin: 0, end: 2, time: 0.5, seek(time) { this.time = time; },
    matrix(body) { return new THREE.Matrix4().makeTranslation(body === 0 ? this.time : 0, 0, body === 0 ? 0 : -1000 * this.time).elements; } };
  const own = box(0, 0, 0, 1, 1, 1);
  assertBox(boundsOfMotion(recording, 0, own, box(0, 0, 0, 4, 1, 1)), 0, 0, 0, 3, 1, 1);
  assertBox(boundsOfMotion(recording, 1, own, box(0, 0, 0, 4, 1, 1)), 0, 0, -4, 1, 1, 1);
  assert.equal(recording.time, 0.5);
});
