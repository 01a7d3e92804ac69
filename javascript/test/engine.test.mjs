// Models, states, batches and scenes in WebAssembly. SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { before, test } from 'node:test';
import { Status, ThrumError, load } from '../dist/inline.js';
import { beamBytes, blockBytes, folder, modelBytes, thrum } from './fixture.mjs';

const RANK = 12;
let engine, beam, block, bytes;

before(async () => {
  engine = await load();
  bytes = beamBytes();
  beam = engine.model(bytes);
  block = engine.model(blockBytes());
});

/** A state whose tip is 0.1 m off, or as far as is told. */
function struck(options, far = 0.1) {
  const state = beam.state(options);
  state.set(beam.start(0, far));
  return state;
}

/** The last row of a .npy of doubles in C order. */
function lastRow(path, columns) {
  const data = readFileSync(path);
  return Array.from({ length: columns }, (_, i) => data.readDoubleLE(data.length - 8 * (columns - i)));
}

test('a model says what is in it', () => {
  assert.equal(beam.rank, RANK);
  assert.equal(beam.vertices.length, 3 * beam.vertexCount);
  assert.equal(beam.basis.length, 3 * beam.vertexCount * RANK);
  assert.deepEqual([...beam.material], [5e6, 0.4, 1000]);
  assert.deepEqual(beam.laws, ['stvk']);
  assert.ok(beam.groups.tip.length > 0);
  assert.equal(beam.meta.tool, 'thrum');
  // the first bending frequency of the program's own table, to what the basis changes in it
  const report = JSON.parse(thrum('info', 'beam.npz', '--json'));
  assert.ok(Math.abs(beam.frequencies[0] / report.frequencies_hz[0] - 1) < 1e-5);
});

test('the types name the integrators of the library', () => {
  const types = readFileSync(new URL('../src/index.d.ts', import.meta.url), 'utf8');
  const [, union] = types.match(/type Integrator =([^;]*);/);
  assert.deepEqual(union.match(/[a-z0-9-]+/g), engine.integrators);
});

// so far that the program takes the run for sound: from 0.1 m the basis is short for energy, newmark gains energy,
// and imexv goes over to energy on the way
for (const [integrator, far] of [['energy', 0.05], ['imexv', 0.1], ['newmark', 0.05]])
  test(`${integrator}: steps have the bits of the program`, () => {
    thrum('simulate', 'beam.npz', '-o', integrator, '--integrator', integrator, '--time', '0.3', '--start',
      `mode:1,${far}`);
    const state = struck({ integrator }, far);
    state.step(100);
    assert.deepEqual([...state.q], lastRow(join(folder, integrator, 'q.npy'), RANK));
  });

test('energy keeps the energy', () => {
  const state = struck();
  const { total } = state.energies;
  assert.equal(state.step(2000), Status.OK);
  assert.ok(Math.abs(state.energies.total / total - 1) < 1e-12);
  assert.equal(state.report.steps, 2000);
  assert.equal(state.report.scheme, 'energy');
});

test('under a load the damped beam comes to rest at its equilibrium', () => {
  const state = beam.state({ dampingAlpha: 20 });
  const weight = beam.externalLoad({ gravity: [0, 0, -9.81] });
  state.setForce(weight);
  state.step(2000);
  const rest = beam.equilibrium(weight);
  assert.ok(rest.stable);
  state.q.forEach((value, i) => assert.ok(Math.abs(value - rest.q[i]) < 1e-8));
  assert.ok(Math.max(...beam.vonMises(rest.q)) > 1000);
});

test('stress at nodes is that of the program, and larger at the surface than at centres', () => {
  const bar = engine.model(modelBytes('bar', 'beam:6x2x2@1x0.15x0.15', '--order', '2', '--fix', 'x<0.001', '--modes', '4', '--rank', '8'));
  const answer = JSON.parse(thrum('static', 'bar.npz', '--load', 'constant:0,0,-20@tip', '--accept-error', '1', '--json'));
  const nodes = bar.stressNodes();
  assert.deepEqual([nodes.count, nodes.extrapolated], [bar.vertexCount, true]);
  const { cauchy, vonMises } = nodes.read(answer.q);
  const peak = Math.max(...vonMises);
  const at = vonMises.indexOf(peak);
  assert.equal(peak, answer.stress.peak_von_mises_pa);
  assert.equal(nodes.vertices[at] + 1, answer.stress.peak_vertex);
  assert.equal(nodes.regions[at] + 1, answer.stress.peak_region);
  assert.ok(peak > 1.1 * Math.max(...bar.vonMises(answer.q)));

  // von Mises' of the tensor, and what is not read
  const [xx, yy, zz, xy, yz, xz] = cauchy.slice(6 * at, 6 * at + 6);
  const square = ((xx - yy) ** 2 + (yy - zz) ** 2 + (zz - xx) ** 2) / 2 + 3 * (xy ** 2 + yz ** 2 + xz ** 2);
  assert.ok(Math.abs(Math.sqrt(square) / peak - 1) < 1e-12);
  assert.ok(nodes.read(new Float64Array(8)).vonMises.every((stress) => stress === 0));
  assert.throws(() => nodes.read([0]), /not 8/);
  assert.equal(beam.stressNodes().extrapolated, false);

  // the model stays as long as its nodes do
  bar.free();
  assert.equal(Math.max(...nodes.read(answer.q).vonMises), peak);
  nodes.free();
  assert.throws(() => nodes.read(answer.q), /freed/);
});

test('a snapshot continues with the same bits, a changed one is refused', () => {
  const state = struck({ integrator: 'imexv' });
  state.step(20);
  const kept = state.snapshot();
  state.step(20);
  const end = state.q;
  state.restore(kept);
  state.step(20);
  assert.deepEqual(state.q, end);
  kept[kept.length - 1] ^= 1;
  assert.throws(() => state.restore(kept), ThrumError);
});

test('gradients of runs agree with differences', () => {
  const steps = 40;
  const at = { dt: 0.002, dampingAlpha: 0.4, tolerance: 1e-13, q: beam.start(0, 0.05) };
  const push = beam.externalLoad({ force: [0, 0, -5], group: 'tip' });
  const run = (by) => ({ ...at, q: at.q.map((q) => (1 + by) * q), dampingAlpha: at.dampingAlpha + by,
    force: Float64Array.from({ length: steps * RANK }, (_, n) => (1 + by) * push[n % RANK]) });
  const loss = (q) => ({ value: q.reduce((sum, one) => sum + one * one, 0), q: q.map((one) => 2 * one) });
  const [{ gradient: g }, high, low] = beam.valueAndGradient(loss, steps, [run(0), run(1e-5), run(-1e-5)]);
  const dot = (a, b) => a.reduce((sum, one, n) => sum + one * b[n], 0);
  const found = dot(g.q, at.q) + g.alpha + dot(g.force, run(0).force);
  assert.ok(Math.abs((high.value - low.value) / 2e-5 / found - 1) < 1e-7);

  // a run has the bits of a state
  const state = beam.state({ dt: 0.002 });
  state.set(at.q);
  state.step(steps);
  assert.deepEqual(beam.rollout(steps, { dt: 0.002, q: at.q }).q.slice(-RANK), state.q);
  assert.throws(() => beam.rollout(3, { integrator: 'imexv' }), /imexv/);
});

test('a batch has the bits of single steps', () => {
  const states = Array.from({ length: 10 }, () => struck());
  const batch = beam.batch(states);
  assert.deepEqual([...batch.step(30)], Array(10).fill(0));
  const alone = struck();
  alone.step(30);
  for (const state of states) assert.deepEqual(state.q, alone.q);
  assert.throws(() => beam.batch([alone, alone]), ThrumError);
});

test('condensed and scaled models', () => {
  const condensed = beam.condense(4);
  assert.deepEqual([condensed.rank, condensed.shown], [4, RANK]);
  assert.equal(condensed.shape(new Float64Array(4)).length, RANK);
  assert.deepEqual([beam.truncate(5).rank, beam.truncate(5).shown], [5, RANK]);
  assert.equal(beam.truncate(RANK), beam);
  const long = beam.scale({ length: 2 });
  assert.ok(Math.abs((2 * long.frequencies[0]) / beam.frequencies[0] - 1) < 1e-14);
});

test('surfaces give three.js its arrays', () => {
  const triangles = beam.outerTriangles();
  const surface = beam.surface({ triangles });
  const out = new Float32Array(3 * surface.vertexCount);
  const q = beam.start(0, 0.1);
  assert.equal(surface.positions(q, out), out);
  const moved = beam.displacement(q);
  beam.vertices.forEach((rest, i) => assert.ok(Math.abs(out[i] - rest - moved[i]) < 1e-6));
  assert.equal(surface.normals(out).length, out.length);
  assert.throws(() => surface.positions(q, new Float32Array(3)), ThrumError);
});

test('a free body falls by g t^2 / 2', () => {
  const scene = engine.scene({ dt: 0.001, gravity: [0, 0, -9.81] });
  const body = scene.addBody(block, { free: true, position: [0, 0, 10] });
  const start = body.matrix[14];
  scene.step(1000);
  assert.ok(Math.abs(start - body.matrix[14] - 0.5 * 9.81) < 1e-9);
});

test('a coupled body that spins stretches and keeps its energy', () => {
  const scene = engine.scene({ dt: 0.002 });
  const body = scene.addBody(block, { free: true, coupled: true, spin: [3, 40, 5], stiffness: 0.01 });
  const before = body.energies;
  scene.step(500);
  assert.ok(body.energies.potential > 0);
  assert.ok(Math.abs(body.energies.total / before.total - 1) < 1e-12);
  assert.throws(() => scene.addBody(block, { coupled: true }), ThrumError);
});

test('fewer coordinates do not lock a body: the others follow', () => {
  const tip = beam.groups.tip[0];
  const furthest = (given) => {
    const scene = engine.scene({ dt: 0.002 });
    const body = scene.addBody(beam, given);
    body.addLoad({ force: [0, 0, -140], group: 'tip' });
    let far = 0;
    for (let i = 0; i < 150; i += 1) {
      scene.step();
      far = Math.max(far, Math.abs(body.vertex(tip).position[2] - beam.vertices[3 * tip + 2]));
    }
    return far;
  };
  const whole = furthest({});
  assert.ok(whole > 0.1);
  for (const rank of [RANK / 2, RANK / 3]) {
    assert.ok(Math.abs(furthest({ rank }) / whole - 1) < 0.03);
  }
});

test('contact, loads and pulls in a scene', () => {
  const scene = engine.scene({ gravity: [0, 0, -9.81] });
  const triangles = beam.outerTriangles();
  const body = scene.addBody(beam, { triangles, touch: 'all', dampingAlpha: 0.5 });
  scene.addObstacle({ centre: [0, 0, -0.05] });
  body.addLoad({ force: [0, 0, -20], group: 'tip', until: 0.3 });
  scene.setWind([0, 5, 0]);
  let touched = 0;
  for (let i = 0; i < 300; i += 1) {
    scene.step();
    touched += body.info.touching > 0 ? 1 : 0;
  }
  assert.ok(touched > 0);
  const tip = beam.groups.tip[0];
  const pull = body.pull(tip, [1, 0, 0.5], { stiffness: 300 });
  scene.step(30);
  assert.ok(pull.force[2] > 0);
  pull.end();
  const kept = scene.snapshot();
  scene.step(10);
  const end = body.q;
  scene.restore(kept);
  scene.step(10);
  assert.deepEqual(body.q, end);
  assert.ok(Number.isFinite(body.energies.total));
});

test('solids of all shapes hold a body up', () => {
  const corners = [-0.1, 0].flatMap((z) => [-1, 1].flatMap((y) => [-1, 1].flatMap((x) => [x, y, z])));
  const faces = [0, 2, 1, 1, 2, 3, 4, 5, 6, 5, 7, 6, 0, 1, 4, 1, 5, 4, 2, 6, 3, 3, 6, 7, 0, 4, 2, 2, 4, 6, 1, 3, 5, 3, 7, 5];
  const solids = [{ shape: 'box', half: [1, 1, 0.1], position: [0, 0, -0.1] }, { shape: 'cylinder', radius: 1, height: 0.2, position: [0, 0, -0.1] },
    { shape: 'capsule', radius: 0.5, height: 1, position: [0, 0, -1] }, { shape: 'height_field', heights: [[0, 0, 0], [0, 0, 0]], spacing: [2, 2] },
    { shape: 'mesh', vertices: corners, triangles: faces }];
  for (const solid of solids) {
    const scene = engine.scene({ dt: 0.002, gravity: [0, 0, -9.81] });
    assert.equal(scene.addSolid(solid), 0);
    const body = scene.addBody(block, { free: true, triangles: block.outerTriangles(), position: [0, 0, 0.11] });
    scene.step(150);
    assert.ok(body.matrix[14] > 0.05, solid.shape);
  }
});

test('what is wrong with a field is said by its name', () => {
  const scene = engine.scene();
  for (const [wrong, call] of [[{ scale: -1 }, (options) => scene.addBody(block, options)], [{ segments: 2 }, (options) => scene.addSolid(options)],
    [{ restitution: 1.5 }, (options) => scene.setCollisions(options)], [{ friction: -1 }, (options) => scene.addObstacle(options)]]) {
    const [name] = Object.keys(wrong);
    assert.throws(() => call(wrong), new RegExp(`^ThrumError: ${name} is `), name);
    assert.throws(() => call({ [`${name}s`]: 1 }), new RegExp(`no option '${name}s'`));
  }
});

test('a ramp pushes half as much as its end', () => {
  const pushed = (load) => {
    const scene = engine.scene({ dt: 0.001 });
    const body = scene.addBody(block, { free: true });
    body.addLoad({ force: [0, 0, 10], until: 1, ...load });
    scene.step(1000);
    return scene.account.momentum[2];
  };
  assert.ok(Math.abs(pushed({ ramp: true }) / pushed({}) - 0.5) < 1e-3);
});

test('bodies touch each other, and keep their momentum', () => {
  const scene = engine.scene({ dt: 0.002 });
  const triangles = block.outerTriangles();
  scene.addBody(block, { free: true, triangles });
  scene.addBody(block, { free: true, triangles, position: [0, 0, 0.24], velocity: [0, 0, -1] });
  scene.setCollisions({ friction: 0.3 });
  assert.equal(scene.findOverlap(), undefined);
  const before = scene.account;
  scene.step(100);
  const after = scene.account;
  assert.ok(scene.collisions.lost > 0 && scene.collisions.deepestShare < 1);
  assert.ok(Math.abs(after.momentum[2] / before.momentum[2] - 1) < 1e-12);
  assert.ok(after.total < before.total);
  assert.throws(() => scene.setCollisions({ bounce: 1 }), /thickness/);
  assert.throws(() => scene.setCollisions({ restitution: 2 }), ThrumError);
  scene.setCollisions(false);
  assert.equal(scene.collisions.touching, 0);

  // a body that touches itself needs its triangles
  scene.addBody(block, { free: true, triangles, selfContact: true, position: [0, 0, 9] });
  scene.step();
  assert.equal(scene.collisions.touching, 0);
  assert.throws(() => scene.addBody(block, { free: true, selfContact: true }), /triangles/);
});

test('joints keep bodies together, springs give back what they took, and links let go', () => {
  const scene = engine.scene({ dt: 0.002 });
  const first = scene.addBody(block, { free: true, velocity: [1, 0, 0] });
  const second = scene.addBody(block, { free: true, position: [0.4, 0, 0], velocity: [0, 1, 0] });
  const hinge = scene.addLink({ kind: 'hinge', body: first, place: [0.3, 0.1, 0], other: second, axis: [0, 1, 0] });
  const spring = scene.addLink({ kind: 'spring', body: first, vertices: [0], other: second, otherVertices: [0],
    stiffness: 5e3, damping: 3 });
  assert.ok(Math.abs(spring.length - 0.4) < 1e-12);
  scene.step(20);
  const taken = () => scene.links.reduce((sum, { report }) => sum + report.lost - report.driven, 0);
  const before = scene.account;
  const balance = before.total + taken();
  scene.step(200);
  const after = scene.account;
  assert.deepEqual([hinge.kind, hinge.holds, spring.kind], ['hinge', true, 'spring']);
  assert.deepEqual(hinge.bodies, [first, second]);
  assert.ok(hinge.report.largestDrift < 1e-12);
  assert.ok(spring.report.lost > 0 && hinge.force.some((f) => f !== 0));
  assert.ok(Math.abs(after.links - spring.report.stored) <= 1e-12 * (1 + after.links));
  assert.ok(Math.abs(after.total + taken() - balance) <= 1e-9 * balance);
  after.momentum.forEach((p, axis) => assert.ok(Math.abs(p - before.momentum[axis]) < 1e-9));
  hinge.release();
  scene.step(50);
  assert.equal(hinge.holds, false);
  const [one, other] = hinge.places;
  assert.ok(Math.hypot(...one.map((x, axis) => x - other[axis])) > 1e-6);
});

test('a handle goes along its path and lets go at its time', () => {
  const scene = engine.scene({ dt: 0.002 });
  const body = scene.addBody(beam, { dampingAlpha: 1 });
  const handle = scene.addLink({ kind: 'ball', body, group: 'tip', until: 0.5, pathTimes: [0, 0.3],
    pathPlaces: [0, 0, 0, 0, 0, 0.05] });
  const [[, , height]] = handle.places;
  scene.step(200);
  assert.ok(Math.abs(handle.places[0][2] - height - 0.05) < 1e-9);
  assert.ok(handle.report.driven > 0);
  assert.deepEqual(handle.bodies, [body, undefined]);
  scene.step(200);
  assert.equal(handle.holds, false);
});

test('a scene of links has the bits of the program', () => {
  const bodies = [{ name: 'upper', model: 'block.npz', free: true }, { name: 'lower', model: 'block.npz', free: true, position: [0.2, 0, 0] }];
  const links = [{ kind: 'hinge', body: 'upper', place: [0, 0.1, 0.1], axis: [0, 1, 0] },
    { kind: 'ball', body: 'upper', place: [0.2, 0.1, 0.1], other: 'lower', until: 0.3 }];
  writeFileSync(join(folder, 'linked.json'), JSON.stringify({ dt: 0.002, time: 0.5, gravity: [0, 0, -9.81],
    bodies: bodies.map((body) => ({ ...body, collide: false })), links, outputs: { record_every: 1 } }));
  thrum('simulate', 'linked.json', '-o', 'linked', '--quiet');
  const scene = engine.scene({ dt: 0.002, gravity: [0, 0, -9.81] });
  const [upper, lower] = bodies.map(({ position = [0, 0, 0] }) => scene.addBody(block, { free: true, position }));
  scene.addLink({ ...links[0], body: upper });
  scene.addLink({ ...links[1], body: upper, other: lower });
  scene.step(250);
  assert.deepEqual([...upper.q], lastRow(join(folder, 'linked/upper/q.npy'), 6));
  assert.deepEqual([...lower.q], lastRow(join(folder, 'linked/lower/q.npy'), 6));
});

test('a link that cannot be is refused by name', () => {
  const scene = engine.scene();
  const body = scene.addBody(block, { free: true });
  const stranger = engine.scene().addBody(block, { free: true });
  const wrong = [{ kind: 'rope' }, { body: stranger }, { other: body }, { otherVertices: [0] }, { pathTimes: [0] },
    { pathTimes: [0, 1], pathPlaces: [0, 0, 0] }, { length: -1 }, { axis: [0, 0, 0] }, { stiffness: NaN }, { spring: 3 }];
  for (const change of wrong)
    assert.throws(() => scene.addLink({ kind: 'spring', body, ...change }), ThrumError);
  assert.deepEqual(scene.links, []);
});

test('a body far from the eye steps fewer coordinates, and all again when it is near', () => {
  const scene = engine.scene();
  const body = scene.addBody(beam);
  body.setDetail({ masters: 4, jump: 0.01, beyond: 5 });
  scene.setEye([0, 0, 10]);
  scene.updateDetail();
  scene.step(10);
  assert.deepEqual([body.info.rank, body.detail.reduced, body.detail.reducedSteps], [4, true, 10]);
  scene.setEye([0, 0, 1]);
  scene.updateDetail();
  assert.deepEqual([body.info.rank, body.detail.reduced, body.detail.changes], [RANK, false, 2]);
  assert.throws(() => body.setDetail({ masters: 4 }), ThrumError);
  assert.throws(() => body.setDetail({ far: 4 }), /beyond/);
});

test('what is wrong is refused by name', () => {
  assert.throws(() => engine.model(new Uint8Array(10)), ThrumError);
  assert.throws(() => engine.model(), ThrumError);
  const changed = Uint8Array.from(bytes);
  changed[changed.length >> 1] ^= 1;
  assert.throws(() => engine.model(changed), /checksum|CRC/i);
  assert.throws(() => beam.state({ integrator: 'euler' }), /newmark/);
  assert.throws(() => beam.state({ timestep: 1 }), /dampingAlpha/);
  assert.throws(() => beam.state({ dt: 0 }), /dt/);
  assert.throws(() => beam.externalLoad({ force: [1, 2, 3], group: 'nose' }), /tip/);
  assert.throws(() => beam.state().set([1, 2]), /12/);
  assert.throws(() => beam.state().set(Array(RANK).fill(NaN)), ThrumError);
  for (const thing of [beam.state(), beam.batch([beam.state()]), engine.scene()]) {
    for (const count of [1.5, -1, NaN, Infinity, '2', null])
      assert.throws(() => thing.step(count), /is no number of steps/);
    for (const count of [1e7 + 1, 1e12])
      assert.throws(() => thing.step(count), /more than the 10000000 of one call/);
  }
  const scene = engine.scene();
  assert.throws(() => scene.addBody(beam, { free: true }), ThrumError);
  assert.throws(() => scene.addBody(beam, { touch: 'all' }), /triangles/);
  assert.throws(() => scene.addObstacle({ shape: 'cone' }), /sphere/);
  assert.throws(() => engine.scene({ dt: -1 }), ThrumError);
  assert.equal(scene.bodies.length, 0);
});

test('an array of the wrong length is refused before it is copied', () => {
  const endless = { *[Symbol.iterator]() { for (;;) yield 0; } };
  for (const q of [{ length: 1e9 }, { length: 2 ** 40 }, endless, [], Array(RANK + 1).fill(0)])
    assert.throws(() => beam.displacement(q), new RegExp(`not ${RANK}`));
  for (const chosen of [{ length: 1e9 }, { length: NaN }, []])
    assert.throws(() => beam.surface({ vertices: chosen }), /no vertex/);
  assert.throws(() => beam.state().restore({ length: 1e9 }), /Uint8Array/);
  assert.throws(() => engine.scene().restore([1, 2]), /Uint8Array/);
  assert.deepEqual(beam.displacement(new Set(Array(RANK).keys())), beam.displacement(Array.from(Array(RANK).keys())));
});

test('no number but a finite one goes in or comes out', () => {
  for (const wrong of [NaN, Infinity, undefined, 'x']) {
    const q = Array(RANK).fill(0);
    q[3] = wrong;
    for (const call of [() => beam.displacement(q), () => beam.vonMises(q), () => beam.equilibrium(q),
      () => beam.surface().positions(q), () => beam.state().setForce(q)])
      assert.throws(call, /number 3/);
  }
  assert.throws(() => beam.displacement(Array(RANK).fill(1e308)), ThrumError);
});

test('a surface of another model is refused', () => {
  const scene = engine.scene();
  const body = scene.addBody(beam);
  for (const other of [beam.scale({ stiffness: 2 }), block])
    assert.throws(() => body.positions(other.surface()), /another model/);
  assert.equal(body.positions(engine.model(bytes).surface()).length, 3 * beam.vertexCount);
});

test('things are freed in any order', () => {
  for (const first of ['model', 'state', 'scene']) {
    const model = engine.model(bytes);
    const things = { model, state: model.truncate(5).state(), scene: engine.scene() };
    things.scene.addBody(model);
    things[first].free();
    for (const [name, thing] of Object.entries(things))
      if (name !== first && name !== 'model') thing.step(5);
    for (const thing of Object.values(things)) thing.free();
    assert.throws(() => things.state.step(), /freed/);
  }
  // memory that was freed is used again: a thousand models do not fill it
  for (let i = 0; i < 1000; i += 1) {
    const model = engine.model(bytes);
    const state = model.state();
    model.free();
    state.step();
    state.free();
  }
});
