// Runs that are recorded, and derivatives of a loss by all that they depend on. SPDX-License-Identifier: Apache-2.0
import { Owned, Resource, ThrumError, doubles, steps as stepCount } from './memory.js';

export class Rollout extends Resource {
  #memory;
  #modelAt;
  #shown;

  constructor(memory, model, count, { q, p, force, ...options }) {
    if (stepCount(count) < 1) throw new ThrumError('a run has one step or more', -1);
    const state = model.state(options);
    const modelAt = memory.calls.js_model_pointer(model.address);
    const given = [q && doubles(q, model.rank, 'q'), p && doubles(p, model.rank, 'p'),
      force && doubles(force, count * model.shown, 'force')];
    const tape = new Owned(memory.made(memory.calls.js_tape_create(modelAt, count)),
      (at) => memory.calls.js_tape_destroy(at), [model.owned]);
    try {
      memory.lend(given, (...at) =>
        memory.check(memory.calls.js_tape_run(modelAt, tape.address, state.address, ...at, count)));
    } catch (failure) {
      tape.drop();
      throw failure;
    } finally {
      state.free();
    }
    super('run', tape);
    this.#memory = memory;
    this.#modelAt = modelAt;
    this.#shown = model.shown;
    Object.assign(this, { model, steps: count, rank: model.rank });
  }

  #rows(momenta) {
    const at = this.#memory.calls.js_tape_rows(this.address, momenta);
    return this.#memory.view(Float64Array, at, (this.steps + 1) * this.rank).slice();
  }

  get q() {
    return this.#rows(0);
  }

  get p() {
    return this.#rows(1);
  }

  pullBack(q, p) {
    const { rank, steps } = this;
    const bars = [q, p].map((bar, n) => bar && doubles(bar, (steps + 1) * rank, n ? 'pBar' : 'qBar'));
    const out = [rank, rank, rank, steps * this.#shown].map((length) => new Float64Array(length));
    this.#memory.lend([...bars, ...out], (qBar, pBar, ...at) => {
      this.#memory.check(
        this.#memory.calls.js_tape_pull_back(this.#modelAt, this.address, qBar, pBar, ...at));
      out.forEach((array, n) => array.set(this.#memory.view(Float64Array, at[n], array.length)));
    });
    const [alpha, beta, stiffness, density] = this.#memory.numbers;
    return { q: out[0], p: out[1], damping: out[2], force: out[3], alpha, beta, stiffness, density };
  }
}

/** The loss of a run and its gradient: loss(q, p) returns its value and its derivatives by both. */
export function valueAndGradient(loss, run) {
  try {
    const { value, q, p } = loss(run.q, run.p);
    return { value, gradient: run.pullBack(q, p) };
  } finally {
    run.free();
  }
}
