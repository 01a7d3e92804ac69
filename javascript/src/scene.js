// Scenes: placed bodies and what acts on them. SPDX-License-Identifier: Apache-2.0
import { Owned, Resource, ThrumError, doubles, snapshotBytes, steps, vertices } from './memory.js';
import { integratorNumber, knownOptions } from './model.js';

const SHAPES = { plane: 0, sphere: 1, box: 2 };
const LINKS = ['spring', 'ball', 'hinge', 'weld']; // in the order of thrum_link_kind
const FORCE = 0;
const ACCELERATION = 2;
const BODY_OPTIONS = ['position', 'rotation', 'scale', 'stiffness', 'density', 'dampingAlpha',
  'dampingBeta', 'velocity', 'spin', 'integrator', 'rank', 'condense', 'free', 'coupled', 'startMode',
  'startAmplitude', 'triangles', 'touch', 'collides', 'selfContact'];
const COLLISION_OPTIONS = ['thickness', 'friction', 'restitution'];
const DETAIL_OPTIONS = ['masters', 'beyond', 'still', 'jump'];
const OBSTACLE_OPTIONS = ['shape', 'inside', 'centre', 'normal', 'radius', 'half', 'rotation',
  'velocity', 'friction', 'restitution', 'stiffness', 'damping'];
const LOAD_OPTIONS = ['force', 'acceleration', 'vertices', 'vertex', 'group', 'start', 'until',
  'frequency'];
const LINK_OPTIONS = ['kind', 'body', 'place', 'vertices', 'vertex', 'group', 'other', 'otherPlace',
  'otherVertices', 'otherGroup', 'axis', 'stiffness', 'damping', 'length', 'pathTimes', 'pathPlaces', 'until'];
const NOWHERE = [NaN, NaN, NaN];
const ZERO = [0, 0, 0];
const PATH_MOST = 2 ** 24; // times of a path, as thrum_scene_link_def has it
const UPRIGHT = [1, 0, 0, 0];

export class Scene extends Resource {
  #memory;
  #bodies = [];
  #links = [];

  constructor(memory, { dt = 0.003, gravity } = {}) {
    const { calls } = memory;
    super('scene', new Owned(memory.made(calls.js_scene_make(dt), calls.js_scene_message),
      (at) => calls.js_scene_free(at)));
    this.#memory = memory;
    if (gravity !== undefined) this.setGravity(gravity);
  }

  /** Calls a function of the bridge on this scene with numbers. */
  call(name, numbers, ...rest) {
    const { calls } = this.#memory;
    if (numbers !== undefined) this.#memory.numbers.set(numbers);
    return this.#memory.check(calls[name](this.address, ...rest), calls.js_scene_message);
  }

  /** The first results of a call. */
  results(count) {
    return Array.from(this.#memory.numbers.subarray(0, count));
  }

  addBody(model, options = {}) {
    knownOptions(options, BODY_OPTIONS, 'a body');
    const given = { position: ZERO, rotation: UPRIGHT, velocity: ZERO, spin: ZERO, ...options };
    const triangles = options.triangles && vertices(options.triangles, model.vertexCount, 'triangles');
    const touch = this.#touching(options.touch, triangles, model);
    const integrator = integratorNumber(this.#memory, options.integrator ?? 'energy');
    const numbers = [...doubles(given.position, 3, 'position'), ...doubles(given.rotation, 4, 'rotation'),
      given.scale ?? 1, given.stiffness ?? 1, given.density ?? 1, given.dampingAlpha ?? 0,
      given.dampingBeta ?? 0, ...doubles(given.velocity, 3, 'velocity'), ...doubles(given.spin, 3, 'spin'),
      given.startAmplitude ?? 0];
    const number = this.#memory.lend([triangles, touch], (faces, points) => this.call(
      'js_scene_add_body', numbers, model.address, integrator, given.rank ?? 0, given.condense ?? 0,
      given.free ? 1 : 0, given.coupled ? 1 : 0, given.collides ?? true ? 1 : 0, given.selfContact ? 1 : 0, given.startMode ?? 0, faces, (triangles?.length ?? 0) / 3, points, touch?.length ?? 0));
    // the scene reads the model until it is gone itself
    this.owned.lean(model.owned);
    const body = new Body(this.#memory, this, number, model);
    this.#bodies.push(body);
    return body;
  }

  #touching(touch, triangles, model) {
    if (touch === undefined) return undefined;
    if (touch !== 'all') return vertices(touch, model.vertexCount, 'touch');
    if (triangles === undefined)
      throw new ThrumError("touch: 'all' means the vertices of the triangles, and there are none", -1);
    return Int32Array.from(new Set(triangles));
  }

  get bodies() {
    return [...this.#bodies];
  }

  setGravity(gravity) {
    this.call('js_scene_gravity', doubles(gravity, 3, 'gravity'));
  }

  setWind(velocity, { density = 1.2, drag = 1 } = {}) {
    this.call('js_scene_wind', [...doubles(velocity, 3, 'velocity'), density, drag]);
  }

  addObstacle(obstacle) {
    return this.#obstacle(-1, obstacle);
  }

  setObstacle(number, obstacle) {
    if (!Number.isInteger(number) || number < 0)
      throw new ThrumError(`there is no obstacle ${number}`, -1);
    this.#obstacle(number, obstacle);
  }

  #obstacle(number, obstacle) {
    knownOptions(obstacle, OBSTACLE_OPTIONS, 'an obstacle');
    const shape = SHAPES[obstacle.shape ?? 'plane'];
    if (shape === undefined)
      throw new ThrumError(`'${obstacle.shape}' is no shape; there are ${Object.keys(SHAPES).join(', ')}`, -1);
    const numbers = [...doubles(obstacle.centre ?? ZERO, 3, 'centre'),
      ...doubles(obstacle.normal ?? [0, 0, 1], 3, 'normal'), obstacle.radius ?? 1,
      ...doubles(obstacle.half ?? [1, 1, 1], 3, 'half'), ...doubles(obstacle.rotation ?? UPRIGHT, 4, 'rotation'),
      ...doubles(obstacle.velocity ?? ZERO, 3, 'velocity'), obstacle.friction ?? 0.5,
      obstacle.restitution ?? 0.5, obstacle.stiffness ?? 0, obstacle.damping ?? 0];
    return this.call('js_scene_obstacle', numbers, number, shape, obstacle.inside ? 1 : 0);
  }

  addLink(link) {
    knownOptions(link, LINK_OPTIONS, 'a link');
    const kind = LINKS.indexOf(link.kind);
    if (kind < 0) throw new ThrumError(`'${link.kind}' is no link; there are ${LINKS.join(', ')}`, -1);
    const [body, other] = [this.#own(link.body), link.other === undefined ? -1 : this.#own(link.other)];
    if (link.length !== undefined && !(link.length >= 0))
      throw new ThrumError(`length: ${link.length} is below 0`, -11);
    const chosen = link.body.model.chosen(link);
    const { otherVertices, otherGroup } = link;
    if (other < 0 && (otherVertices ?? otherGroup) !== undefined)
      throw new ThrumError('otherVertices: the world has none', -1);
    const otherChosen = link.other?.model.chosen({ vertices: otherVertices, group: otherGroup });
    const [times, places] = pathOf(link);
    const numbers = [...doubles(link.place ?? NOWHERE, 3, 'place', true), ...doubles(link.otherPlace ?? NOWHERE, 3, 'otherPlace', true),
      ...doubles(link.axis ?? [0, 0, 1], 3, 'axis'), link.stiffness ?? 0, link.damping ?? 0, link.length ?? -1,
      link.until ?? Infinity];
    const number = this.#memory.lend([chosen, otherChosen, times, places], (at, otherAt, timesAt, placesAt) =>
      this.call('js_scene_add_link', numbers, kind, body, other, at, chosen?.length ?? 0, otherAt,
        otherChosen?.length ?? 0, timesAt, placesAt, times?.length ?? 0));
    const made = new Link(this, number);
    this.#links.push(made);
    return made;
  }

  /** The number of a body of this scene. */
  #own(body) {
    if (!(body instanceof Body) || body.scene !== this) throw new ThrumError('a link is of bodies of its own scene', -1);
    return body.number;
  }

  get links() {
    return [...this.#links];
  }

  setCollisions(options = {}) {
    if (options === false) {
      this.call('js_scene_set_collisions', [0, 0, 0], 0);
      return;
    }
    knownOptions(options, COLLISION_OPTIONS, 'contact between bodies');
    const { thickness = 0, friction = 0.5, restitution = 0.5 } = options;
    this.call('js_scene_set_collisions', [thickness, friction, restitution], 1);
  }

  get collisions() {
    this.#memory.calls.js_scene_collisions(this.address);
    const [touching, declined, distance, depth, deepestShare, normal, stored, lost] = this.results(8);
    return { touching, declined, distance, depth, deepestShare, normal, stored, lost };
  }

  findOverlap() {
    this.call('js_scene_overlap');
    const [body, other, obstacle, depth] = this.results(4);
    if (body < 0) return undefined;
    return { body: this.#bodies[body], other: this.#bodies[other], depth,
      obstacle: obstacle < 0 ? undefined : obstacle };
  }

  get account() {
    this.call('js_scene_account');
    const found = this.results(12);
    const [kinetic, potential, gravity, contact, total] = found;
    return { kinetic, potential, gravity, contact, links: found[11], total, momentum: found.slice(5, 8),
      angularMomentum: found.slice(8, 11) };
  }

  setEye(place) {
    this.call('js_scene_eye', doubles(place, 3, 'eye'));
  }

  updateDetail() {
    this.call('js_scene_update_detail');
  }

  step(count = 1) {
    let worst = 0;
    steps(count);
    for (let done = 0; done < count; done += 1) {
      const status = this.call('js_scene_step');
      if (status > 0 && (worst === 0 || status < worst)) worst = status;
    }
    return worst;
  }

  get time() {
    return this.#memory.calls.js_scene_time(this.address);
  }

  setDt(dt) {
    this.call('js_scene_dt', undefined, dt);
  }

  reset() {
    this.call('js_scene_reset');
  }

  snapshot() {
    const size = this.#memory.calls.js_scene_snapshot_size(this.address);
    return this.#memory.take(Uint8Array, size, (at) => this.call('js_scene_snapshot', undefined, at, size));
  }

  restore(snapshot) {
    this.#memory.lend([snapshotBytes(snapshot)], (at) =>
      this.call('js_scene_restore', undefined, at, snapshot.length));
  }
}

export class Body {
  #memory;

  constructor(memory, scene, number, model) {
    this.#memory = memory;
    this.scene = scene;
    this.number = number;
    this.model = model;
  }

  #coordinates(momenta) {
    const { shown } = this.info;
    return this.#memory.take(Float64Array, shown, (at) => this.scene.call('js_body_coordinates',
      undefined, this.number, momenta ? 0 : at, momenta ? at : 0));
  }

  get q() {
    return this.#coordinates(false);
  }

  get p() {
    return this.#coordinates(true);
  }

  get info() {
    this.scene.call('js_body_info', undefined, this.number);
    const [status, rank, shown, touching, scheme, fallbackSteps, grownSteps, switchedSteps] =
      this.scene.results(8);
    return { status, rank, shown, touching, fallbackSteps, grownSteps, switchedSteps,
      scheme: this.#memory.text(this.#memory.calls.js_name(scheme, 1)) };
  }

  setDetail(detail) {
    if (detail === undefined) {
      this.scene.call('js_body_set_detail', [0, 0, 0], this.number, 0);
      return;
    }
    knownOptions(detail, DETAIL_OPTIONS, 'a level of detail');
    const { masters, jump, beyond = 0, still = 0 } = detail;
    if (!(masters > 0)) throw new ThrumError(`masters: ${masters} is no number of coordinates`, -1);
    this.scene.call('js_body_set_detail', [beyond, still, jump ?? NaN], this.number, masters);
  }

  get detail() {
    this.scene.call('js_body_detail', undefined, this.number);
    const [reduced, changes, reducedSteps, largestJump, energy] = this.scene.results(5);
    return { reduced: reduced === 1, changes, reducedSteps, largestJump, energy };
  }

  get energies() {
    this.scene.call('js_body_energies', undefined, this.number);
    const [kinetic, potential, gravity, contact, total] = this.scene.results(5);
    return { kinetic, potential, gravity, contact, total };
  }

  get matrix() {
    this.#memory.calls.js_body_matrix(this.scene.address, this.number);
    return this.scene.results(16);
  }

  positions(surface, out) {
    const into = surface.room(out);
    return this.#memory.take(Float32Array, into.length, (at) => this.scene.call('js_body_positions',
      undefined, this.number, surface.address, at), into);
  }

  vertex(vertex) {
    this.scene.call('js_body_vertex', undefined, this.number, vertex);
    const found = this.scene.results(6);
    return { position: found.slice(0, 3), velocity: found.slice(3) };
  }

  setDamping(alpha, beta = 0) {
    this.scene.call('js_body_damping', undefined, this.number, alpha, beta);
  }

  addLoad(load) {
    knownOptions(load, LOAD_OPTIONS, 'a load');
    if ((load.force === undefined) === (load.acceleration === undefined))
      throw new ThrumError('a load is one of force and acceleration', -1);
    const kind = load.force === undefined ? ACCELERATION : FORCE;
    const vector = doubles(load.force ?? load.acceleration, 3, 'a load');
    const chosen = this.model.chosen(load);
    const numbers = [...vector, load.start ?? 0, load.until ?? Infinity, load.frequency ?? 0];
    this.#memory.lend([chosen], (at) => this.scene.call('js_scene_load', numbers, this.number, kind,
      load.frequency === undefined ? 0 : 1, at, chosen?.length ?? 0));
  }

  pull(vertex, target, { stiffness, damping = -1 }) {
    const number = this.scene.call('js_pull_start', [...doubles(target, 3, 'target'), stiffness, damping],
      this.number, vertex);
    return new Pull(this.scene, number);
  }
}

/** The path of a link's end: times, and three numbers for each of them. */
function pathOf({ pathTimes, pathPlaces }) {
  if ((pathTimes === undefined) !== (pathPlaces === undefined))
    throw new ThrumError('pathTimes and pathPlaces come together', -1);
  if (pathTimes === undefined) return [undefined, undefined];
  if (!(pathTimes.length <= PATH_MOST)) throw new ThrumError(`pathTimes: an array of at most ${PATH_MOST} times`, -1);
  const times = doubles(pathTimes, pathTimes.length, 'pathTimes');
  return [times, doubles(pathPlaces, 3 * times.length, 'pathPlaces')];
}

export class Link {
  constructor(scene, number) {
    this.scene = scene;
    this.number = number;
  }

  #get() {
    this.scene.call('js_link_get', undefined, this.number);
    return this.scene.results(22);
  }

  get kind() {
    return LINKS[this.#get()[0]];
  }

  get holds() {
    return this.#get()[1] === 1;
  }

  get bodies() {
    const [, , first, second] = this.#get();
    return [this.scene.bodies[first], this.scene.bodies[second]];
  }

  get length() {
    return this.#get()[4];
  }

  get places() {
    const found = this.#get();
    return [found.slice(5, 8), found.slice(8, 11)];
  }

  get force() {
    return this.#get().slice(11, 14);
  }

  get torque() {
    return this.#get().slice(14, 17);
  }

  get report() {
    const [drift, largestDrift, stored, lost, driven] = this.#get().slice(17);
    return { drift, largestDrift, stored, lost, driven };
  }

  release() {
    this.scene.call('js_link_release', undefined, this.number);
  }
}

export class Pull {
  #scene;
  #number;

  constructor(scene, number) {
    this.#scene = scene;
    this.#number = number;
  }

  move(target) {
    this.#scene.call('js_pull_move', doubles(target, 3, 'target'), this.#number);
  }

  end() {
    this.#scene.call('js_pull_end', undefined, this.#number);
  }

  get force() {
    this.#scene.call('js_pull_get', undefined, this.#number);
    return this.#scene.results(6).slice(3);
  }
}
