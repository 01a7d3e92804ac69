// Scenes: placed bodies and what acts on them. SPDX-License-Identifier: Apache-2.0
import { withDef } from './fields.js';
import { Owned, Resource, ThrumError, doubles, snapshotBytes, steps } from './memory.js';
import { integratorNumber, knownOptions } from './model.js';

const LINKS = ['spring', 'ball', 'hinge', 'weld']; // in the order of thrum_link_kind
const LOADS = ['force', 'acceleration', 'field']; // kinds of loads that name what acts
const DETAIL_OPTIONS = ['masters', 'beyond', 'still', 'jump'];

export class Scene extends Resource {
  #memory;
  #bodies = [];
  #links = [];

  constructor(memory, { dt = 0.003, gravity } = {}) {
    const { calls } = memory;
    super('scene', new Owned(memory.made(calls.js_scene_create(dt)),
      (at) => calls.js_scene_destroy(at)));
    this.#memory = memory;
    if (gravity !== undefined) this.setGravity(gravity);
  }

  /** Calls a function of the bridge on this scene with numbers. */
  call(name, numbers, ...rest) {
    const { calls } = this.#memory;
    if (numbers !== undefined) this.#memory.numbers.set(numbers);
    return this.#memory.check(calls[name](this.address, ...rest));
  }

  /** The first results of a call. */
  results(count) {
    return Array.from(this.#memory.numbers.subarray(0, count));
  }

  addBody(model, options = {}) {
    const { integrator = 'energy', dampingAlpha = 0, dampingBeta = 0, touch, ...given } = options;
    if (touch === 'all' && given.triangles === undefined)
      throw new ThrumError("touch: 'all' means the vertices of the triangles, and there are none", -1);
    const fields = { ...given, touch: touch === 'all' ? new Set(given.triangles) : touch };
    const chosen = integratorNumber(this.#memory, integrator);
    const number = withDef(this.#memory, 'body', fields, () => this.call('js_scene_add_body', undefined,
      this.#memory.calls.js_model_pointer(model.address), chosen, dampingAlpha, dampingBeta, 0, 0), model.vertexCount);
    // the scene reads the model until it is gone itself
    this.owned.lean(model.owned);
    const body = new Body(this.#memory, this, number, model);
    this.#bodies.push(body);
    return body;
  }

  get bodies() {
    return [...this.#bodies];
  }

  setGravity(gravity) {
    this.call('js_scene_gravity', doubles(gravity, 3, 'gravity'));
  }

  setWind(velocity, options = {}) {
    withDef(this.#memory, 'wind', { ...options, velocity }, () => this.call('js_scene_wind'));
  }

  addObstacle(obstacle) {
    return this.#obstacle(-1, obstacle);
  }

  setObstacle(number, obstacle) {
    if (!Number.isInteger(number) || number < 0)
      throw new ThrumError(`there is no obstacle ${number}`, -1);
    this.#obstacle(number, obstacle);
  }

  #obstacle(number, { rotation, ...obstacle }) {
    const turned = rotation && doubles(rotation, 4, 'rotation');
    return withDef(this.#memory, 'obstacle', obstacle, () => {
      if (turned) this.#memory.numbers.set(turned);
      if (turned) this.#memory.check(this.#memory.calls.js_obstacle_turn());
      return this.call('js_scene_obstacle', undefined, number);
    });
  }

  addSolid(solid) {
    return withDef(this.#memory, 'solid', solid, () => this.call('js_scene_add_solid'));
  }

  addLink(link) {
    const { body, vertices: _, vertex, group, other, otherVertices, otherGroup, ...fields } = link;
    const [first, second] = [this.#own(body), other === undefined ? -1 : this.#own(other)];
    if (second < 0 && (otherVertices ?? otherGroup) !== undefined)
      throw new ThrumError('otherVertices: the world has none', -1);
    if ((fields.pathTimes === undefined) !== (fields.pathPlaces === undefined))
      throw new ThrumError('pathTimes and pathPlaces come together', -1);
    const given = { ...fields, vertices: body.model.chosen({ vertices: link.vertices, vertex, group }),
      otherVertices: other?.model.chosen({ vertices: otherVertices, group: otherGroup }) };
    const number = withDef(this.#memory, 'link', given, () => this.call('js_scene_add_link', undefined, first, second));
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
    withDef(this.#memory, 'pairs', options || {}, () => this.call('js_scene_set_collisions', undefined, options === false ? 0 : 1));
  }

  get collisions() {
    this.#memory.calls.js_scene_collisions(this.address);
    const [touching, declined, distance, depth, deepestShare, normal, stored, lost] = this.results(8);
    return { touching, declined, distance, depth, deepestShare, normal, stored, lost };
  }

  findOverlap() {
    this.call('js_scene_overlap');
    const [body, other, obstacle, depth, solid] = this.results(5);
    if (body < 0) return undefined;
    return { body: this.#bodies[body], other: this.#bodies[other], depth, obstacle: obstacle < 0 ? undefined : obstacle,
      solid: solid < 0 ? undefined : solid };
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
    const { ramp, start, vertices: _, vertex, group, force, acceleration, field, ...course } = load;
    const given = { force, acceleration, field };
    const kinds = LOADS.filter((kind) => given[kind] !== undefined);
    if (kinds.length !== 1) throw new ThrumError('a load is one of force, field and acceleration', -1);
    if (ramp && course.frequency !== undefined) throw new ThrumError('a load is a ramp or a sine, not both', -1);
    const curved = course.frequency === undefined ? undefined : 'sine';
    withDef(this.#memory, 'load', { kind: kinds[0], vector: force ?? acceleration, field, from: start,
      vertices: this.model.chosen({ vertices: load.vertices, vertex, group }), shape: ramp ? 'ramp' : curved, ...course },
    () => this.scene.call('js_scene_load', undefined, this.number), this.model.vertexCount);
  }

  pull(vertex, target, { stiffness, damping = -1 }) {
    const number = this.scene.call('js_pull_start', [...doubles(target, 3, 'target'), stiffness, damping],
      this.number, vertex);
    return new Pull(this.scene, number);
  }
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
