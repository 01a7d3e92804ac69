// libthrum and the scene engine in WebAssembly: javascript/bridge*.c, which the npm package has too, and viewer/page*.c.
// SPDX-License-Identifier: Apache-2.0
import { pick, withDef } from '../../javascript/src/fields.js';
import { Memory } from '../../javascript/src/memory.js';

export const INTEGRATORS = { imexv: 0, newmark: 1, verlet: 2, midpoint: 3, energy: 4, 'fox-goodwin': 5,
  'backward-euler': 6, 'semi-implicit-euler': 7, rk4: 8, manifold: 9 };
export const INTEGRATOR_NAMES = Object.keys(INTEGRATORS);
const SCHEME_ENERGY = 2;
export const LINKS = { spring: 0, ball: 1, hinge: 2, weld: 3 };
const RANK_MAX = 512;

/** A vertex under the cursor. @typedef {{body: number, vertex: number, distance: number}} Pick */

/** Rows of a body's rank as rows of its model's. @param {number[]} array @param {number} count
 * of rows @param {number} rank @returns {number[]} */
function padded(array, count, rank) {
  const width = array.length / count;
  return Array.from({ length: count * rank },
    (_, i) => (i % rank < width ? array[Math.floor(i / rank) * width + (i % rank)] : 0));
}

/** Entries of the arrays of a model whose first coordinates are stepped alone, none of any other. */
const slaveLengths = (rank, k) => (k === 0 ? { slave_map: 0, condensed_c3: 0, condensed_c4: 0 } : {
  slave_map: ((rank - k) * k * (k + 1)) / 2, condensed_c3: (k * (k + 1) * (k + 2)) / 6,
  condensed_c4: (k * (k + 1) * (k + 2) * (k + 3)) / 24 });

export class Engine {
  /** @param {Uint8Array} bytes the module @returns {Promise<Engine>} */
  static async load(bytes) {
    return Engine.of(await WebAssembly.compile(bytes));
  }

  /** An engine of a module that is compiled. @param {WebAssembly.Module} module @returns {Promise<Engine>} */
  static async of(module) {
    return new Engine(await Memory.of(module), module);
  }

  /** Another engine, without models. @returns {Promise<Engine>} */
  another() {
    return Engine.of(this.module);
  }

  constructor(memory, module) {
    this.memory = memory;
    this.wasm = memory.calls;
    this.module = module;
    this.scratch = memory.alloc(4 * RANK_MAX);
    this.models = [];
    this.bodies = []; // the model of each
    this.scene = 0;
    this.motions = []; // memory that the scene reads
  }

  /** The shared buffer; memory that grows leaves old views behind, so it is viewed anew. */
  get numbers() {
    return this.memory.numbers;
  }

  /** Throws what the library says is wrong. @param {number} status @returns {number} */
  check(status) {
    return this.memory.check(status);
  }

  /** Calls a function of the bridge on the scene, with numbers. @returns {number} */
  #call(name, numbers, ...rest) {
    if (numbers !== undefined) this.numbers.set(numbers);
    return this.check(this.wasm[name](this.scene, ...rest));
  }

  /** @param {ArrayBufferView|undefined} array
   * @returns {number} its address in the module's memory; 0: none */
  #copyIn(array) {
    if (array === undefined) return 0;
    const at = this.memory.alloc(array.byteLength);
    new Uint8Array(this.wasm.memory.buffer, at, array.byteLength)
      .set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
    return at;
  }

  /** Reads a model file. @param {Uint8Array} bytes
   * @returns {{counts: object, arrays: Object<string, ArrayBufferView>}} copies of its arrays */
  openModel(bytes) {
    const file = this.#copyIn(bytes);
    const status = this.wasm.page_open_model(file, bytes.length);
    this.wasm.js_free(file);
    this.check(status);
    const [rank, vertices, tets, regions, c3, c4, points, law, masters, laws] = this.numbers;
    const lengths = { omega2: rank, c3, c4, point_weights: points, point_moduli: 2 * points,
      point_gradients: 9 * points * rank, point_law: law, point_region: points, region_law: laws,
      axis_mass: 3 * rank, vertices: 3 * vertices, basis: 3 * vertices * rank, fixed: vertices, tets: 4 * tets,
      rigid: 18 * vertices, material: 3 * regions,
      ...slaveLengths(rank, masters) };
    const types = { point_law: Uint8Array, point_region: Int32Array, region_law: Uint8Array,
      fixed: Uint8Array, tets: Int32Array };
    const arrays = {};
    Object.entries(lengths).forEach(([name, length], n) => {
      const at = this.numbers[10 + n];
      if (at !== 0) arrays[name] = new (types[name] ?? Float64Array)(this.wasm.memory.buffer, at, length).slice();
    });
    return { counts: { rank, regions, masters }, unitEnergy: this.wasm.page_unit_energy(), arrays };
  }

  /** @param {import('./pack.js').Model} model @returns {number} */
  addModel(model) {
    // c3 and c4, those of what is stepped where the others follow, or those of cubature points
    const masters = model.masters ?? 0;
    const kept = ['omega2', ...(masters > 0 ? ['condensed_c3', 'condensed_c4'] : ['c3', 'c4']),
      'slave_map', 'point_weights', 'point_moduli', 'point_gradients',
      'point_law', 'point_region', 'region_law', 'axis_mass', 'inertia', 'fixed', 'triangles'];
    const copied = ['positions', 'basis', 'tet', 'tet_rigid']; // the last two of free bodies alone
    const at = [...kept, ...copied].map((name) => this.#copyIn(model.arrays[name]));
    this.numbers.set([model.young, model.unit_energy ?? 0]); // of older pages there is none
    const number = this.memory.lend([Uint32Array.from(at)], (addresses) => this.check(this.wasm.page_add_model(
      model.rank, model.vertex_count, model.triangle_count,
      model.arrays.point_weights?.length ?? 0, model.arrays.region_law?.length ?? 0, masters, addresses)));
    for (const address of at.slice(kept.length)) this.wasm.js_free(address);
    this.models[number] = model;
    return number;
  }

  /** A model file with its whole mesh, which links and coupled bodies are made of; its bodies have no surface.
   * @param {Uint8Array} bytes @returns {number} */
  addWholeModel(bytes) {
    const { counts, arrays } = this.openModel(bytes);
    const number = this.check(this.wasm.page_keep_model());
    this.models[number] = { rank: counts.rank, vertex_count: arrays.vertices.length / 3 };
    return number;
  }

  /** @returns {number[]} */
  allVertices(model) {
    return Array.from({ length: this.models[model].vertex_count }, (_, v) => v);
  }

  /** Vertices of a group of a whole model. @param {string} name @returns {number[]} */
  group(model, name) {
    const text = this.#copyIn(new TextEncoder().encode(`${name}\0`));
    const at = this.wasm.page_group(model, text);
    this.wasm.js_free(text);
    this.memory.made(at);
    return Array.from(new Int32Array(this.wasm.memory.buffer, at, this.numbers[0]));
  }

  /** The numbers of a whole model's inertia. @returns {Float64Array} */
  inertia(model) {
    const { rank } = this.models[model];
    const count = 9 + 9 * rank * (rank + 1);
    const at = this.wasm.js_alloc(8 * count);
    const status = this.wasm.page_inertia(model, at);
    const numbers = new Float64Array(this.wasm.memory.buffer, at, count).slice();
    this.wasm.js_free(at);
    this.check(status);
    return numbers;
  }

  /** Links bodies of whole models as they are now. @returns {object} what a link of the pack has of its meshes */
  weighLink({ body, other, ...fields }) {
    const number = withDef(this.memory, 'link', fields, () => this.#call('js_scene_add_link', undefined, body, other ?? -1));
    this.#call('page_link_made', undefined, number);
    const made = Array.from(this.numbers.subarray(0, 33));
    const rows = (side, of) => Array.from(this.memory.view(Float64Array, made[31 + side], 12 * this.report(of).rank));
    return { place: made.slice(0, 3), other_place: made.slice(3, 6), length: made[6], rest: made.slice(7, 19),
      rows: rows(0, body), other_rest: made.slice(19, 31), ...(other !== undefined && { other_rows: rows(1, other) }) };
  }

  /** The surface of an obstacle that is touched by its faces, about its own middle. @param {string} shape
   * @param {{size?: number[], radius?: number, height?: number, spacing?: number, heights?: number[][]}} sizes
   * @returns {{vertices: number[], triangles: number[]}} */
  solidSurface(shape, { size, radius, height, spacing, heights }) {
    const fields = { shape, half: size?.map((side) => side / 2), radius, height, spacing: spacing && [spacing, spacing], heights };
    const number = withDef(this.memory, 'solid', fields, () => this.#call('js_scene_add_solid'));
    this.#call('js_solid_get', undefined, number);
    const [vertexCount, vertices, triangleCount, triangles] = this.numbers.slice(16, 20);
    return { vertices: Array.from(this.memory.view(Float64Array, vertices, 3 * vertexCount)),
      triangles: Array.from(this.memory.view(Int32Array, triangles, 3 * triangleCount)) };
  }

  /** The body that lies deepest in something at present. @returns {{body: number, other: number, obstacle: number, solid: number,
   *   depth: number, diagonal: number}} -1 where there is none; obstacles and solids count by themselves */
  overlap() {
    this.#call('js_scene_overlap');
    const [body, other, obstacle, depth, solid, diagonal] = this.numbers;
    return { body, other, obstacle, solid, depth, diagonal };
  }

  /** Builds a scene of the pack's form in place of the one before. */
  build(scene) {
    const made = this.memory.made(this.wasm.js_scene_create(scene.dt));
    this.wasm.js_scene_destroy(this.scene);
    for (const at of this.motions.splice(0)) this.wasm.js_free(at);
    this.scene = made;
    this.bodies = [];
    this.setGravity(scene.gravity);
    this.obstacles = scene.obstacles.map((obstacle) =>
      (obstacle.kind === 'solid' ? this.#addSolid(obstacle) : this.#addObstacle(obstacle)));
    for (const body of scene.bodies) this.#addBody(body, scene);
    if (scene.collisions) {
      const { touches, ...given } = scene.collisions;
      withDef(this.memory, 'pairs', { ...given, touch_max: touches }, () => this.#call('js_scene_set_collisions', undefined, 1));
    }
    for (const base_motion of scene.base_motion ?? []) this.#addBaseMotion(base_motion);
    if (scene.wind) withDef(this.memory, 'wind', pick(this.memory, 'wind', scene.wind), () => this.#call('js_scene_wind'));
    this.links = (scene.links ?? []).map((link) => this.#addLink(link));
  }

  /** Calls with copies of arrays, which go afterwards. @param {(number[]|undefined)[]} arrays */
  #lend(arrays, call) {
    return this.memory.lend(arrays.map((array) => array && Float64Array.from(array)), call);
  }

  #addLoad(body, load) {
    const { rank } = this.bodies[body];
    const fields = { ...pick(this.memory, 'load', load), kind: 'reduced', reduced: padded(load.reduced, 1, rank),
      parts: load.parts && padded(load.parts, 9, rank) };
    withDef(this.memory, 'load', fields, () => this.#call('js_scene_load', undefined, body));
  }

  #addBaseMotion(base_motion) {
    const { times, accelerations, velocities, positions } = base_motion;
    if (times) { // the scene keeps these
      const samples = this.#copyIn(Float64Array.from([...times, ...accelerations, ...velocities, ...positions]));
      const motion = this.memory.alloc(this.wasm.js_motion_size());
      this.motions.push(samples, motion);
      this.#call('js_scene_base_record', undefined, motion, times.length, samples);
      return;
    }
    const fields = { ...pick(this.memory, 'load', base_motion), vector: base_motion.amplitude };
    withDef(this.memory, 'load', fields, () => this.#call('js_scene_base_motion'));
  }

  #addBody(body, scene) {
    const integrator = INTEGRATORS[body.integrator ?? scene.integrator];
    const model = this.models[body.model];
    const { colour, ...fields } = pick(this.memory, 'body', body);
    // what follows is a number of its own
    if (body.condense > 0 || model.masters > 0) delete fields.rank;
    const start = [body.q, body.p].map((vector) => vector && padded(vector, 1, model.rank));
    const number = this.#lend(start, (q, p) => withDef(this.memory, 'body', fields, () => this.#call('page_add_body', undefined,
      body.model, integrator, body.damping ?? scene.damping, q, p)));
    this.bodies[number] = model;
    for (const load of body.loads ?? []) this.#addLoad(number, load);
  }

  /** A link of ready sides. @returns {number} */
  #addLink(link) {
    const { body, other, times, places, rows, other_rows } = link;
    const rankOf = (of) => (of ? of.length / 12 : 0);
    const fields = { ...pick(this.memory, 'link', link), path_times: times, path_places: places };
    return this.#lend([rows, other_rows], (at, otherAt) => withDef(this.memory, 'link', fields, () =>
      this.#call('page_add_link', [...link.rest, ...link.other_rest], body, other ?? -1, rankOf(rows), at, rankOf(other_rows), otherAt)));
  }

  /** A link of the scene as it is now. @param {number} n
   * @returns {{holds: boolean, places: number[], force: number[], drift: number, largestDrift: number,
   *   stored: number}} its two places, six numbers [m], force [N], drifts [m], energy [J] */
  link(n) {
    this.#call('js_link_get', undefined, this.links[n]);
    const found = Array.from(this.numbers.subarray(0, 22));
    const [drift, largestDrift, stored] = found.slice(17);
    return { holds: found[1] === 1, places: found.slice(5, 11), force: found.slice(11, 14), drift, largestDrift, stored };
  }

  #addObstacle({ kind, size, ...obstacle }) {
    const { rotation, ...fields } = pick(this.memory, 'obstacle', obstacle);
    return withDef(this.memory, 'obstacle', { ...fields, shape: kind, half: size?.map((side) => side / 2) }, () => {
      if (rotation) this.numbers.set(rotation);
      if (rotation) this.check(this.wasm.js_obstacle_turn());
      return this.#call('js_scene_obstacle', undefined, -1);
    });
  }

  /** An obstacle that is touched by its faces. @returns {number} of the solid */
  #addSolid({ centre, times, places, ...of }) {
    const way = times.length > 0 ? { path_times: times, path_places: places } : {};
    return withDef(this.memory, 'solid', { ...pick(this.memory, 'solid', of), ...way, shape: 'mesh', position: centre },
      () => this.#call('js_scene_add_solid'));
  }

  /** Where a solid of the scene's obstacles is now. @returns {number[]} 4 x 4, column by column */
  solidMatrix(number) {
    this.#call('js_solid_get', undefined, this.obstacles[number]);
    return Array.from(this.numbers.subarray(0, 16));
  }

  /** Where the centre of an obstacle of the scene is now. @returns {number[]} */
  obstacleCentre(number) {
    this.#call('js_obstacle_get', undefined, this.obstacles[number]);
    return Array.from(this.numbers.subarray(0, 3));
  }

  /** @param {number[]} gravity [m/s^2] */
  setGravity(gravity) {
    this.#call('js_scene_gravity', gravity);
  }

  setDt(dt) {
    this.#call('js_scene_dt', undefined, dt);
  }

  setDamping(body, alpha) {
    this.#call('js_body_damping', undefined, body, alpha, 0);
  }

  setStiffness(body, factor) {
    this.#call('js_body_stiffness', undefined, body, factor);
  }

  /** @param {number} body @param {string} name */
  setIntegrator(body, name) {
    if (!(name in INTEGRATORS)) throw new Error(`there is no integrator '${name}'`);
    this.#call('js_body_integrator', undefined, body, INTEGRATORS[name]);
  }

  setRank(body, rank) {
    this.#call('js_body_rank', undefined, body, rank);
  }

  reset() {
    this.#call('js_scene_reset');
  }

  /** One step of all bodies; throws when one of them fails. */
  step() {
    this.#call('js_scene_step');
  }

  get time() {
    return this.wasm.js_scene_time(this.scene);
  }

  /** q of the coordinates that show a body, at the front of the shared buffer. @returns {Float64Array} */
  shown(body) {
    this.#call('js_body_coordinates', undefined, body, this.memory.numbersAt, 0);
    return this.numbers;
  }

  /** q as it is stepped. @returns {number[]} */
  coordinates(body) {
    const { rank } = this.report(body);
    return Array.from(this.shown(body).subarray(0, rank));
  }

  /** q of the model's full rank in single precision; valid until the next call. */
  shape(body) {
    this.#call('page_shape', undefined, body, this.scratch);
    return new Float32Array(this.wasm.memory.buffer, this.scratch, this.bodies[body].rank);
  }

  /** Column-major 4 x 4 into the world. */
  matrix(body) {
    this.wasm.js_body_matrix(this.scene, body);
    return this.numbers.subarray(0, 16);
  }

  energies(body) {
    this.#call('js_body_energies', undefined, body);
    const [kinetic, potential, gravity, , total] = this.numbers;
    return { kinetic, potential, gravity, total };
  }

  /**
   * Energies of all bodies together [J]; `contact` has what they hold between them, `links` the springs of links,
   * `lost` what bodies that met each other have lost since the start and is no part of the total.
   */
  account() {
    this.#call('js_scene_account');
    const [kinetic, potential, gravity, contact, total] = this.numbers;
    const [links, lost] = this.numbers.subarray(11);
    return { kinetic, potential, gravity, contact, links, total, lost };
  }

  report(body) {
    this.#call('js_body_info', undefined, body);
    const [status, rank, , , scheme, fallbacks, grown, , integrator, explicit, implicit, iterations, firstSwitch] = this.numbers;
    return {
      status, rank, explicit, implicit, iterations, scheme, fallbacks, firstSwitch, grown,
      // imexv or fox-goodwin that its monitor has switched, and that has not returned
      switched: scheme === SCHEME_ENERGY && integrator !== INTEGRATORS.energy,
      integrator: INTEGRATOR_NAMES[integrator],
    };
  }

  /** Frequencies of the modes as a step gives them [Hz]; NaN where one does not vibrate. */
  steppedFrequencies(body) {
    const { rank } = this.report(body);
    return Array.from(new Float64Array(this.wasm.memory.buffer,
      this.wasm.page_stepped_frequencies(this.scene, body), rank));
  }

  /** Frequencies of the modes of the body [Hz]. */
  frequencies(body) {
    const { rank } = this.report(body);
    const omega2 = new Float64Array(this.wasm.memory.buffer, this.wasm.page_omega2(this.scene, body), rank);
    return Array.from(omega2, (w2) => Math.sqrt(w2) / (2 * Math.PI));
  }

  /** Position of a vertex in the world [m]. @returns {number[]} */
  position(body, vertex) {
    this.#call('js_body_vertex', undefined, body, vertex);
    return Array.from(this.numbers.subarray(0, 3));
  }

  /** A spring from a vertex to a point, `strength` times as stiff as the body is there.
   * @returns {number} to move and to end it by */
  startPull(body, vertex, target, strength) {
    return this.#call('page_pull_start', target, body, vertex, strength);
  }

  movePull(pull, target) {
    this.#call('js_pull_move', target, pull);
  }

  /** Where a pulled vertex is [m], and the mean force of the last step on it [N]. */
  pull(pull) {
    this.#call('js_pull_get', undefined, pull);
    return { point: Array.from(this.numbers.subarray(0, 3)), force: Array.from(this.numbers.subarray(3, 6)) };
  }

  /** Places where bodies touch obstacles or each other now [m], three numbers each, valid until the
   * next call. @returns {Float32Array} */
  touches() {
    const at = this.wasm.page_touches(this.scene);
    const count = this.wasm.page_touch_count();
    return new Float32Array(this.wasm.memory.buffer, at, 3 * count);
  }

  endPull(pull) {
    this.#call('js_pull_end', undefined, pull);
  }

  /** The first vertex that a ray meets; null: none. @param {number[]} origin
   * @param {number[]} direction @returns {Pick|null} */
  pick(origin, direction) {
    this.numbers.set([...origin, ...direction]);
    if (!this.wasm.page_pick(this.scene)) return null;
    const [body, vertex, distance] = this.numbers;
    return { body, vertex, distance };
  }
}
