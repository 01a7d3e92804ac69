// libthrum and the scene engine in WebAssembly, behind viewer/bridge.c.
// SPDX-License-Identifier: Apache-2.0

export const INTEGRATORS = { imexv: 0, newmark: 1, verlet: 2, midpoint: 3, energy: 4, 'fox-goodwin': 5,
  'backward-euler': 6, 'semi-implicit-euler': 7, rk4: 8, manifold: 9 };
export const INTEGRATOR_NAMES = Object.keys(INTEGRATORS);
const SCHEME_ENERGY = 2;
const OBSTACLES = { plane: 0, sphere: 1, box: 2 };
const SOLIDS = { box: 1, cylinder: 2, capsule: 3, height_field: 4 };
export const LINKS = { spring: 0, ball: 1, hinge: 2, weld: 3 };
const COURSES = { constant: 0, sine: 1, ramp: 2 };
const MESSAGE_BYTES = 400;
const RANK_MAX = 512;

/** What vsnprintf drags in; nothing is ever written. */
const wasi = { fd_close: () => 8, fd_seek: () => 8, fd_write: () => 8 };

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

/** @returns {number[]} from, until, frequency */
const course = ({ from, until, frequency }) => [from, until ?? Infinity, frequency];

export class Engine {
  /** @param {Uint8Array} bytes the module @returns {Promise<Engine>} */
  static async load(bytes) {
    const { instance, module } = await WebAssembly.instantiate(bytes, { wasi_snapshot_preview1: wasi });
    return new Engine(instance.exports, module);
  }

  /** An engine of a module that is compiled. @param {WebAssembly.Module} module @returns {Promise<Engine>} */
  static async of(module) {
    const { exports } = await WebAssembly.instantiate(module, { wasi_snapshot_preview1: wasi });
    return new Engine(exports, module);
  }

  /** Another engine, without models. @returns {Promise<Engine>} */
  another() {
    return Engine.of(this.module);
  }

  constructor(exports, module) {
    this.wasm = exports;
    this.module = module;
    this.wasm._initialize();
    this.numbersAt = this.wasm.bridge_numbers();
    this.scratch = this.wasm.bridge_alloc(4 * RANK_MAX);
    this.models = [];
    this.bodies = []; // the model of each
  }

  /** The shared buffer; memory that grows leaves old views behind, so it is viewed anew. */
  get numbers() {
    return new Float64Array(this.wasm.memory.buffer, this.numbersAt, RANK_MAX);
  }

  get message() {
    const bytes = new Uint8Array(this.wasm.memory.buffer, this.wasm.bridge_message(),
      MESSAGE_BYTES);
    return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
  }

  /** Throws what the library says is wrong. @param {number} status @returns {number} */
  check(status) {
    if (status < 0) throw new Error(this.message);
    return status;
  }

  /** @param {ArrayBufferView|undefined} array
   * @returns {number} its address in the module's memory; 0: none */
  #copyIn(array) {
    if (array === undefined) return 0;
    const at = this.wasm.bridge_alloc(array.byteLength);
    if (at === 0) throw new Error('the page has no memory left');
    new Uint8Array(this.wasm.memory.buffer, at, array.byteLength)
      .set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
    return at;
  }

  /** Reads a model file. @param {Uint8Array} bytes
   * @returns {{counts: object, arrays: Object<string, ArrayBufferView>}} copies of its arrays */
  openModel(bytes) {
    const file = this.#copyIn(bytes);
    const status = this.wasm.bridge_open_model(file, bytes.length);
    this.wasm.bridge_free(file);
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
    return { counts: { rank, regions, masters }, unitEnergy: this.wasm.bridge_unit_energy(), arrays };
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
    const number = this.check(this.wasm.bridge_add_model(
      model.rank, model.vertex_count, model.triangle_count,
      model.arrays.point_weights?.length ?? 0, model.arrays.region_law?.length ?? 0, masters, ...at));
    for (const address of at.slice(kept.length)) this.wasm.bridge_free(address);
    this.models[number] = model;
    return number;
  }

  /** A model file with its whole mesh, which links and coupled bodies are made of; its bodies have no surface.
   * @param {Uint8Array} bytes @returns {number} */
  addWholeModel(bytes) {
    const { counts, arrays } = this.openModel(bytes);
    const number = this.check(this.wasm.bridge_keep_model());
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
    const at = this.wasm.bridge_group(model, text);
    this.wasm.bridge_free(text);
    if (at === 0) throw new Error(this.message);
    return Array.from(new Int32Array(this.wasm.memory.buffer, at, this.numbers[0]));
  }

  /** The numbers of a whole model's inertia. @returns {Float64Array} */
  inertia(model) {
    const { rank } = this.models[model];
    const count = 9 + 9 * rank * (rank + 1);
    const at = this.wasm.bridge_alloc(8 * count);
    const status = this.wasm.bridge_inertia(model, at);
    const numbers = new Float64Array(this.wasm.memory.buffer, at, count).slice();
    this.wasm.bridge_free(at);
    this.check(status);
    return numbers;
  }

  /** Links bodies of whole models as they are now. @returns {object} what a link of the pack has of its meshes */
  weighLink({ kind, body, other, vertices, other_vertices, place, other_place, axis, stiffness, length }) {
    const nowhere = [NaN, NaN, NaN];
    const lists = [vertices, other_vertices].map((of) => this.#copyIn(of && Int32Array.from(of)));
    this.numbers.set([...(place ?? nowhere), ...(other_place ?? nowhere), ...(axis ?? [0, 0, 1]), stiffness, length ?? -1]);
    const number = this.wasm.bridge_weigh_link(LINKS[kind], body, other ?? -1, lists[0], vertices?.length ?? 0,
      lists[1], other_vertices?.length ?? 0);
    for (const at of lists) this.wasm.bridge_free(at);
    this.check(this.wasm.bridge_link_made(this.check(number)));
    const made = Array.from(this.numbers.subarray(0, 33));
    const rows = (side, of) => Array.from(new Float64Array(this.wasm.memory.buffer, made[31 + side], 12 * this.report(of).rank));
    return { place: made.slice(0, 3), other_place: made.slice(3, 6), length: made[6], rest: made.slice(7, 19),
      rows: rows(0, body), other_rest: made.slice(19, 31), ...(other !== undefined && { other_rows: rows(1, other) }) };
  }

  /** The surface of an obstacle that is touched by its faces, about its own middle. @param {string} shape
   * @param {{size?: number[], radius?: number, height?: number, spacing?: number, heights?: number[][]}} sizes
   * @returns {{vertices: number[], triangles: number[]}} */
  solidSurface(shape, { size = [1, 1, 1], radius = 1, height = 1, spacing = 1, heights = [[]] }) {
    this.numbers.set([...size.map((side) => side / 2), radius, height, spacing]);
    this.#lend([heights.flat()], (at) => this.wasm.bridge_make_solid(SOLIDS[shape], heights.length, heights[0].length, at));
    const [vertexCount, vertices, triangleCount, triangles] = this.numbers;
    const { buffer } = this.wasm.memory;
    return { vertices: Array.from(new Float64Array(buffer, vertices, 3 * vertexCount)),
      triangles: Array.from(new Int32Array(buffer, triangles, 3 * triangleCount)) };
  }

  /** The body that lies deepest in something at present. @returns {{body: number, other: number, obstacle: number, solid: number,
   *   depth: number, diagonal: number}} -1 where there is none; obstacles and solids count by themselves */
  overlap() {
    this.check(this.wasm.bridge_find_overlap());
    const [body, other, obstacle, solid, depth, diagonal] = this.numbers;
    return { body, other, obstacle, solid, depth, diagonal };
  }

  /** Builds a scene of the pack's form in place of the one before. */
  build(scene) {
    this.check(this.wasm.bridge_begin(scene.dt));
    this.bodies = [];
    this.setGravity(scene.gravity);
    this.obstacles = scene.obstacles.map((obstacle) =>
      (obstacle.kind === 'solid' ? this.#addSolid(obstacle) : this.#addObstacle(obstacle)));
    for (const body of scene.bodies) this.#addBody(body, scene);
    if (scene.collisions) {
      const { thickness, friction, restitution, touches } = scene.collisions;
      this.numbers.set([thickness, friction, restitution]);
      this.check(this.wasm.bridge_set_collisions(touches));
    }
    for (const base_motion of scene.base_motion ?? []) this.#addBaseMotion(base_motion);
    if (scene.wind) {
      this.numbers.set([...scene.wind.velocity, scene.wind.density, scene.wind.drag]);
      this.check(this.wasm.bridge_set_wind());
    }
    this.links = (scene.links ?? []).map((link) => this.#addLink(link));
  }

  /** Calls with copies of arrays, which go afterwards. @param {(number[]|undefined)[]} arrays */
  #lend(arrays, call) {
    const at = arrays.map((array) => this.#copyIn(array && Float64Array.from(array)));
    const status = call(...at);
    for (const address of at) this.wasm.bridge_free(address);
    return this.check(status);
  }

  #addLoad(body, load) {
    const { rank } = this.bodies[body];
    const moving = [...(load.moments ?? Array(9).fill(0)), ...(load.resultant ?? [0, 0, 0])];
    const rows = [padded(load.reduced, 1, rank), load.parts && padded(load.parts, 9, rank)];
    this.numbers.set([...course(load), ...moving]);
    this.#lend(rows, (reduced, parts) =>
      this.wasm.bridge_add_load(body, COURSES[load.shape], reduced, parts));
  }

  #addBaseMotion(base_motion) {
    const { times, accelerations, velocities, positions } = base_motion;
    if (times) { // the scene keeps these
      const samples = [...times, ...accelerations, ...velocities, ...positions];
      this.check(this.wasm.bridge_add_motion(times.length,
        this.#copyIn(Float64Array.from(samples))));
      return;
    }
    this.numbers.set([...course(base_motion), ...base_motion.amplitude]);
    this.check(this.wasm.bridge_add_base_motion(COURSES[base_motion.shape]));
  }

  #addBody(body, scene) {
    this.numbers.set([...body.position, ...body.rotation, body.scale, body.stiffness, body.density,
      body.damping ?? scene.damping, 0, ...(body.velocity ?? [0, 0, 0]),
      ...(body.spin ?? [0, 0, 0]), body.condense ?? 0, body.collide === false ? 0 : 1,
      body.self_contact ? 1 : 0, body.coupled ? 1 : 0]);
    const integrator = INTEGRATORS[body.integrator ?? scene.integrator];
    const model = this.models[body.model];
    const start = [body.q, body.p].map((vector) => vector && padded(vector, 1, model.rank));
    const number = this.#lend(start, (q, p) => this.wasm.bridge_add_body(body.model, integrator,
      body.rank ?? 0, body.free ? 1 : 0, q, p));
    this.bodies[number] = model;
    for (const load of body.loads ?? []) this.#addLoad(number, load);
  }

  /** A link of ready sides. @returns {number} */
  #addLink(link) {
    const { body, other, times, places } = link;
    const rankOf = (rows) => (rows ? rows.length / 12 : 0);
    this.numbers.set([...link.place, ...link.other_place, link.stiffness, link.damping, link.length,
      link.until ?? Infinity, ...link.rest, ...link.other_rest]);
    return this.#lend([link.rows, link.other_rows, times, places], (rows, otherRows, at, where) =>
      this.wasm.bridge_add_link(LINKS[link.kind], body, other ?? -1, rankOf(link.rows), rows,
        rankOf(link.other_rows), otherRows, times?.length ?? 0, at, where));
  }

  /** A link of the scene as it is now. @param {number} n
   * @returns {{holds: boolean, places: number[], force: number[], drift: number, largestDrift: number,
   *   stored: number}} its two places, six numbers [m], force [N], drifts [m], energy [J] */
  link(n) {
    this.check(this.wasm.bridge_link(this.links[n]));
    const [holds, ...rest] = this.numbers.subarray(0, 13);
    const [drift, largestDrift, stored] = rest.slice(9);
    return { holds: holds === 1, places: rest.slice(0, 6), force: rest.slice(6, 9), drift, largestDrift, stored };
  }

  #addObstacle(obstacle) {
    const size = obstacle.size ?? [1, 1, 1];
    this.numbers.set([...obstacle.centre, ...(obstacle.normal ?? [0, 0, 1]),
      obstacle.radius ?? 1, ...size.map((side) => side / 2), ...(obstacle.rotation ?? [1, 0, 0, 0]),
      ...(obstacle.velocity ?? [0, 0, 0]), obstacle.friction ?? 0.5, obstacle.restitution ?? 0.5,
      obstacle.stiffness ?? 0, obstacle.damping ?? 0]);
    return this.check(
      this.wasm.bridge_add_obstacle(OBSTACLES[obstacle.kind], obstacle.inside ? 1 : 0));
  }

  /** An obstacle that is touched by its faces. @returns {number} of the solid */
  #addSolid({ centre, rotation, velocity, friction, restitution, ...of }) {
    const { vertices, triangles, times, places } = of;
    const corners = this.#copyIn(Int32Array.from(triangles));
    const way = times.length > 0 ? [times, places] : [undefined, undefined];
    this.numbers.set([...centre, ...(rotation ?? [1, 0, 0, 0]), ...velocity, friction, restitution]);
    const number = this.#lend([vertices, ...way], (points, at, where) =>
      this.wasm.bridge_add_solid(vertices.length / 3, points, triangles.length / 3, corners,
        times.length, at, where));
    this.wasm.bridge_free(corners);
    return number;
  }

  /** Where a solid of the scene's obstacles is now. @returns {number[]} 4 x 4, column by column */
  solidMatrix(number) {
    this.check(this.wasm.bridge_solid(this.obstacles[number]));
    return Array.from(this.numbers.subarray(0, 16));
  }

  /** Where the centre of an obstacle of the scene is now. @returns {number[]} */
  obstacleCentre(number) {
    this.check(this.wasm.bridge_obstacle(this.obstacles[number]));
    return Array.from(this.numbers.subarray(0, 3));
  }

  /** @param {number[]} gravity [m/s^2] */
  setGravity(gravity) {
    this.check(this.wasm.bridge_set_gravity(...gravity));
  }

  setDt(dt) {
    this.check(this.wasm.bridge_set_dt(dt));
  }

  setDamping(body, alpha) {
    this.check(this.wasm.bridge_set_damping(body, alpha, 0));
  }

  setStiffness(body, factor) {
    this.check(this.wasm.bridge_set_stiffness(body, factor));
  }

  /** @param {number} body @param {string} name */
  setIntegrator(body, name) {
    if (!(name in INTEGRATORS)) throw new Error(`there is no integrator '${name}'`);
    this.check(this.wasm.bridge_set_integrator(body, INTEGRATORS[name]));
  }

  setRank(body, rank) {
    this.check(this.wasm.bridge_set_rank(body, rank));
  }

  reset() {
    this.check(this.wasm.bridge_reset());
  }

  /** One step of all bodies; throws when one of them fails. */
  step() {
    this.check(this.wasm.bridge_step());
  }

  get time() {
    return this.wasm.bridge_time();
  }

  /** q as it is stepped. @returns {number[]} */
  coordinates(body) {
    const { rank } = this.report(body);
    this.check(this.wasm.bridge_coordinates(body));
    return Array.from(this.numbers.subarray(0, rank));
  }

  /** q of the model's full rank in single precision; valid until the next call. */
  shape(body) {
    this.check(this.wasm.bridge_shape(body, this.scratch));
    return new Float32Array(this.wasm.memory.buffer, this.scratch, this.bodies[body].rank);
  }

  /** Column-major 4 x 4 into the world. */
  matrix(body) {
    this.wasm.bridge_matrix(body);
    return this.numbers.subarray(0, 16);
  }

  energies(body) {
    this.check(this.wasm.bridge_energies(body));
    const [kinetic, potential, gravity, total] = this.numbers;
    return { kinetic, potential, gravity, total };
  }

  /**
   * Energies of all bodies together [J]; `contact` has what they hold between them, `links` the springs of links,
   * `lost` what bodies that met each other have lost since the start and is no part of the total.
   */
  account() {
    this.check(this.wasm.bridge_account());
    const [kinetic, potential, gravity, contact, links, total, lost] = this.numbers;
    return { kinetic, potential, gravity, contact, links, total, lost };
  }

  report(body) {
    this.check(this.wasm.bridge_body(body));
    const [status, rank, explicit, implicit, iterations, scheme, fallbacks, integrator,
      firstSwitch, grown] = this.numbers;
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
      this.wasm.bridge_stepped_frequencies(body), rank));
  }

  /** Frequencies of the modes of the body [Hz]. */
  frequencies(body) {
    const { rank } = this.report(body);
    const omega2 = new Float64Array(this.wasm.memory.buffer, this.wasm.bridge_omega2(body), rank);
    return Array.from(omega2, (w2) => Math.sqrt(w2) / (2 * Math.PI));
  }

  /** Position of a vertex in the world [m]. @returns {number[]} */
  position(body, vertex) {
    this.check(this.wasm.bridge_vertex(body, vertex));
    return Array.from(this.numbers.subarray(0, 3));
  }

  /** A spring from a vertex to a point, `strength` times as stiff as the body is there.
   * @returns {number} to move and to end it by */
  startPull(body, vertex, target, strength) {
    this.numbers.set(target);
    return this.check(this.wasm.bridge_pull_start(body, vertex, strength));
  }

  movePull(pull, target) {
    this.numbers.set(target);
    this.check(this.wasm.bridge_pull_move(pull));
  }

  /** Where a pulled vertex is [m], and the mean force of the last step on it [N]. */
  pull(pull) {
    this.check(this.wasm.bridge_pull(pull));
    return { point: Array.from(this.numbers.subarray(0, 3)), force: Array.from(this.numbers.subarray(3, 6)) };
  }

  /** Places where bodies touch obstacles or each other now [m], three numbers each, valid until the
   * next call. @returns {Float32Array} */
  touches() {
    const at = this.wasm.bridge_touches();
    const count = this.check(this.wasm.bridge_touch_count());
    return new Float32Array(this.wasm.memory.buffer, at, 3 * count);
  }

  endPull(pull) {
    this.check(this.wasm.bridge_pull_end(pull));
  }

  /** The first vertex that a ray meets; null: none. @param {number[]} origin
   * @param {number[]} direction @returns {Pick|null} */
  pick(origin, direction) {
    this.numbers.set([...origin, ...direction]);
    if (!this.wasm.bridge_pick()) return null;
    const [body, vertex, distance] = this.numbers;
    return { body, vertex, distance };
  }
}
