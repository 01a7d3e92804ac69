// The engine without a browser: the same bits as the native library, and the pack's own checks.
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { before, test } from 'node:test';
import { gzipSync } from 'node:zlib';
import { SurfaceValues } from '../src/colours.js';
import { Engine } from '../src/engine.js';
import { bytesOfElement, readPack } from '../src/pack.js';
import { smooth } from '../src/smooth.js';
import { folder, lastRow, packOf, thrum, wasmBytes } from './fixture.mjs';
import { writePack } from './pack_write.mjs';

const STEPS = 1000;
const GRAVITY = [0, 0, -9.81];
let pack;

before(() => {
  thrum('precompute', 'beam:8x2x2@1x0.2x0.2,split=6', '--order', '1', '--fix', 'x<0.001', '--modes', '5', '--rank', '9',
    '-o', 'beam.npz', '--quiet');
  pack = packOf('beam.npz');
});

/** The engine with one body of the pack after `steps` steps. */
async function run(change, steps) {
  const engine = await Engine.load(wasmBytes());
  pack.models.forEach((model) => engine.addModel(model));
  engine.build({ ...pack.scene, gravity: GRAVITY, dt: 0.003, ...change });
  for (let i = 0; i < steps; i++) engine.step();
  return engine;
}

for (const integrator of ['imexv', 'newmark', 'energy'])
  test(`${integrator}: ${STEPS} steps have the bits of the native library`, async () => {
    thrum('simulate', 'beam.npz', '-o', integrator, '--integrator', integrator, '--damping', '0',
      '--load', `gravity:${GRAVITY}`, '--dt', '0.003', '--time', String(0.003 * STEPS), '--quiet');
    const engine = await run({ integrator, damping: 0 }, STEPS);
    assert.deepEqual(engine.coordinates(0), lastRow(join(folder, integrator, 'q.npy'), 9));
  });

for (const law of ['stvk', 'corotational', 'neo-hookean'])
  test(`a model of cubature points of ${law} has the bits of the native library`, async () => {
    thrum('precompute', 'beam:8x2x2@1x0.2x0.2,split=6', '--order', '1', '--fix', 'x<0.001', '--modes', '5', '--rank', '9',
      '--cubature', '--cubature-error', '0.05', '--law', law, '-o', `${law}.npz`, '--quiet');
    thrum('simulate', `${law}.npz`, '-o', law, '--integrator', 'energy', '--damping', '0',
      '--load', `gravity:${GRAVITY}`, '--dt', '0.003', '--time', '0.3', '--quiet');
    const points = packOf(`${law}.npz`);
    const engine = await Engine.load(wasmBytes());
    points.models.forEach((model) => engine.addModel(model));
    engine.build({ ...points.scene, gravity: GRAVITY, dt: 0.003, integrator: 'energy', damping: 0 });
    for (let i = 0; i < 100; i++) engine.step();
    assert.deepEqual(engine.coordinates(0), lastRow(join(folder, law, 'q.npy'), 9));
  });

test('regions of several laws have the bits of the native library', async () => {
  thrum('convert', 'beam:8x2x2@1x0.2x0.2', 'one.mesh');
  const [head, tets] = readFileSync(join(folder, 'one.mesh'), 'utf8').split('Tetrahedra\n');
  const rows = tets.split('\n');
  const count = Number(rows[0]);
  const divided = rows.map((row, n) => (n > 0 && n <= count
    ? row.trim().split(/\s+/).slice(0, 4).concat(n % 3 + 1).join(' ') : row));
  writeFileSync(join(folder, 'parts.mesh'), `${head}Tetrahedra\n${divided.join('\n')}`);

  // one region of each law
  const laws = ['1:stvk', '2:corotational', '3:neo-hookean'].flatMap((text) => ['--material', text]);
  thrum('precompute', 'parts.mesh', '--fix', 'x<0.001', '--modes', '5', '--rank', '9', '--young', '5e6',
    '--poisson', '0.4', '--density', '1000', '--cubature', '--cubature-error', '0.05', ...laws,
    '-o', 'parts.npz', '--quiet');
  thrum('simulate', 'parts.npz', '-o', 'parts', '--integrator', 'energy', '--damping', '0',
    '--load', `gravity:${GRAVITY}`, '--dt', '0.003', '--time', '0.3', '--quiet');
  const points = packOf('parts.npz');
  assert.deepEqual([...points.models[0].arrays.region_law], [0, 1, 2]);
  const engine = await Engine.load(wasmBytes());
  points.models.forEach((model) => engine.addModel(model));
  engine.build({ ...points.scene, gravity: GRAVITY, dt: 0.003, integrator: 'energy', damping: 0 });
  for (let i = 0; i < 100; i++) engine.step();
  assert.deepEqual(engine.coordinates(0), lastRow(join(folder, 'parts', 'q.npy'), 9));
});

test('touch modes follow a pull; what is stepped beside them has the bits of the native library', async () => {
  thrum('precompute', 'beam:8x2x2@1x0.2x0.2,split=6', '--order', '1', '--fix', 'x<0.001', '--modes', '5', '--rank', '9',
    '--touch', '-o', 'touch.npz', '--quiet');
  thrum('simulate', 'touch.npz', '-o', 'touch', '--integrator', 'energy', '--damping', '0',
    '--load', `gravity:${GRAVITY}`, '--dt', '0.003', '--time', '0.3', '--quiet');
  const touched = packOf('touch.npz');
  const [model] = touched.models;
  assert.equal(model.masters, 9);
  const engine = await Engine.load(wasmBytes());
  engine.addModel(model);
  engine.build({ ...touched.scene, gravity: GRAVITY, dt: 0.003, integrator: 'energy', damping: 0 });
  for (let i = 0; i < 100; i++) engine.step();
  assert.deepEqual(engine.coordinates(0), lastRow(join(folder, 'touch', 'q.npy'), model.rank).slice(0, 9));

  // nothing follows where nothing acts, and a pull is followed until it ends
  const following = () => Math.max(...Array.from(engine.shape(0).slice(9), Math.abs));
  engine.build({ ...touched.scene, gravity: [0, 0, 0], dt: 0.003 });
  engine.step();
  assert.equal(following(), 0);
  const vertex = model.arrays.fixed.findIndex((held) => held === 0);
  const [x, y, z] = engine.position(0, vertex);
  const pull = engine.startPull(0, vertex, [x, y, z + 0.01], 10);
  engine.step();
  assert.ok(following() > 0);
  engine.endPull(pull);
  engine.step();
  assert.equal(following(), 0);
});

test('fewer coordinates, as the slider sets them, do not lock a body: the others follow', async () => {
  thrum('precompute', 'beam:8x2x2@1x0.15x0.15,split=6', '--order', '1', '--fix', 'x<0.001', '--modes', '6', '--rank', '12',
    '-o', 'swing.npz', '--quiet');
  const swing = packOf('swing.npz');
  const [{ vertex_count: count, arrays: { positions } }] = swing.models;
  const tip = [...Array(count).keys()].reduce((a, b) => (positions[3 * b] > positions[3 * a] ? b : a));
  const furthest = async (rank, later) => {
    const engine = await Engine.load(wasmBytes());
    engine.addModel(swing.models[0]);
    engine.build({ ...swing.scene, bodies: [{ ...swing.scene.bodies[0], rank }], gravity: [0, 0, -20],
      dt: 0.002, integrator: 'energy', damping: 0 });
    if (later) engine.setRank(0, later);
    const rest = engine.position(0, tip)[2];
    let far = 0;
    for (let i = 0; i < 200; i++) {
      engine.step();
      far = Math.max(far, Math.abs(engine.position(0, tip)[2] - rest));
    }
    return far;
  };
  const whole = await furthest(12);
  assert.ok(whole > 0.1, `${whole}`);
  for (const rank of [6, 4]) {
    assert.ok(Math.abs((await furthest(rank)) / whole - 1) < 0.03);
    assert.ok(Math.abs((await furthest(12, rank)) / whole - 1) < 0.03);
  }
});

test('energy keeps the total to 1e-9 over 1000 steps without damping', async () => {
  const engine = await run({ integrator: 'energy', damping: 0 }, 0);
  let swing = 0;
  for (let i = 0; i < 1000; i++) {
    engine.step();
    const { kinetic, potential, total } = engine.energies(0);
    swing = Math.max(swing, kinetic + potential);
    assert.ok(Math.abs(total) <= 1e-9 * swing, `step ${i}: ${total} J of ${swing} J`);
  }
  assert.ok(swing > 1);
});

test('a beam that would sag through a plane comes to rest on it', async () => {
  const lowest = (engine) => Math.min(...Array.from({ length: pack.models[0].vertex_count },
    (_, v) => engine.position(0, v)[2]));
  const floor = -0.12; // the beam's lower side is at -0.1
  const soft = { bodies: [{ ...pack.scene.bodies[0], stiffness: 0.1 }], damping: 2 };
  const plane = { kind: 'plane', centre: [0, 0, floor], normal: [0, 0, 1] };
  assert.ok(lowest(await run(soft, 3000)) < floor - 0.02);
  const rest = lowest(await run({ ...soft, obstacles: [plane] }, 3000));
  assert.ok(Math.abs(rest - floor) < 1e-3, `${rest} m`);
});

test('a free body falls as all things do, and turns', async () => {
  thrum('precompute', 'beam:4x2x2@1x0.2x0.2,split=6', '--order', '1', '--modes', '4', '--rank', '6', '-o', 'free.npz',
    '--quiet');
  const [model] = packOf('free.npz').models;
  const engine = await Engine.load(wasmBytes());
  engine.addModel(model);
  const body = { ...pack.scene.bodies[0], model: 0, rank: 0, free: true };
  engine.build({ ...pack.scene, gravity: GRAVITY, dt: 0.003, bodies: [body] });
  for (let i = 0; i < 100; i++) engine.step();
  const fallen = model.arrays.positions[2] - engine.position(0, 0)[2];
  assert.ok(Math.abs(fallen - (9.81 * 0.3 ** 2) / 2) < 1e-6, `${fallen} m`);
  // about its longest axis, of the least inertia, a body turns steadily: 0.3 s at 2 rad/s
  const spinning = { ...body, spin: [2, 0, 0] };
  engine.build({ ...pack.scene, gravity: [0, 0, 0], dt: 0.003, bodies: [spinning] });
  for (let i = 0; i < 100; i++) engine.step();
  const matrix = Array.from(engine.matrix(0));
  assert.ok(Math.abs(Math.atan2(matrix[6], matrix[5]) - 0.6) < 1e-4, `${matrix}`);
});

test('a vertex that the body has not cannot be pulled', async () => {
  const engine = await run({ gravity: [0, 0, 0] }, 0);
  for (const vertex of [-1, 100000, 2 ** 30])
    assert.throws(() => engine.startPull(0, vertex, [0, 0, 0], 1), /no vertex/);
});

test('a pull brings a vertex to its target, the nearer the stronger', async () => {
  const away = async (strength) => {
    const engine = await run({ gravity: [0, 0, 0], damping: 3 }, 0);
    const tip = pack.models[0].vertex_count - 1;
    const target = engine.position(0, tip).map((x, axis) => x + [0, 0.02, 0.03][axis]);
    const pull = engine.startPull(0, tip, target, strength);
    for (let i = 0; i < 2000; i++) engine.step();
    const [, y, z] = engine.position(0, tip);
    const distance = Math.hypot(y - target[1], z - target[2]); // along the beam nothing gives way
    engine.endPull(pull);
    for (let i = 0; i < 4000; i++) engine.step();
    assert.ok(Math.hypot(...engine.coordinates(0)) < 1e-3, 'it goes back when it is let go');
    return distance / Math.hypot(0.02, 0.03);
  };
  const [weak, strong] = [await away(1), await away(100)];
  assert.ok(weak < 0.8 && strong < 0.05, `${weak} ${strong}`);
});

test('a pack reads back as it was written', () => {
  const again = readPack(writePack(pack));
  assert.deepEqual(again.scene, pack.scene);
  assert.deepEqual(again.models, pack.models);
});

test('a pack that is cut off, of another format or none is refused', () => {
  const bytes = writePack(pack);
  assert.throws(() => readPack(bytes.subarray(0, bytes.length - 64)), /ends inside an array/);
  assert.throws(() => readPack(bytes.subarray(0, 100)), /ends inside its header/);
  assert.throws(() => readPack(Buffer.from('PK')), /no pack/);
  const other = Buffer.from(bytes);
  other.write('"format":2', bytes.indexOf('"format":1'));
  assert.throws(() => readPack(other), /format 2/);
  const link = { kind: 'ball', body: 0, place: [0, 0, 0], other_place: [0, 0, 0], rest: Array(12).fill(0),
    other_rest: Array(12).fill(0), rows: [] };
  const linked = (change) => writePack({ ...pack, scene: { ...pack.scene, links: [{ ...link, ...change }] } });
  readPack(linked({}));
  assert.throws(() => readPack(linked({ kind: 'rope' })), /'rope' is no kind/);
  assert.throws(() => readPack(linked({ rest: [1, 2] })), /'rest' has not 12/);
  assert.throws(() => readPack(linked({ times: [0, 1], places: [0, 0, 0] })), /three numbers a time/);
  assert.throws(() => readPack(linked({ rows: [1] })), /twelve a coordinate/);
  const [model] = pack.models;
  const broken = (change) => writePack({ ...pack, models: [{ ...model, ...change }] });
  assert.throws(() => readPack(broken({ rank: 8 })), /'omega2' has not 8/);
  const triangles = Int32Array.from(model.arrays.triangles).fill(model.vertex_count, 5, 6);
  assert.throws(() => readPack(broken({ arrays: { ...model.arrays, triangles } })), /not there/);
});

test('a pack may be compressed', async () => {
  const bytes = writePack(pack);
  const textContent = gzipSync(bytes).toString('base64');
  const element = { textContent, dataset: { encoding: 'gzip' } };
  assert.deepEqual(Buffer.from(await bytesOfElement(element)), bytes);
  assert.equal(await bytesOfElement({ textContent: ' ', dataset: {} }), null);
});

test('the largest stress of a surface is that of the program at the nodes of the mesh', () => {
  const beam = 'beam:16x4x4@1x0.1x0.1';
  thrum('precompute', beam, '--order', '2', '--fix', 'x<1e-9', '--young', '5e6', '--poisson', '0.3', '--density', '1000',
    '--modes', '6', '--rank', '12', '-o', 'bent.npz');
  const [model] = packOf('bent.npz').models;
  const values = new SurfaceValues(model, smooth(model));
  for (const load of ['constant:0,0,-20@tip', 'constant:0,10,-10@tip', 'gravity:0,0,-9.81']) {
    const { q, stress } = JSON.parse(thrum('static', 'bent.npz', '--load', load, '--accept-error', '1', '--json'));
    assert.equal(stress.kind, 'nodes');
    const share = values.read('stress', Float32Array.from(q), 1, 1) / stress.peak_von_mises_pa;
    assert.ok(Math.abs(share - 1) < 0.03, `${load}: ${share}`);
  }
});
