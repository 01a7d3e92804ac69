// The page: loads the pack and the engine, runs the frames, wires the buttons.
// SPDX-License-Identifier: Apache-2.0
import { Clock, Meter } from './clock.js';
import { Engine } from './engine.js';
import { hooks } from './hooks.js';
import { bytesOfElement, loadPack } from './pack.js';
import { Panel } from './panel.js';
import { EnergyPlot } from './plot.js';
import { pullWithPointers } from './pull.js';
import { Recorder } from './record.js';
import { COMPARED } from './scenes.js';
import { Stage } from './stage.js';
import { World } from './world.js';

const find = (id) => document.getElementById(id);

const ENERGIES = [
  { name: 'total', colour: '#1c2733' }, { name: 'kinetic', colour: '#2a78c2' },
  { name: 'strain', colour: '#dd7a22' }, { name: 'gravity', colour: '#8a63b8' },
];

class App {
  constructor(world) {
    this.world = world;
    this.clock = new Clock();
    this.meters = {
      step: new Meter(), upload: new Meter(), draw: new Meter(), frame: new Meter(),
    };
    this.recorder = new Recorder(world.stage.renderer.domElement);
    this.plot = new EnergyPlot(find('plot'), find('legend'));
    this.panel = new Panel(world, {
      set: (name, value) => this.set(name, value),
      choose: (choice) => this.show(choice, world.compared),
      toggled: () => this.fit(),
    });
    this.drawSprings = pullWithPointers(world, (action) => this.guard(action));
    this.paused = false;
    this.#wire();
    this.fit();
    this.show(world.choice, false);
    requestAnimationFrame((now) => this.frame(now));
  }

  #wire() {
    find('pause').addEventListener('click', () => this.pause(!this.paused));
    find('step').addEventListener('click', () => this.stepOnce());
    find('reset').addEventListener('click', () => this.reset());
    find('compare').addEventListener('click', () =>
      this.show(this.world.choice, !this.world.compared));
    find('record').addEventListener('click', () => this.guard(() => this.record()));
    addEventListener('resize', () => this.fit());
    const keys = { ' ': 'pause', '.': 'step', r: 'reset' };
    addEventListener('keydown', (event) => {
      if (!keys[event.key] || event.target !== document.body) return;
      find(keys[event.key]).click();
      event.preventDefault();
    });
  }

  /** Fits the drawing to the window and what lies over it. */
  fit() {
    const { stage } = this.world;
    const wide = innerWidth > 720 && !find('panel').hidden;
    stage.fit({
      top: document.querySelector('header').offsetHeight,
      right: wide ? find('panel').offsetWidth + 12 : 0,
      bottom: find('energy').offsetHeight,
    });
  }

  /** Does something that may be refused, and says so on the page. */
  async guard(action) {
    try {
      await action();
    } catch (error) {
      this.complain(error);
    }
  }

  /** Says on the page what went wrong, until something else goes right. */
  complain(error) {
    this.trouble = error.message;
    find('notice').textContent = error.message;
    find('notice').hidden = false;
  }

  /** A body that failed: the simulation stops, and stays so until a reset. */
  fail(error) {
    this.failed = true;
    this.complain(error);
    this.pause(true);
  }

  settle() {
    this.trouble = null;
    find('notice').hidden = true;
  }

  /** Shows a model (-1: the pack's scene), perhaps in three copies. */
  show(choice, compared) {
    this.guard(() => {
      this.world.show(choice, compared);
      this.forget();
      find('compare').setAttribute('aria-pressed', String(compared));
      find('labels').replaceChildren(...(compared ? COMPARED : []).map(label));
      this.panel.refresh();
    });
  }

  /** What was shown of the run before. */
  forget() {
    const { compared } = this.world;
    this.plot.begin(compared ? COMPARED.map(([name, colour]) => ({ name, colour })) : ENERGIES);
    this.failed = false;
    this.settle();
    this.clock.restart();
    this.meters.step = new Meter();
  }

  set(name, value) {
    this.guard(() => {
      this.world.set(name, value);
      if (!this.failed) this.settle();
    });
  }

  pause(on) {
    this.paused = on;
    find('pause').textContent = on ? 'Run' : 'Pause';
    this.clock.restart();
  }

  reset() {
    this.guard(() => {
      this.world.reset();
      this.forget();
    });
  }

  stepOnce() {
    this.pause(true);
    this.step();
  }

  /** @returns {boolean} false: a body failed, and the page says why */
  step() {
    try {
      this.world.engine.step();
      return true;
    } catch (error) {
      this.fail(error);
      return false;
    }
  }

  async record() {
    const { recorder } = this;
    if (recorder.recording) await recorder.stop();
    else this.guard(() => recorder.start());
    find('record').setAttribute('aria-pressed', String(recorder.recording));
  }

  /** Energies of all bodies together, or the total of each where they are compared. */
  energies() {
    const { engine, bodies, compared } = this.world;
    const each = bodies.map((_, n) => engine.energies(n));
    if (compared) return each.map(({ total }) => total);
    const sum = (name) => each.reduce((all, energies) => all + energies[name], 0);
    return ['total', 'kinetic', 'potential', 'gravity'].map(sum);
  }

  advance(elapsed) {
    const { meters, clock, world } = this;
    const begin = performance.now();
    const steps = clock.advance(elapsed, world.settings.dt, () => this.step());
    if (steps > 0) meters.step.add((performance.now() - begin) / steps);
  }

  frame(now) {
    requestAnimationFrame((next) => this.frame(next));
    try {
      this.advanceAndDraw(now);
    } catch (error) {
      // what was refused before says why; without a body there is nothing to draw
      if (this.trouble == null) this.complain(error);
      this.pause(true);
    }
  }

  advanceAndDraw(now) {
    const { meters, world } = this;
    const elapsed = this.last === undefined ? 0 : (now - this.last) / 1e3;
    if (elapsed > 0) meters.frame.add(1e3 * elapsed);
    this.last = now;
    if (!this.paused && elapsed > 0) this.advance(elapsed);
    const begin = performance.now();
    world.upload();
    const uploaded = performance.now();
    this.drawSprings();
    world.stage.draw();
    meters.upload.add(uploaded - begin);
    meters.draw.add(performance.now() - uploaded);
    this.report();
  }

  /** The energies as they are now, for the plot; a body that failed may have none. */
  sample() {
    if (this.failed) return;
    try {
      this.plot.add(this.world.engine.time, this.energies());
    } catch (error) {
      this.fail(error);
    }
  }

  // what the page says, at half the rate of the frames
  report() {
    this.frames = (this.frames ?? 0) + 1;
    const { world, clock } = this;
    this.sample();
    if (this.frames % 2 === 0) return;
    this.plot.draw();
    this.panel.showSplit();
    this.panel.showTimes(this.meters);
    const pace = clock.behind && !this.paused ? `, ${clock.pace.toFixed(2)} of real time` : '';
    find('clock').textContent = `${world.engine.time.toFixed(2)} s${pace}`;
    this.placeLabels();
  }

  placeLabels() {
    const { bodies, stage } = this.world;
    [...find('labels').children].forEach((span, n) => {
      const { matrix, geometry } = bodies[n].mesh;
      const { min } = geometry.boundingBox;
      const foot = geometry.boundingBox.getCenter(min.clone()).setZ(min.z).applyMatrix4(matrix);
      const { x, y } = stage.project(foot.toArray());
      span.style.left = `${x}px`;
      span.style.top = `${y + 14}px`;
    });
  }
}

/** What stands under a compared body. */
function label([name, colour]) {
  const span = document.createElement('span');
  span.textContent = name;
  span.style.color = colour;
  return span;
}

async function begin() {
  const engine = await Engine.load(await bytesOfElement(find('thrum-wasm')));
  const world = new World(await loadPack(), engine, new Stage(find('view')));
  return new App(world);
}

const starting = begin();
window.thrum = hooks(starting);
starting.catch((error) => {
  find('notice').textContent = `The viewer could not start: ${error.message}`;
  find('notice').hidden = false;
});
