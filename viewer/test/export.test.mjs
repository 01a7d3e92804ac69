// What `thrum export --glb` writes: glTF without a fault, and the motion of the run when three.js
// plays it. THRUM_PROGRAM names the thrum program. SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { validateBytes } from 'gltf-validator';
import * as THREE from 'three';
import { GLTFLoader } from 'three/addons/loaders/GLTFLoader.js';
import { bytesOfBase64, readPack } from '../src/pack.js';

const PACK = /<script[^>]*id="thrum-pack"[^>]*>([^<]*)<\/script>/;
const folder = mkdtempSync(join(tmpdir(), 'thrum-export-'));
after(() => rmSync(folder, { recursive: true, force: true }));

/** @param {string[]} args of thrum */
const thrum = (...args) =>
  execFileSync(process.env.THRUM_PROGRAM, args, { cwd: folder, encoding: 'utf8' });

/** A .npy of doubles in C order: its rows. @param {string} name @returns {number[][]} */
function readRows(name) {
  const bytes = readFileSync(join(folder, name));
  const start = 10 + bytes.readUInt16LE(8);
  const shape = /'shape': \((\d+), (\d+)\)/.exec(bytes.toString('latin1', 10, start));
  const [rows, columns] = [Number(shape[1]), Number(shape[2])];
  return Array.from({ length: rows }, (_, row) =>
    Array.from({ length: columns }, (__, i) =>
      bytes.readDoubleLE(start + 8 * (row * columns + i))));
}

const SCENE = {
  dt: 0.002, time: 0.5, gravity: [0, 0, -9.81],
  bodies: [{
    name: 'block', model: 'beam:4x3x2@0.4x0.3x0.2', material: { young: 2e5 }, free: true, scale: 1.5,
    position: [0.3, -0.2, 0.8], rotation: { axis: [1, 2, 0], angle: 30 }, velocity: [0.5, 0, 0], spin: [90, 180, -45],
  }],
  obstacles: [{ shape: 'plane', restitution: 0.3 }],
  probes: [{ name: 'corner', body: 'block', at: 'vertex=1' }],
};

let glb, model, motion;

before(() => {
  thrum('precompute', 'beam:6x2x2@1x0.2x0.3,split=6', '--order', '1', '--fix', 'x<0.001', '--modes', '4', '--rank', '7',
    '-q', '-o', 'beam.npz');
  // fewer coordinates than the model has
  thrum('simulate', 'beam.npz', '-o', 'run', '--time', '0.2', '--start', 'mode:1,0.1', '--rank',
    '5', '--accept-error', '100%', '-q');
  thrum('export', 'run', '--glb', 'run.glb', '--fps', '0');
  thrum('view', 'beam.npz', '-o', 'beam.html', '-q');
  glb = readFileSync(join(folder, 'run.glb'));
  [model] = readPack(bytesOfBase64(
    PACK.exec(readFileSync(join(folder, 'beam.html'), 'utf8'))[1])).models;
  motion = readRows('run/q.npy');
});

/** Where the run has a vertex of the surface: X + U q. */
function placeOf(vertex, q) {
  const { positions, basis } = model.arrays;
  return [0, 1, 2].map((axis) => {
    const row = 3 * vertex + axis;
    return q.reduce((x, qi, i) => x + basis[row * model.rank + i] * qi, positions[row]);
  });
}

const load = async (bytes = glb) => new GLTFLoader().parseAsync(
  bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length), '');

test('the validator of Khronos finds nothing to say', async () => {
  const { issues } = await validateBytes(new Uint8Array(glb));
  assert.deepEqual(issues.messages, []);
  assert.equal(issues.numErrors + issues.numWarnings + issues.numInfos + issues.numHints, 0);
});

test('the validator does find what is wrong', async () => {
  const wrong = new Uint8Array(glb);
  wrong[8] ^= 1; // the length of the file
  const { issues } = await validateBytes(wrong);
  assert.ok(issues.numErrors > 0);
});

/** The vertex of the model that is where a vertex of the mesh is at rest; meshes are split at edges. */
function sourceOf(mesh, split) {
  const at = new THREE.Vector3().fromBufferAttribute(mesh.geometry.attributes.position, split);
  const { positions } = model.arrays;
  return Array.from({ length: model.vertex_count }, (_, v) => v).find((v) =>
    [0, 1, 2].every((axis) => Math.abs(positions[3 * v + axis] - at.getComponent(axis)) < 1e-6));
}

test('three.js plays U q(t), y up', async () => {
  const { scene, animations: [clip] } = await load();
  const mesh = scene.getObjectByProperty('isMesh', true);
  const { times } = clip.tracks[0];
  assert.equal(times.length, motion.length);
  const sources = Array.from({ length: mesh.geometry.attributes.position.count },
    (_, v) => sourceOf(mesh, v));
  assert.equal(new Set(sources).size, model.vertex_count);
  const mixer = new THREE.AnimationMixer(scene);
  const action = mixer.clipAction(clip).setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
  const at = new THREE.Vector3();
  let [worst, moved] = [0, 0];
  for (let row = 0; row < times.length; row += 3) {
    mixer.setTime(times[row]);
    scene.updateMatrixWorld(true);
    sources.forEach((source, v) => {
      const [x, y, z] = placeOf(source, motion[row]);
      mesh.localToWorld(mesh.getVertexPosition(v, at));
      worst = Math.max(worst, Math.abs(at.x - x), Math.abs(at.y - z), Math.abs(at.z + y));
      moved = Math.max(moved, Math.abs(y - model.arrays.positions[3 * source + 1]));
    });
  }
  assert.ok(moved > 0.05, `moved ${moved} m`);
  assert.ok(worst < 5e-7, `off by ${worst} m`); // a few units of single precision at 1 m
});

test('between two rows it goes straight', async () => {
  const { scene, animations: [clip] } = await load();
  const mesh = scene.getObjectByProperty('isMesh', true);
  const { times } = clip.tracks[0];
  const mixer = new THREE.AnimationMixer(scene);
  mixer.clipAction(clip).play();
  mixer.setTime((times[20] + times[21]) / 2);
  const half = motion[20].map((qi, i) => (qi + motion[21][i]) / 2);
  const last = mesh.geometry.attributes.position.count - 1;
  const at = mesh.getVertexPosition(last, new THREE.Vector3());
  placeOf(sourceOf(mesh, last), half).forEach((x, axis) =>
    assert.ok(Math.abs(at.getComponent(axis) - x) < 5e-7));
});

test('a body of a scene stands and moves where the engine has it', async () => {
  writeFileSync(join(folder, 'scene.json'), JSON.stringify(SCENE));
  thrum('simulate', 'scene.json', '-o', 'scene', '-q');
  thrum('export', 'scene/block', '--glb', 'block.glb', '--obj', 'block.obj', '--pc2', 'block.pc2',
    '--fps', '0');
  const bytes = readFileSync(join(folder, 'block.glb'));
  const { issues } = await validateBytes(new Uint8Array(bytes));
  assert.deepEqual(issues.messages, []);
  const { scene, animations: [clip] } = await load(bytes);
  const mesh = scene.getObjectByProperty('isMesh', true);
  const mixer = new THREE.AnimationMixer(scene);
  const action = mixer.clipAction(clip).setLoop(THREE.LoopOnce);
  action.clampWhenFinished = true;
  action.play();
  // step, time, x, y, z, ... of the first vertex, as the engine followed it
  const probe = readFileSync(join(folder, 'scene/probes.csv'), 'utf8').trim().split('\n').slice(1)
    .map((line) => line.split(',').map(Number));
  const cache = readFileSync(join(folder, 'block.pc2'));
  const at = new THREE.Vector3();
  const vertices = cache.readInt32LE(16);
  const { times } = clip.tracks[0];
  assert.equal(times.length, probe.length);
  // the mesh is split at edges: one of the vertices that start where the engine has its first
  mixer.setTime(times[0]);
  scene.updateMatrixWorld(true);
  const [x0, y0, z0] = probe[0].slice(2, 5);
  const first = new THREE.Vector3(x0, z0, -y0);
  const corner = Array.from({ length: mesh.geometry.attributes.position.count }, (_, v) => v).find((v) =>
    mesh.localToWorld(mesh.getVertexPosition(v, at)).distanceTo(first) < 1e-6);
  let fallen = 0;
  times.forEach((time, row) => {
    mixer.setTime(time);
    scene.updateMatrixWorld(true);
    mesh.localToWorld(mesh.getVertexPosition(corner, at));
    const [x, y, z] = probe[row].slice(2, 5);
    for (const [shown, wanted] of [[at.x, x], [at.y, z], [at.z, -y]])
      assert.ok(Math.abs(shown - wanted) < 1e-6, `${time} s: ${shown}, not ${wanted}`);
    [x, y, z].forEach((wanted, axis) =>
      assert.ok(Math.abs(cache.readFloatLE(32 + 12 * vertices * row + 4 * axis) - wanted) < 1e-6));
    fallen = Math.max(fallen, probe[0][4] - z);
  });
  assert.ok(fallen > 0.1, `it fell ${fallen} m`);
  const [still] = readFileSync(join(folder, 'block.obj'), 'utf8').split('\n')
    .filter((line) => line.startsWith('v ')).map((line) => line.split(' ').slice(1).map(Number));
  still.forEach((x, axis) => assert.ok(Math.abs(x - probe[0][2 + axis]) < 1e-12));
});

test('a scene leaves as one file without a fault', async () => {
  thrum('export', 'scene', '--glb', 'scene.glb');
  const bytes = readFileSync(join(folder, 'scene.glb'));
  const { issues } = await validateBytes(new Uint8Array(bytes));
  assert.deepEqual(issues.messages, []);
  assert.ok((await load(bytes)).scene.getObjectByName('block'));
});
