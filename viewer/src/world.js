// What is simulated and shown at present: a scene in the engine, its bodies in the picture.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';
import { Body } from './body.js';
import { boundsOfMotion, boundsOfObstacle, boundsOfSwings } from './bounds.js';
import { leastTop, quantitiesOf } from './colours.js';
import { LinkMarks, OPEN, stateOf } from './link_marks.js';
import { LEVELS, QUALITIES, QualityChooser, atLeast } from './quality.js';
import { Marks } from './marks.js';
import { fewestStepped, mostStepped } from './pack.js';
import { Orbit } from './orbit.js';
import { Recording } from './recording.js';
import { coordinatesTexture } from './shader.js';
import { aloneScene, comparedScene, isComposed } from './scenes.js';

/** What the panel changes while bodies move.
 * @typedef {{dt: number, integrator: string, rank: number, gravity: number, damping: number,
 *   stiffness: number, pull: number, magnify: number, colour: string, edges: boolean, held: boolean,
 *   touches: boolean, links: boolean, quality: string, sound: boolean}} Settings */

export const SHOWN = ['colour', 'edges', 'held', 'touches', 'links', 'quality', 'magnify']; // settings of the picture alone
const TOUCH_COLOUR = 0xe07b00;

export class World {
  /** @param {import('./pack.js').Pack} pack @param {import('./engine.js').Engine} engine
   * @param {import('./stage.js').Stage} stage */
  constructor(pack, engine, stage) {
    Object.assign(this, { stage, bodies: [], pulls: new Map(), compared: false });
    this.settings = { pull: 10, colour: 'own', edges: false, held: true, touches: true, links: true,
      quality: 'auto', sound: false, magnify: 1 };
    this.marks = new Marks(stage.scene, TOUCH_COLOUR);
    this.linkMarks = new LinkMarks(stage.scene);
    this.own = pack.models; // which scenes that are dropped may name, whatever was dropped before
    this.adopt(pack, engine);
  }

  /** Takes another pack in place of the one before; show() then shows it.
   * @param {import('./pack.js').Pack} pack @param {import('./engine.js').Engine} engine without models, or with those of the pack */
  adopt(pack, engine) {
    if (engine.models.length === 0) pack.models.forEach((model) => engine.addModel(model));
    Object.assign(this, { pack, engine });
    this.#clear();
    this.recording = pack.recording ? new Recording(pack.recording, pack) : pack.curve && new Orbit(pack.curve, pack);
    this.choice = isComposed(pack) ? -1 : pack.scene.bodies[0].model;
    if (pack.curve) this.settings.colour = 'displacement'; // a body moves little at many of its points
    if (!quantitiesOf(pack).includes(this.settings.colour)) this.settings.colour = 'own';
  }

  // without bodies, which belong to the pack
  #clear() {
    for (const body of this.bodies) {
      this.stage.scene.remove(body.mesh);
      body.dispose();
    }
    this.bodies = [];
  }

  /** Is a recorded run or a curve shown, which nothing acts on? */
  get plays() {
    return this.recording !== undefined && this.choice < 0;
  }

  /** The motion of a curve, where one is shown. @returns {Orbit|undefined} */
  get orbit() {
    return this.plays && this.recording instanceof Orbit ? this.recording : undefined;
  }

  /** The point of the curve that is shown, from 1. */
  get point() {
    return this.orbit && this.orbit.row + 1;
  }

  /** What says where bodies are: the recording, or the engine that steps them. */
  get motion() {
    return this.plays ? this.recording : this.engine;
  }

  /** Shows a scene at its start. @param {number} choice a model, or -1: the pack's scene
   * @param {boolean} compared copies side by side, which keep the settings */
  show(choice, compared) {
    const fresh = choice !== this.choice || this.bodies.length === 0;
    const own = choice < 0 ? this.pack.scene : aloneScene(this.pack, choice);
    const shown = compared ? comparedScene(this.pack, own) : own; // which may be refused
    Object.assign(this, { choice, compared, shown });
    if (fresh) this.#settle(own);
    this.pulls.clear();
    if (this.plays) this.recording.seek(this.recording.begin);
    else this.engine.build(this.shown);
    this.#populate();
    if (fresh) this.settings.magnify = this.orbit ? this.orbit.magnification(this.bodies[0].size) : 1;
    this.#applyAll(own);
  }

  // settings as the scene has them
  #settle(scene) {
    const [first] = scene.bodies;
    const length = Math.hypot(...scene.gravity);
    this.down = length > 0 ? scene.gravity.map((g) => g / length) : [0, 0, -1];
    Object.assign(this.settings, {
      dt: scene.dt, integrator: first.integrator ?? scene.integrator, gravity: length,
      damping: first.damping ?? scene.damping, stiffness: 1,
      rank: first.rank || mostStepped(this.pack.models[first.model]),
    });
  }

  // a scene with bodies of several kinds keeps what each was given, until a control is moved
  #applyAll(scene) {
    const names = [...SHOWN];
    if (!this.plays) names.push('dt', 'gravity');
    if (!this.plays && scene.bodies.length === 1) names.push('damping', 'stiffness', 'rank', 'integrator');
    for (const name of names) this.set(name, this.settings[name]);
  }

  #populate() {
    this.#clear();
    this.coordinates?.dispose();
    const models = this.shown.bodies.map((body) => this.pack.models[body.model]);
    this.width = Math.max(...models.map(({ rank }) => rank));
    this.coordinates = coordinatesTexture(this.width, models.length);
    const rows = this.stage.renderer.capabilities.maxTextureSize;
    this.bodies = this.shown.bodies.map((from, n) =>
      new Body(models[n], from, n, this.coordinates, rows));
    const boxes = this.bodies.map(({ mesh }, n) => {
      this.stage.scene.add(mesh);
      return mesh.geometry.boundingBox.clone().applyMatrix4(new THREE.Matrix4().fromArray(this.motion.matrix(n)));
    });
    const bounds = boxes.reduce((all, box) => all.union(box), new THREE.Box3());
    for (const obstacle of this.shown.obstacles) bounds.union(boundsOfObstacle(obstacle));
    const height = bounds.max.z - bounds.min.z;
    const below = this.bodies.every((body) => body.stands) ? 0.002 * height : 2 * height;
    this.stage.furnish(this.shown.obstacles, bounds, bounds.min.z - below);
    this.stage.look(this.#withMotion(boxes, bounds));
  }

  // the bounds of all that stands, wider by where bodies will be
  #withMotion(boxes, bounds) {
    const wider = (all, box) => all.union(box);
    if (this.plays)
      return boxes.map((_, n) => boundsOfMotion(this.recording, n, this.bodies[n].mesh.geometry.boundingBox, bounds))
        .reduce(wider, bounds.clone());
    const joints = (this.shown.links ?? []).flatMap(({ kind, body, other, rest }, n) => {
      if (kind === 'spring') return [];
      const turn = new THREE.Matrix4().fromArray(this.motion.matrix(body));
      const axis = kind === 'hinge' ? new THREE.Vector3().fromArray(rest, 3).transformDirection(turn) : undefined;
      return [{ kind, body, other, place: new THREE.Vector3(...this.engine.link(n).places.slice(0, 3)), axis }];
    });
    const bodies = this.shown.bodies.map(({ free }, n) => ({ free, box: boxes[n] }));
    return boundsOfSwings(bodies, joints, new THREE.Vector3(...this.shown.gravity)).reduce(wider, bounds.clone());
  }

  /** Changes one setting of all bodies. @param {keyof Settings} name */
  set(name, value) {
    if (name === 'colour' && !quantitiesOf(this.pack).includes(value))
      throw new Error(`there are no colours of '${value}' for these bodies`);

    // of a link that was made for another model: no body has more coordinates than its model
    if (name === 'rank') {
      const most = Math.max(...this.bodies.map(({ model }) => mostStepped(model)));
      value = Math.min(Math.max(1, Math.round(value)), most);
    }
    const { engine } = this;
    const each = (change) => this.bodies.forEach((_, n) => change(n));
    const changes = {
      dt: () => engine.setDt(value),
      gravity: () => engine.setGravity(this.down.map((d) => d * value)),
      damping: () => each((n) => engine.setDamping(n, value)),
      stiffness: () => each((n) => engine.setStiffness(n, value * this.shown.bodies[n].stiffness)),
      rank: () => this.#loose(new Set([...this.#tied(), ...this.#coupled()])).forEach((n) => this.#setRank(n, value)),
      integrator: () => this.compared || this.#loose(this.#coupled()).forEach((n) => engine.setIntegrator(n, value)),
      pull: () => {
        if (!(value > 0)) throw new Error(`a pull is a spring of a stiffness above 0, not ${value}`);
      },
      colour: () => this.#forgetColours(),
      edges: () => this.bodies.forEach((body) => body.showEdges(value)),
      held: () => this.bodies.forEach((body) => body.showHeld(value, this.stage.heldColour)),
      touches: () => {},
      links: () => {},
      sound: () => {},
      quality: () => this.#setQuality(value),
      magnify: () => {
        if (!(value > 0)) throw new Error(`displacements are drawn larger by a number above 0, not ${value}`);
      },
    };
    changes[name]();
    this.stage.touch();
    this.settings[name] = value;
    if (name === 'pull' || name === 'stiffness') this.#pullAgain();
  }

  // a body that is linked takes no number, not even the one that it has
  #setRank(body, asked) {
    const { model } = this.bodies[body];
    const rank = Math.min(Math.max(asked, fewestStepped(model)), mostStepped(model));
    if (rank !== this.engine.report(body).rank) this.engine.setRank(body, rank);
  }

  // bodies that keep their rank, and those that keep their rank and integrator
  #tied() {
    return new Set((this.shown.links ?? []).flatMap(({ body, other }) => [body, other]));
  }

  #coupled() {
    return new Set([...this.shown.bodies.keys()].filter((n) => this.shown.bodies[n].coupled));
  }

  // the bodies that a change is for: those that may take it; where none may, all, for the engine says why not
  #loose(bound) {
    const all = [...this.bodies.keys()];
    const loose = all.filter((n) => !bound.has(n));
    return loose.length > 0 ? loose : all;
  }

  /** How many bodies each of the compared copies has, or all. */
  get each() {
    return this.compared ? this.bodies.length / this.shown.copies.length : this.bodies.length;
  }

  /** Begins a pull at a vertex, of each copy where bodies are compared.
   * @param {number} id of the pointer @param {number} body @param {number} vertex
   * @param {number[]} target [m] */
  startPull(id, body, vertex, target) {
    const { each } = this;
    const copies = this.compared ? this.shown.copies.map((_, n) => n * each + (body % each)) : [body];
    // a body takes so many pulls and no more, and copies have as many: the first one may refuse
    const springs = copies.map((copy) => ({ copy, number: this.engine.startPull(copy, vertex,
      this.#beside(target, body, copy), this.settings.pull) }));
    this.stage.touch();
    this.pulls.set(id, { body, vertex, target, springs });
  }

  // a place at one body as it is at a copy of it
  #beside(target, body, copy) {
    const from = this.shown.bodies[body].position;
    const to = this.shown.bodies[copy].position;
    return target.map((x, axis) => x + to[axis] - from[axis]);
  }

  movePull(id, target) {
    const pull = this.pulls.get(id);
    pull.target = target;
    this.stage.touch();
    for (const { copy, number } of pull.springs)
      this.engine.movePull(number, this.#beside(target, pull.body, copy));
  }

  endPull(id) {
    const { springs } = this.pulls.get(id);
    this.pulls.delete(id);
    this.stage.touch();
    for (const { number } of springs) this.engine.endPull(number);
  }

  // with the strength as it is now
  #pullAgain() {
    for (const [id, { body, vertex, target }] of [...this.pulls]) {
      this.endPull(id);
      this.startPull(id, body, vertex, target);
    }
  }

  reset() {
    for (const id of [...this.pulls.keys()]) this.endPull(id);
    this.#forgetColours();
    this.stage.touch();
    if (this.plays) this.recording.seek(this.recording.begin);
    else this.engine.reset();
  }

  #setQuality(name) {
    if (!QUALITIES.includes(name)) throw new Error(`there is no quality '${name}'`);
    if (name === 'auto') this.chooser ??= new QualityChooser();
    this.#refine(name === 'auto' ? this.chooser.level : name);
  }

  /** Draws at least as finely as the page is, whatever time that takes, while a video is recorded; the level then stays, for a video
   * has one size. A level that a person chose stays, too. @param {boolean} on */
  keepFine(on) {
    this.fine = on;
    if (this.settings.quality === 'auto') this.#refine(on ? atLeast('plain', this.level) : this.chooser.level);
  }

  /** Draws once as finely as the screen is, and then as before; a video that is recorded keeps its size.
   * @param {() => void} take what takes the picture */
  drawFine(take) {
    this.stage.refine(LEVELS[this.fine ? this.level : 'full']);
    this.stage.draw();
    take();
    this.stage.refine(LEVELS[this.level]);
    this.stage.draw();
  }

  #refine(level) {
    if (level !== this.level) this.stage.refine(LEVELS[level]);
    this.level = level;
  }

  /** Takes how long a whole drawing took [ms], and draws more or less finely where that is left to it. */
  judge(time) {
    if (this.settings.quality === 'auto' && !this.fine) this.#refine(this.chooser.add(time));
  }

  // the scale begins anew
  #forgetColours() {
    this.top = 0;
    this.bodies.forEach((body) => body.colourUpTo(0));
  }

  /** Colours the bodies as they are now; all have one scale, up to the largest value so far. */
  colour() {
    const { settings, bodies, shown } = this;
    if (settings.colour === 'own') return;
    const factor = this.plays ? 1 : settings.stiffness;
    const most = bodies.flatMap((body, n) => {
      const stiffness = factor * shown.bodies[n].stiffness;
      const least = leastTop(body.model, settings.colour, body.size, stiffness);
      return [least, body.measure(settings.colour, this.motion.shape(n), stiffness)];
    });
    this.top = Math.max(this.top, ...most);
    bodies.forEach((body) => body.colourUpTo(this.top));
  }

  /** Marks where bodies touch, and what ties them. */
  mark() {
    const { settings, plays, shown } = this;
    const may = settings.touches && !plays && (shown.obstacles.length > 0 || shown.collisions);
    this.marks.show(may ? this.engine.touches() : new Float32Array(0));
    this.linkMarks.show(settings.links ? this.links() : []);
  }

  /** The links as they are now. */
  links() {
    if (this.plays) return this.recording.links().map((link) => ({ ...link, state: stateOf(link, link) }));
    return (this.shown.links ?? []).map((link, n) => {
      const now = this.engine.link(n);
      return { name: link.name, kind: link.kind, state: stateOf(link, now), ...now };
    });
  }

  /** The joint that was open the widest, where one was [m]. @returns {object|undefined} */
  openJoint() {
    return this.links().filter(({ kind, largestDrift }) => kind !== 'spring' && largestDrift > OPEN)
      .sort((a, b) => b.largestDrift - a.largestDrift)[0];
  }

  /** By how many per cent of what the mesh gives (linear) the model follows a pull at a vertex; undefined: not known.
   * @param {number} body @param {number} vertex */
  follows(body, vertex) {
    return this.pack.models[this.shown.bodies[body].model].arrays.follows?.[vertex];
  }

  /** Has the model shapes that follow and are not stepped? @param {number} body */
  hasFollowers(body) {
    return this.pack.models[this.shown.bodies[body].model].masters > 0;
  }

  /** The force of a pull [N], of the first copy where bodies are compared. */
  pullForce(id) {
    const [{ number }] = this.pulls.get(id).springs;
    return Math.hypot(...this.engine.pull(number).force);
  }

  /** Puts the meshes where the engine has the bodies. */
  place() {
    this.bodies.forEach(({ mesh }, n) => {
      mesh.matrixAutoUpdate = false;
      mesh.matrix.fromArray(this.motion.matrix(n));
      mesh.matrixWorldNeedsUpdate = true;
    });
    this.#placeObstacles();
  }

  // those that move, by the engine or as the recorded scene says
  #placeObstacles() {
    const { plays, recording, engine, stage } = this;
    this.shown.obstacles.forEach((obstacle, n) => {
      const { kind, velocity, times } = obstacle;
      if (!(times?.length > 0) && !velocity?.some((v) => v !== 0)) return;
      if (kind === 'solid')
        stage.placeObstacle(n, plays ? recording.obstacleMatrix(obstacle) : engine.solidMatrix(n));
      else
        stage.moveObstacle(n, plays ? recording.obstacleMatrix(obstacle).slice(12, 15)
          : engine.obstacleCentre(n));
    });
  }

  /** Hands q of every body to the GPU. */
  upload() {
    const { data } = this.coordinates.image;
    const magnify = this.orbit ? this.settings.magnify : 1;
    this.bodies.forEach((_, n) => data.set(this.motion.shape(n).map((x) => magnify * x), n * this.width));
    this.coordinates.needsUpdate = true;
    this.stage.renderer.initTexture(this.coordinates);
    this.place();
  }
}
