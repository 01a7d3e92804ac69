// A scene file that is dropped with its models: the page makes of them what thrum view makes, to rounding.
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { spawnSync } from 'node:child_process';
import { readFileSync, readdirSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { before, test } from 'node:test';
import { packOfFiles } from '../src/drop.js';
import { Engine } from '../src/engine.js';
import { keysOf } from '../src/scene_keys.js';
import { folder, packOf, stepped, thrum, wasmBytes } from './fixture.mjs';

const SCENE = {
  title: 'dropped', dt: 0.002, time: 0.2, gravity: [0, 0, -9.81], damping: 0.1, collide: false,
  bodies: [
    { name: 'arm', model: 'arm.npz', rotation: { axis: [0, 0, 2], angle: 30 }, colour: '#4a86c5' },
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
  thrum('precompute', 'beam:8x2x2@0.8x0.1x0.1,split=6', '--order', '1', '--fix', 'x<0.001', '--modes', '5', '--rank', '12', '-o', 'arm.npz', '--quiet');
  thrum('precompute', 'beam:4x2x2@0.4x0.1x0.1,split=6', '--order', '1', '--modes', '4', '--rank', '8', '-o', 'bar.npz', '--quiet');
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
    /only the surface of "body1".*thrum view scene.json -o scene.html/);
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
  thrum('precompute', 'beam:4x2x2@0.4x0.1x0.1,split=6', '--order', '1', '--modes', '4', '--rank', '8', '--condense', '-o', 'few.npz', '--quiet');
  const pack = await dropped({ bodies: [{ model: 'few.npz', free: true, condense: 3 }] }, ['few.npz']);
  const engine = await stepped(pack, pack.scene, 1);
  assert.equal(engine.report(0).rank, 3);
  await assert.rejects(dropped({ bodies: [{ model: 'few.npz', free: true, rank: 3 }] }, ['few.npz']), /bodies\[0\].rank: .*"condense" of 1 to 4/);
});

/** The table that the program reads scene files by, as its JSON schema says it. */
const schema = () => JSON.parse(thrum('schema', 'scene'));

/** What a text of JSON says, else the text. */
function parsed(text) {
  try {
    return JSON.parse(text);
  } catch {
    return text;
  }
}

test('the page knows every key of a scene file, with the bounds and what holds without it', async () => {
  const KEYS = keysOf((await Engine.load(wasmBytes())).memory);
  const { properties, required } = schema();
  const parts = { scene: { properties, required }, wind: properties.wind, collisions: properties.collisions };
  for (const name of ['bodies', 'obstacles', 'links']) parts[name] = properties[name].items;
  for (const name of ['obstacles', 'links']) parts[`${name}.path`] = parts[name].properties.path.items;
  assert.deepEqual(Object.keys(KEYS).sort(), Object.keys(parts).sort());
  for (const [where, part] of Object.entries(parts)) {
    assert.deepEqual(Object.keys(KEYS[where]).sort(), Object.keys(part.properties).sort(), where);
    for (const [key, { is, needed = false, unread, fallback }] of Object.entries(KEYS[where])) {
      if (unread || (!is.wants && !needed)) continue; // what is passed over has no value
      const { description, default: _, ...given } = part.properties[key];
      assert.equal(needed, part.required?.includes(key) ?? false, `${where}: ${key}`);
      for (const bound of ['minimum', 'exclusiveMinimum', 'maximum'])
        assert.equal(is[bound], given[bound], `${where}: ${bound} of ${key}`);
      if (is.names) assert.deepEqual([...is.names].sort(), [...given.enum].sort(), key);

      // what the program says in JSON; a rotation is none, a start is at rest, and bodies take the solver of their scene
      const told = /; default (.*)$/.exec(description)?.[1];
      if (['rotation', 'start', 'base_motion'].includes(key) || (where === 'bodies' && ['integrator', 'damping'].includes(key))) continue;
      const value = parsed(told);
      if (fallback !== undefined) assert.deepEqual(fallback, value, `${where}: ${key}`);
      else assert.ok(value === undefined || value === told, `${where}: ${key} is ${told} where it is left out`);
    }
  }
});

const BAR = { name: 'a', model: 'bar.npz', free: true, position: [0, 0, 2] };

/** What thrum view packs of a scene. */
function packed(scene, name = 'given.json') {
  writeFileSync(join(folder, name), JSON.stringify(scene));
  return packOf(name).scene;
}

test('obstacles of all shapes that say the least are those of thrum view', async () => {
  const turned = { axis: [0, 0, 2], angle: 300 };
  const scene = { gravity: [0, 0, -9.81], bodies: [BAR], obstacles: [{ shape: 'plane' }, { shape: 'sphere', radius: 0.3 },
    { shape: 'box', size: [1, 1, 1] }, { shape: 'box', size: [9, 9, 9], inside: true }, { shape: 'cylinder', radius: 0.2, height: 0.4 },
    { shape: 'capsule', radius: 0.2, height: 0, rotation: { axis: [1, 0, 0], angle: 90 }, colour: [1, 0, 0.5] },
    { shape: 'height_field', spacing: 0.5, heights: [[0, 0.1, 0], [0.1, 0, 0.1]], centre: [0, 0, 0.1], velocity: [0.1, 0, 0] },
    { shape: 'box', size: [0.1, 0.1, 0.1], path: [{ time: 0, centre: [5, 0, 0] }, { time: 1, centre: [5, 0, 1], rotation: turned }] }] };
  const wanted = packed(scene);
  const pack = await dropped(scene, ['bar.npz']);
  wanted.obstacles.forEach((obstacle, n) => {
    for (const [key, value] of Object.entries(obstacle)) {
      const got = pack.scene.obstacles[n][key];
      if (Array.isArray(value)) assertClose([...got, 1], [...value, 1], 1e-12, `${n}: ${key}`);
      else assert.deepEqual(got, value, `${n}: ${key}`);
    }
  });

  // the way of the last one, which turns by more than half a turn, has places between
  const { times, places } = pack.scene.obstacles.at(-1);
  assertClose(times, [0, 1 / 3, 2 / 3, 1], 1e-12, 'times');
  assertClose(places.slice(7, 14), [5, 0, 1 / 3, Math.cos(Math.PI * 50 / 180), 0, 0, Math.sin(Math.PI * 50 / 180)], 1e-12, 'turned');
  await stepped(pack, pack.scene, 3);
});

test('a start in a mode, ground that shakes and a number of coordinates that the page need not find are read', async () => {
  const scene = { base_motion: 'sine:5,0,-1,f=2,until=3', wind: { velocity: [0, 12, 0] }, damping: [0.4, 0],
    bodies: [{ model: 'arm.npz', start: ['mode:2,0.01', 'mode:1,-0.02'], scale: 2, density: 3 },
      { model: 'arm.npz', position: [0, 3, 0] }] };
  const wanted = packed(scene);
  const bodies = scene.bodies.map((body) => ({ ...body, error: 0.05, budget: 1e-5 }));
  const pack = await dropped({ ...scene, bodies }, ['arm.npz']);
  assert.deepEqual(pack.scene.base_motion, wanted.base_motion);
  assert.deepEqual(pack.scene.wind, wanted.wind);
  assertClose(pack.scene.bodies[0].q, wanted.bodies[0].q, 1e-6, 'the start'); // of a basis in single precision
  assert.deepEqual(pack.scene.bodies.map(({ rank, damping }) => [rank, damping]), [[12, 0.4], [12, 0.4]]);
  await stepped(pack, pack.scene, 3);
});

test('models that come with thrum view are named without a file', async () => {
  const scene = { bodies: [{ model: 'tower' }] };
  await assert.rejects(dropped(scene, []),
    /bodies\[0\].model: "tower" is not in this page.*thrum view scene.json -o scene.html, then drop/);
  assert.equal((await dropped(scene, [], packOf('tower'))).models[0].name, 'tower');
});

test('the scenes of the examples are shown, or refused with what to do', async () => {
  const shown = packOf('beam', 'tower', 'horse');
  const examples = new URL('../../examples/scenes/', import.meta.url);
  const works = [];
  for (const name of readdirSync(examples).filter((file) => file.endsWith('.json'))) {
    const given = [file(name, readFileSync(new URL(name, examples)))];
    const page = name.replace('json', 'html');
    await Engine.load(wasmBytes()).then((engine) => packOfFiles(given, engine, shown)).then(() => works.push(name), ({ message }) => {
      assert.match(message, /bodies\[0\].model: "\S*" is a mesh|this page does not read/, name);
      assert.ok(message.endsWith(`thrum view ${name} -o ${page}, then drop ${page} here`), message);
    });
  }
  assert.deepEqual(works, ['crowd.json', 'quake.json']);
});

test('what is wrong with a scene is said as the program says it', async () => {
  const [arm] = SCENE.bodies;
  const obstacle = (of) => ({ bodies: [BAR], obstacles: [of] });
  const link = (of) => ({ bodies: [BAR, { ...BAR, name: 'b', position: [0, 0, 3] }],
    links: [{ kind: 'ball', body: 'a', place: [0, 0, 2], ...of }] });
  for (const scene of [{}, { bodies: [] }, { bodies: [{}] }, { bodies: [BAR], dt: -1 }, { bodies: [BAR], toString: 1 },
    obstacle({}), obstacle({ shape: 'ball' }), obstacle({ shape: 'plane', color: '#ffffff' }), { bodies: [BAR], wind: {} },
    obstacle({ shape: 'box' }), obstacle({ shape: 'sphere' }),
    obstacle({ shape: 'sphere', radius: -1 }), obstacle({ shape: 'cylinder', radius: 1 }), obstacle({ shape: 'capsule', height: 1 }),
    obstacle({ shape: 'cylinder', radius: 1, height: 0 }), obstacle({ shape: 'height_field', spacing: 1 }), obstacle({ shape: 'mesh' }),
    obstacle({ shape: 'plane', normal: [0, 0, 0] }), obstacle({ shape: 'plane', friction: -1 }), obstacle({ shape: 'plane', size: [1, 1, 1] }),
    obstacle({ shape: 'box', size: [1, 1, 1], stiffness: 1 }), obstacle({ shape: 'box', size: [1, 1, 1], inside: true, path: [] }),
    obstacle({ shape: 'box', size: [1, 1, 1], path: [{ time: 1, centre: [0, 0, 0] }, { time: 1, centre: [0, 0, 0] }] }),
    obstacle({ shape: 'box', size: [1, 0, 1] }), obstacle({ shape: 'sphere', radius: 1, centre: [0, 0, 2] }),
    obstacle({ shape: 'box', size: [1, 1, 1], centre: [0, 0, 2], name: 'crate' }),
    { bodies: [BAR, BAR] }, { bodies: [BAR, { ...BAR, name: 'b' }] }, { bodies: [BAR, { ...BAR, name: 'b', position: [0.02, 0, 2.02] }] },
    { bodies: [{ ...BAR, scale: '2' }] }, { bodies: [{ ...BAR, colour: 'red' }] }, { bodies: [{ ...arm, spin: [0, 0, 1] }] },
    link({ body: 'leg' }), link({ other: 'a' }), link({ place: undefined }), link({ stiffness: 1 }), link({ kind: 'spring' }),
    link({ axis: [0, 0, 1] })]) {
    writeFileSync(join(folder, 'scene.json'), JSON.stringify(scene));
    const said = spawnSync(process.env.THRUM_PROGRAM, ['simulate', 'scene.json', '-o', 'refused', '--time', '0.01', '--quiet'],
      { cwd: folder, encoding: 'utf8' });
    assert.notEqual(said.status, 0, JSON.stringify(scene));

    // the same line but for its number, units and numbers that it was given
    const [, wanted] = /^thrum: scene.json:1: (.*)/.exec(said.stderr);
    const bare = (line) => line.replace(/ (m|s|Pa)\b/g, '').replace(/,? not [[{"\d-].*$/, '')
      .replace(/; (its keys|did you mean).*$/, '').replace(/(is missing):.*$/, '$1');
    await assert.rejects(dropped(scene), ({ message }) => {
      assert.equal(bare(message.replace('scene.json: ', '')), bare(wanted));
      return true;
    }, JSON.stringify(scene));
  }
});

test('what the page does not read of a scene is refused with the command', async () => {
  const [arm, bar] = SCENE.bodies;
  for (const [scene, words, beside] of [
    [{ bodies: [{ ...arm, loads: 'gravity:0,0,1' }] }, /bodies\[0\].loads/], [{ bodies: [{ ...arm, model: 'beam:8x2x2@1x1x1' }] }, /is a mesh/],
    [{ bodies: [{ ...arm, start: 'static:gravity:0,0,1' }] }, /bodies\[0\].start/], [{ bodies: [arm], base_motion: 'quake.csv' }, /base_motion/],
    [{ bodies: [arm], obstacles: [{ shape: 'mesh', file: 'wedge.obj' }] }, /obstacles\[0\].file/], [{ bodies: [arm], tolerance: 1e-6 }, /tolerance/],
  ])
    await assert.rejects(dropped(scene, beside), (error) => {
      assert.match(error.message, words);
      assert.match(error.message, /^scene.json: .*: thrum view scene.json -o scene.html, then drop scene.html here$/s);
      return true;
    });
  for (const [scene, words, beside] of [['{"bodies": [', /scene.json: .*JSON/i], ['[]', /a scene/], [{ bodies: [arm] }, /drop arm.npz/, []],
    [{ bodies: [arm], links: [{ kind: 'ball', body: 'arm', at: 'nose' }] }, /nose/], [{ bodies: [{ ...arm, free: true }] }, /nothing holds/],
    [{ bodies: [{ ...bar, integrator: 'imexv' }] }, /energy/]])
    await assert.rejects(dropped(scene, beside), words);
});
