// What is simulated and shown at present: a scene in the engine, its bodies in the picture.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';
import { Body } from './body.js';
import { coordinatesTexture } from './shader.js';
import { aloneScene, comparedScene, isComposed } from './scenes.js';

/** What the panel changes while bodies move.
 * @typedef {{dt: number, integrator: string, rank: number, gravity: number, damping: number,
 *   stiffness: number, pull: number, tint: boolean}} Settings */

export class World {
  /** @param {import('./pack.js').Pack} pack @param {import('./engine.js').Engine} engine
   * @param {import('./stage.js').Stage} stage */
  constructor(pack, engine, stage) {
    Object.assign(this, { pack, engine, stage, bodies: [], pulls: new Map(), compared: false });
    for (const model of pack.models) engine.addModel(model);
    this.choice = isComposed(pack.scene) ? -1 : pack.scene.bodies[0].model;
    this.settings = { pull: 3, tint: false };
  }

  /** Shows a scene at its start. @param {number} choice a model, or -1: the pack's scene
   * @param {boolean} compared three copies side by side, which keep the settings */
  show(choice, compared) {
    const fresh = choice !== this.choice || this.bodies.length === 0;
    this.choice = choice;
    this.compared = compared;
    const own = choice < 0 ? this.pack.scene : aloneScene(this.pack, choice);
    if (fresh) this.#settle(own);
    this.shown = compared ? comparedScene(this.pack, own) : own;
    this.pulls.clear();
    this.engine.build(this.shown);
    this.#populate();
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
      rank: first.rank || this.pack.models[first.model].rank,
    });
  }

  // a scene with bodies of several kinds keeps what each was given, until a control is moved
  #applyAll(scene) {
    const names = ['dt', 'gravity', 'tint'];
    if (scene.bodies.length === 1) names.push('damping', 'stiffness', 'rank', 'integrator');
    for (const name of names) this.set(name, this.settings[name]);
  }

  #populate() {
    for (const body of this.bodies) {
      this.stage.scene.remove(body.mesh);
      body.dispose();
    }
    this.coordinates?.dispose();
    const models = this.shown.bodies.map((body) => this.pack.models[body.model]);
    this.width = Math.max(...models.map(({ rank }) => rank));
    this.coordinates = coordinatesTexture(this.width, models.length);
    this.bodies = this.shown.bodies.map((from, n) => new Body(models[n], from, n, this.coordinates));
    this.place();
    const bounds = new THREE.Box3();
    for (const { mesh } of this.bodies) {
      this.stage.scene.add(mesh);
      bounds.union(mesh.geometry.boundingBox.clone().applyMatrix4(mesh.matrix));
    }
    const height = bounds.max.z - bounds.min.z;
    const below = this.bodies.every((body) => body.stands) ? 0.002 * height : 2 * height;
    this.stage.furnish(this.shown.obstacles, bounds, bounds.min.z - below);
    this.stage.look(bounds);
  }

  /** Changes one setting of all bodies. @param {keyof Settings} name */
  set(name, value) {
    const { engine } = this;
    const each = (change) => this.bodies.forEach((_, n) => change(n));
    const changes = {
      dt: () => engine.setDt(value),
      gravity: () => engine.setGravity(this.down.map((d) => d * value)),
      damping: () => each((n) => engine.setDamping(n, value)),
      stiffness: () => each((n) => engine.setStiffness(n, value * this.shown.bodies[n].stiffness)),
      rank: () => each((n) => engine.setRank(n, Math.min(value, this.bodies[n].model.rank))),
      integrator: () => this.compared || each((n) => engine.setIntegrator(n, value)),
      pull: () => {},
      tint: () => this.bodies.forEach((body) => body.colourByDisplacement(value)),
    };
    changes[name]();
    this.settings[name] = value;
    if (name === 'pull' || name === 'stiffness') this.#pullAgain();
  }

  /** A spring from a vertex to a point, in each copy where bodies are compared.
   * @param {number} id of the pointer @param {number} body @param {number} vertex
   * @param {number[]} target [m] */
  pull(id, body, vertex, target) {
    this.pulls.set(id, { body, vertex, target });
    const copies = this.compared ? this.bodies.map((_, n) => n) : [body];
    const from = this.shown.bodies[body].position;
    for (const n of copies) {
      const to = this.shown.bodies[n].position;
      this.engine.pull(id, n, vertex, target.map((x, axis) => x + to[axis] - from[axis]),
        this.settings.pull);
    }
  }

  #pullAgain() {
    for (const [id, { body, vertex, target }] of this.pulls) this.pull(id, body, vertex, target);
  }

  release(id) {
    this.pulls.delete(id);
    this.engine.release(id);
  }

  reset() {
    for (const id of [...this.pulls.keys()]) this.release(id);
    this.engine.reset();
  }

  /** Puts the meshes where the engine has the bodies. */
  place() {
    this.bodies.forEach(({ mesh }, n) => {
      mesh.matrixAutoUpdate = false;
      mesh.matrix.fromArray(this.engine.matrix(n));
      mesh.matrixWorldNeedsUpdate = true;
    });
  }

  /** Hands q of every body to the GPU. */
  upload() {
    const { data } = this.coordinates.image;
    this.bodies.forEach((_, n) => data.set(this.engine.shape(n), n * this.width));
    this.coordinates.needsUpdate = true;
    this.stage.renderer.initTexture(this.coordinates);
    this.place();
  }
}
