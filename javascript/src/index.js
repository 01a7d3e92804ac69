// Thrum in JavaScript: real-time deformable bodies that keep their energy.
// SPDX-License-Identifier: Apache-2.0
import { Rollout } from './gradient.js';
import { Memory, ThrumError } from './memory.js';
import { Batch, Model, State, StressNodes, Surface } from './model.js';
import { Body, Link, Pull, Scene } from './scene.js';

export { Batch, Body, Link, Model, Pull, Rollout, Scene, State, StressNodes, Surface, ThrumError };

/** What a call that did its work may say besides. */
export const Status = Object.freeze({ OK: 0, ENERGY_GREW: 1, FELL_BACK: 2, SWITCHED: 3 });

/** An instance of the engine: models of one instance do not go into scenes of another. */
class Thrum {
  #memory;

  constructor(memory) {
    this.#memory = memory;
    this.version = memory.text(memory.calls.js_version());
  }

  get integrators() {
    const names = [];
    for (let at; (at = this.#memory.calls.js_name(names.length, 0)) !== 0;) names.push(this.#memory.text(at));
    return names;
  }

  model(bytes) {
    return Model.of(this.#memory, bytes);
  }

  scene(options) {
    return new Scene(this.#memory, options);
  }
}

/** The engine from a WebAssembly binary: its bytes, or a module that was compiled from them. */
export async function loadFrom(wasm) {
  return new Thrum(await Memory.of(wasm));
}
