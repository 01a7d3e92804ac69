// Models, states, batches and surfaces. SPDX-License-Identifier: Apache-2.0
import { Rollout, valueAndGradient } from './gradient.js';
import { outerTriangles } from './outer_triangles.js';
import { Memory, Owned, Resource, ThrumError, doubles, snapshotBytes, steps, vertices } from './memory.js';

const ARRAYS = { omega2: 0, vertices: 1, tets: 2, fixed: 3, material: 4, basis: 5, groupNames: 6,
  groupEnds: 7, groupVertices: 8, meta: 9, regionLaw: 10, pointLaw: 11 };
const LAWS = ['stvk', 'corotational', 'neo-hookean'];
const STATE_OPTIONS = ['integrator', 'dt', 'dampingAlpha', 'dampingBeta', 'tolerance', 'splitSafety',
  'adaptive', 'fallback'];

/** A switch for the bridge: -1 leaves the default. */
const flag = (value) => (value === undefined ? -1 : value ? 1 : 0);

/** Refuses options that there are not, so that a misspelt one is found. */
export function knownOptions(options, known, what) {
  const unknown = Object.keys(options).find((name) => !known.includes(name));
  if (unknown !== undefined)
    throw new ThrumError(`${what} has no option '${unknown}'; it has: ${known.join(', ')}`, -1);
}

/** The number of an integrator. @param {Memory} memory @param {string} name */
export function integratorNumber(memory, name) {
  const text = new TextEncoder().encode(`${name}\0`);
  return memory.check(memory.lend([text], (at) => memory.calls.js_integrator(at)));
}

export class Model extends Resource {
  #memory;
  #sizes;

  constructor(memory, address, parents = []) {
    const release = (at) => memory.calls.js_model_destroy(at);
    super('model', new Owned(memory.made(address), release, parents));
    this.#memory = memory;
    memory.calls.js_model_sizes(this.address);
    const [rank, shown, masters, vertexCount, tetCount, regionCount, groupCount, nameBytes,
      groupVertexCount, metaBytes, lawCount, lawBytes] = memory.numbers;
    this.#sizes = { regionCount, groupCount, nameBytes, groupVertexCount, metaBytes, lawCount, lawBytes };
    Object.assign(this, { rank, shown, masters, vertexCount, tetCount });
  }

  static of(memory, bytes) {
    if (!(bytes instanceof ArrayBuffer || ArrayBuffer.isView(bytes)))
      throw new ThrumError('a model is made of the bytes of its file', -1);
    const data = bytes instanceof ArrayBuffer ? new Uint8Array(bytes)
      : new Uint8Array(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    return new Model(memory,
      memory.lend([data], (at) => memory.calls.js_model_load(at, data.length)));
  }

  /** A copy of one of its arrays; undefined where it has none. */
  #array(name, Kind, count) {
    const at = this.#memory.calls.js_model_array(this.address, ARRAYS[name]);
    return at === 0 ? undefined : this.#memory.view(Kind, at, count).slice();
  }

  get omega2() {
    return this.#array('omega2', Float64Array, this.rank);
  }

  get frequencies() {
    return this.omega2.map((square) => Math.sqrt(square) / (2 * Math.PI));
  }

  get vertices() {
    return this.#array('vertices', Float64Array, 3 * this.vertexCount);
  }

  get tets() {
    return this.#array('tets', Int32Array, 4 * this.tetCount);
  }

  get fixed() {
    return this.#array('fixed', Uint8Array, this.vertexCount);
  }

  get material() {
    return this.#array('material', Float64Array, 3 * this.#sizes.regionCount);
  }

  get laws() {
    const { regionCount, lawCount, lawBytes } = this.#sizes;
    const own = this.#array('regionLaw', Uint8Array, lawCount);
    if (own) return Array.from(own, (law) => LAWS[law]);
    const named = this.#array('pointLaw', Uint8Array, lawBytes);
    const law = named ? new TextDecoder().decode(named.subarray(0, lawBytes - 1)) : LAWS[0];
    return new Array(Math.max(regionCount, 1)).fill(law);
  }

  get basis() {
    return this.#array('basis', Float64Array, 3 * this.vertexCount * this.shown);
  }

  get groups() {
    const { groupCount, nameBytes, groupVertexCount } = this.#sizes;
    if (groupCount === 0) return {};
    const names = new TextDecoder().decode(this.#array('groupNames', Uint8Array, nameBytes)).split('\0');
    const ends = this.#array('groupEnds', Int32Array, groupCount);
    const all = this.#array('groupVertices', Int32Array, groupVertexCount);
    return Object.fromEntries(Array.from(ends,
      (end, number) => [names[number], all.slice(number === 0 ? 0 : ends[number - 1], end)]));
  }

  get meta() {
    const bytes = this.#array('meta', Uint8Array, this.#sizes.metaBytes);
    return bytes === undefined ? {} : JSON.parse(new TextDecoder().decode(bytes));
  }

  truncate(rank) {
    return rank === this.rank ? this : this.condense(rank);
  }

  condense(masters) {
    return new Model(this.#memory, this.#memory.calls.js_model_condense(this.address, masters),
      [this.owned]);
  }

  scale({ length = 1, stiffness = 1, density = 1 }) {
    return new Model(this.#memory,
      this.#memory.calls.js_model_scale(this.address, length, stiffness, density), [this.owned]);
  }

  group(name) {
    const found = this.groups[name];
    if (found === undefined)
      throw new ThrumError(`the model has no group '${name}'; it has: ${Object.keys(this.groups).join(', ')}`, -10);
    return found;
  }

  /** The vertices that a load or a probe names: all of the body for undefined. */
  chosen({ vertices: named, vertex, group }) {
    if (group !== undefined) return this.group(group);
    if (vertex !== undefined) return vertices([vertex], this.vertexCount, 'vertex');
    return named === undefined ? undefined : vertices(named, this.vertexCount, 'vertices');
  }

  externalLoad(load) {
    knownOptions(load, ['force', 'gravity', 'vertices', 'vertex', 'group'], 'a load');
    const { calls } = this.#memory;
    return this.#memory.take(Float64Array, this.shown, (into) => {
      this.#memory.view(Float64Array, into, this.shown).fill(0);
      if (load.force !== undefined) {
        const chosen = this.chosen(load);
        this.#memory.lend([chosen], (at) => {
          this.#memory.numbers.set(doubles(load.force, 3, 'force'));
          this.#memory.check(calls.js_load_force(this.address, at, chosen?.length ?? 0, into));
        });
      }
      if (load.gravity !== undefined) {
        this.#memory.numbers.set(doubles(load.gravity, 3, 'gravity'));
        this.#memory.check(calls.js_load_gravity(this.address, into));
      }
    });
  }

  condensedLoad(q, load) {
    const given = [doubles(q, this.rank, 'q'), doubles(load, this.shown, 'load')];
    return this.#memory.lend(given, (at, pushed) => this.#memory.take(Float64Array, this.rank,
      (into) => this.#memory.calls.js_condensed_load(this.address, at, pushed, into)));
  }

  shape(q, load) {
    const given = [doubles(q, this.rank, 'q'), load && doubles(load, this.shown, 'load')];
    return this.#memory.lend(given, (at, pushed) => this.#memory.take(Float64Array, this.shown,
      (into) => this.#memory.calls.js_condensed_shape(this.address, at, pushed, into)));
  }

  start(mode, amplitude) {
    return this.#memory.take(Float64Array, this.shown, (into) => {
      this.#memory.view(Float64Array, into, this.shown).fill(0);
      this.#memory.check(this.#memory.calls.js_mode_add(this.address, mode, amplitude, into));
    });
  }

  #atShown(q, Kind, count, call) {
    return this.#memory.lend([doubles(q, this.shown, 'q')], (at) => this.#memory.take(Kind, count,
      (into) => this.#memory.check(call(this.address, at, into))));
  }

  displacement(q) {
    return this.#atShown(q, Float64Array, 3 * this.vertexCount, this.#memory.calls.js_displacement);
  }

  vonMises(q) {
    return this.#atShown(q, Float64Array, this.tetCount, this.#memory.calls.js_von_mises);
  }

  equilibrium(load, from) {
    const start = from === undefined ? new Float64Array(this.rank) : doubles(from, this.rank, 'q');
    const q = new Float64Array(this.rank);
    this.#memory.lend([doubles(load, this.rank, 'load'), start], (pushed, at) => {
      this.#memory.check(this.#memory.calls.js_equilibrium(this.address, pushed, at));
      q.set(this.#memory.view(Float64Array, at, this.rank));
    });
    const [factor, energy, least, critical] = this.#memory.numbers;
    return { q, factor, energy, least, critical, stable: least >= 0 };
  }

  outerTriangles() {
    const { tets } = this;
    if (tets === undefined) throw new ThrumError('the model has no mesh', -10);
    return outerTriangles(tets);
  }

  state(options = {}) {
    return new State(this.#memory, this, options);
  }

  rollout(steps, options = {}) {
    return new Rollout(this.#memory, this, steps, options);
  }

  valueAndGradient(loss, steps, options = {}) {
    return Array.isArray(options) ? options.map((each) => this.valueAndGradient(loss, steps, each))
      : valueAndGradient(loss, this.rollout(steps, options));
  }

  batch(states) {
    return new Batch(this.#memory, this, states);
  }

  surface(options = {}) {
    return new Surface(this.#memory, this, options);
  }

  stressNodes() {
    return new StressNodes(this.#memory, this);
  }
}

export class State extends Resource {
  #memory;
  #modelAt; // the memory stays while the state does, whatever becomes of the Model

  constructor(memory, model, options) {
    knownOptions(options, STATE_OPTIONS, 'a state');
    const integrator = integratorNumber(memory, options.integrator ?? 'energy');
    memory.numbers.set([options.dt ?? 0.003, options.dampingAlpha ?? 0, options.dampingBeta ?? 0,
      options.tolerance ?? -1, options.splitSafety ?? -1, flag(options.adaptive), flag(options.fallback)]);
    super('state', new Owned(memory.made(memory.calls.js_state_create(model.address, integrator)),
      (at) => memory.calls.js_state_destroy(at), [model.owned]));
    this.#memory = memory;
    this.#modelAt = model.address;
    this.model = model;
  }

  set(q, p) {
    const given = [q && doubles(q, this.model.rank, 'q'), p && doubles(p, this.model.rank, 'p')];
    this.#memory.lend(given, (atQ, atP) =>
      this.#memory.check(this.#memory.calls.js_state_set(this.#modelAt, this.address, atQ, atP)));
  }

  #get(momenta) {
    return this.#memory.take(Float64Array, this.model.rank, (at) => this.#memory.check(
      this.#memory.calls.js_state_get(this.#modelAt, this.address, momenta ? 0 : at, momenta ? at : 0)));
  }

  get q() {
    return this.#get(false);
  }

  get p() {
    return this.#get(true);
  }

  setForce(force) {
    this.#memory.lend([force && doubles(force, this.model.rank, 'force')], (at) =>
      this.#memory.check(this.#memory.calls.js_state_force(this.#modelAt, this.address, at)));
  }

  setDt(dt) {
    this.#memory.check(this.#memory.calls.js_state_dt(this.#modelAt, this.address, dt));
  }

  step(count = 1) {
    return this.#memory.check(
      this.#memory.calls.js_state_step(this.#modelAt, this.address, steps(count)));
  }

  get energies() {
    this.#memory.check(this.#memory.calls.js_state_energies(this.#modelAt, this.address));
    const [kinetic, potential, total] = this.#memory.numbers;
    return { kinetic, potential, total };
  }

  get report() {
    this.#memory.calls.js_state_report(this.address);
    const [steps, time, iterations, switchedSteps, grownSteps, scheme, explicitModes, implicitModes,
      dissipated] = this.#memory.numbers;
    return { steps, time, iterations, switchedSteps, grownSteps, explicitModes, implicitModes, dissipated,
      scheme: this.#memory.text(this.#memory.calls.js_name(scheme, 1)) };
  }

  snapshot() {
    const { calls } = this.#memory;
    const size = calls.js_state_snapshot_size(this.address);
    return this.#memory.take(Uint8Array, size,
      (at) => this.#memory.check(calls.js_state_snapshot(this.address, at, size)));
  }

  restore(snapshot) {
    this.#memory.lend([snapshotBytes(snapshot)], (at) => this.#memory.check(
      this.#memory.calls.js_state_restore(this.#modelAt, this.address, at, snapshot.length)));
  }
}

export class Batch extends Resource {
  #memory;
  #size;
  #modelAt;

  constructor(memory, model, states) {
    if (new Set(states).size !== states.length)
      throw new ThrumError('a state is listed twice in the batch', -1);
    const parents = [model.owned, ...states.map((state) => state.owned)];
    super('batch', new Owned(memory.made(memory.calls.js_batch_create(model.address)),
      (at) => memory.calls.js_free(at), parents));
    this.#size = memory.numbers[0];
    this.#memory = memory;
    this.#modelAt = model.address;
    this.states = [...states];
  }

  step(count = 1) {
    const { calls } = this.#memory;
    const length = this.states.length;
    const addresses = Int32Array.from(this.states, (state) => state.address);
    const statuses = new Int32Array(length);
    steps(count);
    this.#memory.lend([addresses, statuses], (at, into) => {
      for (let done = 0; done < count; done += 1) {
        const status = calls.js_batch_step(this.#modelAt, at, length, into, this.address, this.#size);
        statuses.set(this.#memory.view(Int32Array, into, length));
        // the call failed as a whole where no state says so
        if (status < 0 && statuses.every((each) => each >= 0)) this.#memory.check(status);
      }
    });
    return statuses;
  }
}

export class Surface extends Resource {
  #memory;

  constructor(memory, model, options) {
    knownOptions(options, ['vertices', 'triangles'], 'a surface');
    const chosen = options.vertices && vertices(options.vertices, model.vertexCount, 'vertices');
    const count = chosen?.length ?? model.vertexCount;
    const triangles = options.triangles && vertices(options.triangles, count, 'triangles');
    if (triangles && triangles.length % 3 !== 0)
      throw new ThrumError('triangles: their number of corners is no multiple of 3', -11);
    const address = memory.lend([chosen, triangles], (at, faces) => memory.calls.js_surface_create(
      model.address, at, chosen?.length ?? 0, faces, (triangles?.length ?? 0) / 3));
    super('surface', new Owned(memory.made(address), (at) => memory.calls.js_free(at)));
    this.#memory = memory;
    this.shown = model.shown;
    this.triangles = triangles;
    this.vertexCount = memory.calls.js_surface_count(this.address);
  }

  /** Room for its positions or normals: `out` where that fits. */
  room(out) {
    const length = 3 * this.vertexCount;
    if (out === undefined) return new Float32Array(length);
    if (!(out instanceof Float32Array) || out.length !== length)
      throw new ThrumError(`out: a Float32Array of ${length} numbers is needed`, -11);
    return out;
  }

  positions(q, out) {
    const into = this.room(out);
    return this.#memory.lend([doubles(q, this.shown, 'q')], (at) => this.#memory.take(Float32Array,
      into.length, (to) => this.#memory.check(
        this.#memory.calls.js_surface_positions(this.address, at, to)), into));
  }

  normals(positions, out) {
    const into = this.room(out);
    return this.#memory.lend([this.room(positions)], (at) => this.#memory.take(Float32Array,
      into.length, (to) => this.#memory.check(
        this.#memory.calls.js_surface_normals(this.address, at, to)), into));
  }
}

export class StressNodes extends Resource {
  #memory;
  #modelAt;

  constructor(memory, model) {
    super('set of stress nodes', new Owned(memory.made(memory.calls.js_stress_nodes_create(model.address)),
      (at) => memory.calls.js_free(at), [model.owned]));
    const [count, extrapolated] = memory.numbers;
    this.#memory = memory;
    this.#modelAt = model.address;
    Object.assign(this, { count, extrapolated: extrapolated === 1, shown: model.shown });
  }

  /** Vertices of all nodes, then their regions. */
  #places() {
    return this.#memory.take(Int32Array, 2 * this.count, (at) => this.#memory.calls.js_stress_nodes_places(
      this.address, at, at + this.count * Int32Array.BYTES_PER_ELEMENT));
  }

  get vertices() {
    return this.#places().slice(0, this.count);
  }

  get regions() {
    return this.#places().slice(this.count);
  }

  read(q) {
    const all = this.#memory.lend([doubles(q, this.shown, 'q')], (at) => this.#memory.take(Float64Array,
      7 * this.count, (into) => this.#memory.check(
        this.#memory.calls.js_stress_nodes_read(this.#modelAt, this.address, at, into))));
    return { cauchy: all.slice(0, 6 * this.count), vonMises: all.slice(6 * this.count) };
  }
}
