// A bar that bends under its weight, in Thrum and in MuJoCo, both as WebAssembly from npm under node: how far the end is
// from the full-order motion, and what a step costs. docs/beside_mujoco.md has the result and what it does not say.
// usage: node compare.mjs THRUM APP RESULT.json
//   THRUM  the program, which makes the models and the motion that both are measured against (about five minutes)
//   APP    a folder in which `npm install @mujoco/mujoco@3.14.0 PACKAGE.tgz` was run, PACKAGE.tgz being the package thrum
// SPDX-License-Identifier: Apache-2.0
import { execFileSync } from 'node:child_process';
import { existsSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { cpus } from 'node:os';
import { join, resolve } from 'node:path';
import { pathToFileURL } from 'node:url';

const [program, app, result] = process.argv.slice(2).map((path) => resolve(path));
if (!result) throw new Error('usage: node compare.mjs THRUM APP RESULT.json');
const packageOf = (name) => JSON.parse(readFileSync(join(app, 'node_modules', name, 'package.json'), 'utf8'));
const entry = (name, file) => import(pathToFileURL(join(app, 'node_modules', name, file)).href);

// 1 m long, 0.1 m square, clamped at x = 0, let go at rest under its weight: it swings by 15 % of its length
const MATERIAL = { young: 2e7, poisson: 0.3, density: 1000 };
const GRAVITY = -9.81;
const SECONDS = 1;
const EVERY = 0.005; // [s] between the moments that are compared
const ROWS = Math.round(SECONDS / EVERY);

// --- Thrum -----------------------------------------------------------------------------------------

const work = join(app, 'models');
mkdirSync(work, { recursive: true });
const thrum = await (await entry('thrum', packageOf('thrum').exports['.'].default)).load();

/** A model file of the bar; made once. */
function modelFile(name, mesh, order, modes, rank) {
  const path = join(work, `${name}.npz`);
  if (!existsSync(path)) {
    execFileSync(program, ['precompute', mesh, '-o', path, '-q', '--order', order, '--fix', 'x<0.001', '--modes', modes,
      '--rank', rank, ...Object.entries(MATERIAL).flatMap(([key, value]) => [`--${key}`, value])].map(String),
    { stdio: ['ignore', 'ignore', 'inherit'] });
  }
  return thrum.model(readFileSync(path));
}

/** The vertex nearest to the middle of the free end. */
function endOf(positions, count) {
  let best = 0;
  const away = (k) => Math.hypot(positions[3 * k] - 1, positions[3 * k + 1], positions[3 * k + 2]);
  for (let k = 1; k < count; k += 1) if (away(k) < away(best)) best = k;
  return best;
}

/** Heights of the end [m] of the unreduced fine mesh, by steps of 1 ms that conserve energy. */
function reference() {
  const model = modelFile('fine', 'beam:40x4x4@1x0.1x0.1', 2, 10, 20);
  const run = join(work, 'fine');
  if (!existsSync(join(run, 'end.npy'))) {
    execFileSync(program, ['simulate', join(work, 'fine.npz'), '--full', '--time', String(SECONDS), '--dt', '0.001', '--load',
      `gravity:0,0,${GRAVITY}`, '-o', run, '--record-every', '5', '-q'], { stdio: ['ignore', 'ignore', 'inherit'] });
  }
  // the rows of q are what the model's basis shows of the whole mesh
  const bytes = readFileSync(join(run, 'q.npy'));
  const data = bytes.subarray(10 + bytes.readUInt16LE(8));
  const q = new Float64Array(data.buffer.slice(data.byteOffset, data.byteOffset + data.byteLength));
  const end = endOf(model.vertices, model.vertexCount);
  return Array.from({ length: ROWS + 1 }, (_, row) =>
    model.displacement(q.slice(row * model.rank, (row + 1) * model.rank))[3 * end + 2]);
}

/** A body of Thrum that steps. */
function thrumBody({ order, modes, rank, dt, integrator }) {
  const model = modelFile(`bar-${order}-${rank}`, 'beam:20x2x2@1x0.1x0.1', order, modes, rank);
  const state = model.state({ integrator, dt });
  state.setForce(model.externalLoad({ gravity: [0, 0, GRAVITY] }));
  const end = endOf(model.vertices, model.vertexCount);
  return { coordinates: rank, step: (n) => state.step(n), height: () => model.displacement(state.q)[3 * end + 2],
    free: () => { state.free(); model.free(); } };
}

// --- MuJoCo ----------------------------------------------------------------------------------------

const mujoco = await (await entry('@mujoco/mujoco', packageOf('@mujoco/mujoco').main ?? 'mujoco.js')).default();

/** A flex of MuJoCo that steps: a grid of tetrahedra whose vertices move by themselves, or with `cells`. */
function mujocoBody({ dof, cells, count, dt, integrator }) {
  const [nx, ny, nz] = count;
  const model = mujoco.MjModel.from_xml_string(`<mujoco><option timestep="${dt}" gravity="0 0 ${GRAVITY}" integrator="${integrator}">
    <flag contact="disable"/></option><worldbody><flexcomp name="bar" type="grid" dim="3" count="${nx} ${ny} ${nz}"
    spacing="${1 / (nx - 1)} ${0.1 / (ny - 1)} ${0.1 / (nz - 1)}" pos="0.5 0 0" radius="0.001" mass="${0.01 * MATERIAL.density}"
    dof="${dof}" ${cells ? `cellcount="${cells.join(' ')}"` : ''}><edge damping="0"/>
    <elasticity young="${MATERIAL.young}" poisson="${MATERIAL.poisson}" damping="0"/><contact selfcollide="none" internal="false"/>
    <pin gridrange="0 0 0 0 ${ny - 1} ${nz - 1}"/></flexcomp></worldbody></mujoco>`);
  const data = new mujoco.MjData(model);
  mujoco.mj_forward(model, data);
  const end = endOf(data.flexvert_xpos, model.nflexvert);
  return { coordinates: model.nv, step: (n) => { for (let k = 0; k < n; k += 1) mujoco.mj_step(model, data); },
    height: () => data.flexvert_xpos[3 * end + 2], free: () => { data.delete(); model.delete(); } };
}

// --- both ------------------------------------------------------------------------------------------

const chain = (cells) => ({ dof: 'trilinear', cells: [cells, 1, 1], count: [cells + 1, 3, 3] });
const CASES = [
  { engine: 'thrum', order: 2, modes: 2, rank: 5, dt: 5e-3, integrator: 'energy' },
  { engine: 'thrum', order: 2, modes: 2, rank: 5, dt: 1e-3, integrator: 'energy' },
  { engine: 'thrum', order: 2, modes: 4, rank: 12, dt: 5e-3, integrator: 'energy' },
  { engine: 'thrum', order: 2, modes: 20, rank: 45, dt: 5e-3, integrator: 'energy' },
  { engine: 'thrum', order: 1, modes: 4, rank: 12, dt: 5e-3, integrator: 'energy' },
  { engine: 'mujoco', ...chain(5), dt: 1e-3, integrator: 'discrete' },
  { engine: 'mujoco', ...chain(12), dt: 1e-3, integrator: 'discrete' },
  { engine: 'mujoco', ...chain(12), dt: 5e-3, integrator: 'discrete' },
  { engine: 'mujoco', ...chain(12), dt: 5e-4, integrator: 'Euler' },
  { engine: 'mujoco', dof: 'quadratic', count: [11, 3, 3], dt: 1e-3, integrator: 'discrete' },
  { engine: 'mujoco', dof: 'full', count: [11, 3, 3], dt: 1e-3, integrator: 'discrete' },
];
const make = (what) => (what.engine === 'thrum' ? thrumBody(what) : mujocoBody(what));

/** Root of the mean square of what the end lacks, over that of the reference; Infinity where the run was lost. */
function errorOf(what, heights) {
  const body = make(what);
  const steps = Math.round(EVERY / what.dt);
  let apart = 0, whole = 0;
  for (let row = 1; row <= ROWS; row += 1) {
    body.step(steps);
    apart += (body.height() - heights[row]) ** 2;
    whole += heights[row] ** 2;
  }
  const coordinates = body.coordinates;
  body.free();
  return { coordinates, error: Number.isFinite(apart) && apart < 100 * whole ? Math.sqrt(apart / whole) : Infinity };
}

/** Processor time of a step [us], over the same second of motion, as often as makes a fifth of a second. */
function timeOf(what) {
  let spent = 0, steps = 0;
  while (spent < 2e5) {
    const body = make(what);
    body.step(1);
    const before = process.cpuUsage();
    body.step(Math.round(SECONDS / what.dt) - 1);
    const { user, system } = process.cpuUsage(before);
    body.free();
    spent += user + system;
    steps += Math.round(SECONDS / what.dt) - 1;
  }
  return spent / steps;
}

const heights = reference();
const rows = CASES.map((what) => ({ ...what, ...errorOf(what, heights), us: Infinity }));
// in turns, because the machine has other work; the least counts
for (let turn = 0; turn < 3; turn += 1) for (const row of rows) row.us = Math.min(row.us, timeOf(row));

writeFileSync(result, `${JSON.stringify({ thrum: packageOf('thrum').version, mujoco: packageOf('@mujoco/mujoco').version,
  node: process.version, machine: cpus()[0].model, material: MATERIAL, seconds: SECONDS, rows }, null, 1)}\n`);
const name = (row) => (row.engine === 'thrum' ? `Thrum, rank ${row.rank}${row.order === 1 ? ', linear tetrahedra' : ''}` : `MuJoCo, ${row.dof}${row.cells ? `, ${row.cells[0]} cells` : ''}`);
console.log('| body | coordinates | integrator | step [ms] | error | a step [us] | steps a second | a second of motion [ms] |');
console.log('|---|---|---|---|---|---|---|---|');
for (const row of rows) {
  console.log(`| ${name(row)} | ${row.coordinates} | ${row.integrator} | ${1e3 * row.dt} | ${(100 * row.error).toFixed(1)} % | ` +
    `${row.us.toPrecision(3)} | ${Math.round(1e6 / row.us).toLocaleString('en')} | ${(row.us / row.dt / 1e3).toPrecision(3)} |`);
}
