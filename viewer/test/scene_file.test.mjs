// A scene file that is dropped with its models: the page makes of them what thrum view makes, to rounding.
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { before, test } from 'node:test';
import { packOfFiles } from '../src/drop.js';
import { Engine } from '../src/engine.js';
import { folder, packOf, stepped, thrum, wasmBytes } from './fixture.mjs';

const SCENE = {
  title: 'dropped', dt: 0.002, time: 0.2, gravity: [0, 0, -9.81], damping: 0.1, collide: false,
  bodies: [
    { name: 'arm', model: 'arm.npz', rotation: { axis: [0, 0, 2], angle: 30 }, rank: 9, colour: '#4a86c5' },
    { name: 'bar', model: 'models/bar.npz', free: true, coupled: true, spin: [0, 0, 400], position: [0, 1, 0], colour: [1, 0.5, 0] },
    { model: 'bar.npz', free: true, position: [0.4, 1, 0], scale: 1.2, density: 0.8, stiffness: 2, integrator: 'imexv' },
  ],
  links: [
    { name: 'joint', kind: 'hinge', body: 'bar', place: [0.4, 1, 0], other: 'body3', axis: [0, 0, 1] },
    { kind: 'spring', body: 'bar', at: 'vertex=2', other_place: [0, 1, 1], stiffness: 100, damping: 1, until: 0.1 },
    { kind: 'ball', body: 'arm', at: 'tip', path: [{ time: 0, place: [0, 0, 0] }, { time: 0.1, place: [0, 0.01, 0] }] },
  ],
  obstacles: [{ shape: 'plane', centre: [0, 0, -5] }, { shape: 'box', centre: [0, 9, 0], size: [1, 1, 2], rotation: [2, 0, 0, 2] }],
  probes: [{ name: 'tip', body: 'arm', at: 'tip' }], outputs: { record_every: 1 },
};

before(() => {
  thrum('precompute', 'beam:8x2x2@0.8x0.1x0.1', '--fix', 'x<0.001', '--modes', '5', '--rank', '12', '-o', 'arm.npz', '--quiet');
  thrum('precompute', 'beam:4x2x2@0.4x0.1x0.1', '--modes', '4', '--rank', '8', '-o', 'bar.npz', '--quiet');
});

/** A file of the folder, or of a text, as a browser hands it over. */
const file = (name, text) => {
  const bytes = text === undefined ? readFileSync(join(folder, name)) : Buffer.from(text);
  return { name, arrayBuffer: async () => bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length) };
};

/** What the page makes of a scene and files beside it. */
async function dropped(scene, beside = ['arm.npz', 'bar.npz'], shown = { models: [] }) {
  const text = typeof scene === 'string' ? scene : JSON.stringify(scene);
  return packOfFiles([file('scene.json', text), ...beside.map((name) => file(name))], await Engine.load(wasmBytes()), shown);
}

/** Numbers are those wanted, but for the rounding of rotations. */
function assertClose(got, wanted, within, what) {
  assert.equal(got?.length, wanted?.length, what);
  if (wanted === undefined) return;
  const size = Math.max(...wanted.map(Math.abs));
  got.forEach((x, i) => assert.ok(Math.abs(x - wanted[i]) <= within * size, `${what}: ${x}, not ${wanted[i]}`));
}

test('a scene that is dropped is that of thrum view, and moves so', async () => {
  writeFileSync(join(folder, 'same.json'), JSON.stringify({ ...SCENE,
    bodies: SCENE.bodies.map((body) => ({ ...body, model: body.model.replace('models/', '') })) }));
  const wanted = packOf('same.json');
  const pack = await dropped(SCENE);
  assert.equal(pack.models.length, 3); // of three names
  const of = ({ name, colour, free, coupled, rank, spin, velocity, scale }) => ({ name, colour, free, coupled, rank, spin, velocity, scale });
  assert.deepEqual(pack.scene.bodies.map(of), wanted.scene.bodies.map(of));
  pack.scene.links.forEach((link, n) => {
    for (const key of ['kind', 'body', 'other', 'until', 'times', 'places']) assert.deepEqual(link[key], wanted.scene.links[n][key], key);
    for (const key of ['place', 'other_place', 'rest', 'rows', 'other_rest', 'other_rows'])
      assertClose(link[key], wanted.scene.links[n][key], 1e-13, key);
    assertClose([link.length], [wanted.scene.links[n].length], 1e-13, 'length');
  });
  const [one, other] = [await stepped(pack, pack.scene, 100), await stepped(wanted, wanted.scene, 100)];
  for (let n = 0; n < 3; n++) assertClose(one.coordinates(n), other.coordinates(n), 1e-9, `body ${n}`);
  assert.equal(one.link(1).holds, false);
});

test('models that the page shows already need not be dropped again, but for their meshes', async () => {
  const shown = packOf('arm.npz');
  const plain = { bodies: [{ model: 'arm.npz' }, { model: 'arm', position: [0, 1, 0] }] };
  const pack = await dropped(plain, [], shown);
  assert.deepEqual(pack.scene.bodies.map(({ model }) => pack.models[model].rank), [12, 12]);
  await assert.rejects(dropped({ ...plain, links: [{ kind: 'ball', body: 'body1', at: 'tip' }] }, [], shown),
    /only the surface of "body1".*thrum view scene.json/);
});

test('bodies of a scene that is dropped touch each other and obstacles', async () => {
  const { scene } = await dropped({ bodies: [{ model: 'bar.npz', free: true }, { model: 'bar.npz', free: true, collide: false, position: [0, 0, 1] }],
    collisions: { friction: 0.2 }, wind: { velocity: [1, 0, 0] } });
  assert.deepEqual(scene.collisions, { thickness: 0, friction: 0.2, restitution: 0.5, touches: 2048 });
  assert.deepEqual(scene.bodies.map(({ collide }) => collide), [true, false]);
  assert.deepEqual(scene.wind, { velocity: [1, 0, 0], density: 1.2, drag: 1 });
});

test('a body of a scene that is dropped may touch itself', async () => {
  const pack = await dropped({ bodies: [{ model: 'bar.npz', free: true, self_contact: true }] });
  assert.deepEqual([pack.scene.bodies[0].self_contact, pack.scene.collisions.touches], [true, 1024]);
  await stepped(pack, pack.scene, 2);
});

test('the coordinates that follow in a file stay where it is dropped with a scene', async () => {
  thrum('precompute', 'beam:4x2x2@0.4x0.1x0.1', '--modes', '4', '--rank', '8', '--condense', '-o', 'few.npz', '--quiet');
  const pack = await dropped({ bodies: [{ model: 'few.npz', free: true, condense: 3 }] }, ['few.npz']);
  const engine = await stepped(pack, pack.scene, 1);
  assert.equal(engine.report(0).rank, 3);
  await assert.rejects(dropped({ bodies: [{ model: 'few.npz', free: true, rank: 3 }] }, ['few.npz']), /"rank": .*"condense" of 1 to 4/);
});

test('what the page cannot make of a scene is refused with the command', async () => {
  const [arm, bar] = SCENE.bodies;
  for (const [scene, words, beside] of [
    ['{"bodies": [', /scene.json: .*JSON/i], ['[]', /"scene"/], [{}, /"bodies" of scene is missing/],
    [{ bodies: [{}] }, /"model" of bodies is missing/], [{ bodies: [{ ...arm, loads: 'gravity:0,0,1' }] }, /"loads"/],
    [{ bodies: [{ ...arm, model: 'beam:8x2x2@1x1x1' }] }, /meshed and precomputed/], [{ bodies: [arm] }, /drop arm.npz/, []],
    [{ bodies: [{ ...arm, scale: '2' }] }, /"scale" of bodies is not a number/], [{ bodies: [arm], obstacles: [{ shape: 'mesh' }] }, /"shape"/],
    [{ bodies: [arm], links: [{ kind: 'ball', body: 'leg' }] }, /"leg"/], [{ bodies: [arm], links: [{ kind: 'ball', body: 'arm', at: 'nose' }] }, /nose/],
    [{ bodies: [{ ...arm, free: true }] }, /nothing holds/], [{ bodies: [{ ...bar, integrator: 'imexv' }] }, /energy/],
    [{ bodies: [arm], dt: -1 }, /time step/], [{ bodies: [] }, /bodies/], [{ bodies: [arm], toString: 1 }, /"toString"/],
  ])
    await assert.rejects(dropped(scene, beside), (error) => {
      assert.match(error.message, words);
      assert.match(error.message, /^scene.json: .*thrum view scene.json$/s);
      return true;
    });
});
