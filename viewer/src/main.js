// The page: loads the pack and the engine, runs the frames, wires the buttons.
// SPDX-License-Identifier: Apache-2.0
import { Clock, Meter, SPEEDS } from './clock.js';
import { CurvePlot, pointText } from './curve_plot.js';
import { listenToFiles, packOfFiles } from './drop.js';
import { Engine } from './engine.js';
import { hooks } from './hooks.js';
import { listenToKeys } from './keys.js';
import { hashOf, readHash } from './link.js';
import { hideNotice, showNotice } from './notice.js';
import { quantityText } from './numbers.js';
import { bytesOfElement, loadPack } from './pack.js';
import { Panel } from './panel.js';
import { EnergyPlot } from './plot.js';
import { pullWithPointers } from './pull.js';
import { Recorder, save } from './record.js';
import { Stage } from './stage.js';
import { Striker, heardText, strikeWeights } from './strike.js';
import { followTheme } from './theme.js';
import { SHOWN, World } from './world.js';

const find = (id) => document.getElementById(id);

const ENERGIES = [
  { name: 'total', colour: 'var(--ink)', dash: [] }, { name: 'kinetic', colour: 'var(--kinetic)', dash: [7, 3] },
  { name: 'strain', colour: 'var(--strain)', dash: [2, 2] }, { name: 'gravity', colour: 'var(--gravity)', dash: [9, 3, 2, 3] },
];

/** Those of them that only scenes with what it takes have. */
const OF_SCENES = [{ name: 'contact', colour: 'var(--contact)', dash: [4, 4] }, { name: 'links', colour: 'var(--links)', dash: [1, 3] }];

/** Of a recorded run, whose rows have the energies of the bodies alone. */
const RECORDED = [{ ...ENERGIES[0], name: 'kinetic + strain' }, ENERGIES[1], ENERGIES[2]];

const REPORT_EVERY = 30; // [ms]
const LEAP = 0.25; // the most real time by which one frame moves a recorded run [s]
const TIMED_EVERY = 4; // drawings of which one is timed to its end, and
const SLOW_FRAME = 0.06; // all that follow a frame as long as this [s]
const GAP = 8; // between the buttons and the panel, at least [px]

class App {
  constructor(world) {
    this.world = world;
    this.clock = new Clock();
    this.meters = {
      step: new Meter(), upload: new Meter(), draw: new Meter(), frame: new Meter(),
    };
    this.recorder = new Recorder(world.stage.renderer.domElement);
    this.energyPlot = new EnergyPlot(find('plot'), find('legend'));
    this.curvePlot = new CurvePlot(find('plot'), find('legend'), (row) => this.pick(row));
    this.panel = new Panel(world, {
      set: (name, value) => this.set(name, value),
      choose: (choice) => this.show(choice, world.compared),
      toggled: () => this.fit(),
    });
    this.striker = new Striker(find('thrum-sound')?.textContent ?? '', (heard) => {
      Object.assign(this.heard, heard);
      find('heard').textContent = heardText(heard);
    });
    this.drawSprings = pullWithPointers(world, (action) => this.guard(action),
      (...strike) => this.guard(() => this.strike(...strike)));
    this.paused = false;
    this.drawn = this.drew = 0; // pictures, and how long the last that was timed took [ms]
    this.#wire();
    followTheme((theme) => world.stage.paint(theme));
    this.fit();
    this.obey(location.hash);
    requestAnimationFrame((now) => this.frame(now));
  }

  #wire() {
    find('pause').addEventListener('click', () => this.pause(!this.paused));
    find('step').addEventListener('click', () => this.stepOnce());
    find('reset').addEventListener('click', () => this.reset());
    find('compare').addEventListener('click', () =>
      this.show(this.world.choice, !this.world.compared));
    find('record').addEventListener('click', () => this.guard(() => this.record()));
    find('picture').addEventListener('click', () => this.guard(() => this.savePicture()));
    find('link').addEventListener('click', () => this.guard(() => this.copyLink()));
    find('open').addEventListener('click', () => find('files').click());
    listenToFiles(find('files'), (files) => this.guard(() => this.open(files)));
    addEventListener('resize', () => this.fit());
    addEventListener('hashchange', () => this.obey(location.hash));
    find('scrub').addEventListener('input', () => this.slide(find('scrub').valueAsNumber));
    find('speed').replaceChildren(...SPEEDS.map((speed) => new Option(`× ${speed}`, speed)));
    find('speed').addEventListener('change', () => this.setSpeed(Number(find('speed').value)));
    this.setSpeed(1);
    const click = (id) => () => find(id).click();
    const move = (rows) => () => this.world.plays && this.moveRows(rows);
    const faster = (by) => () =>
      this.setSpeed(SPEEDS[SPEEDS.indexOf(this.speed) + by] ?? this.speed);
    listenToKeys({
      ' ': click('pause'), '.': click('step'), ',': move(-1), r: click('reset'), c: click('compare'), p: click('picture'),
      ArrowLeft: move(-1), ArrowRight: move(1), Home: move(-Infinity), End: move(Infinity),
      '[': faster(-1), ']': faster(1),
    });
  }

  /** @param {number} speed simulated over real time */
  setSpeed(speed) {
    this.speed = speed;
    find('speed').value = speed;
    this.clock.restart();
  }

  /** Goes to a moment of the recorded run. @param {number} time [s] */
  seek(time) {
    this.pause(true);
    this.world.recording.seek(time);
  }

  /** The slider over the plot: the time of a run, or the point of a curve, whose motion goes on. */
  slide(value) {
    if (!this.world.orbit) this.pause(true);
    this.world.recording.slide(value);
    this.world.stage.touch();
  }

  moveRows(rows) {
    if (!this.world.orbit) this.pause(true);
    this.world.recording.move(rows);
    this.world.stage.touch();
  }

  /** Shows a motion of the curve. @param {number} row from 0 */
  pick(row) {
    this.world.orbit.choose(row);
    this.world.stage.touch();
  }

  /** Fits the drawing to the window and what lies over it. */
  fit() {
    const { stage } = this.world;
    const beside = innerWidth > 720 || (innerWidth > 480 && innerHeight <= 420); // as in style.css
    const wide = beside && !find('panel').hidden;

    // the buttons are as wide as their font, and the panel begins where they end
    const header = document.querySelector('header').getBoundingClientRect();
    document.body.style.setProperty('--head', `${header.bottom}px`);
    document.body.classList.toggle('narrow', wide && header.right + GAP > find('panel').getBoundingClientRect().left);
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
    showNotice(error.message);
  }

  /** A body that failed: the simulation stops, and stays so until a reset. */
  fail(error) {
    this.failed = true;
    this.complain(error);
    showNotice(`Stopped at ${this.world.engine.time.toPrecision(3)} s: ${error.message}`, this.waysOut());
    this.pause(true);
  }

  /** What one may do about a simulation that is lost; each begins it anew. */
  waysOut() {
    const { settings, compared } = this.world;
    const anew = (name, value) => () => {
      this.reset();
      if (name) this.set(name, value);
      this.panel.refresh();
      this.pause(false);
    };
    const ways = [['Reset', anew()], ['Halve the time step', anew('dt', settings.dt / 2)]];
    if (!compared && settings.integrator !== 'energy')
      ways.push(['Use energy', anew('integrator', 'energy')]);
    return ways;
  }

  /** Says once of a run that a body gained energy by itself: what is seen is no motion of it. */
  warnOfGrowth() {
    const { bodies, engine, plays } = this.world;
    if (plays || this.grown || this.failed) return;
    const n = bodies.findIndex((_, body) => engine.report(body).grown > 0);
    if (n < 0) return;
    this.grown = true;
    showNotice(`${bodies[n].name}: its energy grew by itself, for ` +
      `${engine.report(n).integrator} is not stable at this time step`, this.waysOut());
  }

  /** Says once of a run that a joint has come open, as it does where bodies move far in a step. */
  warnOfJoints() {
    if (this.opened || this.failed) return;
    const joint = this.world.openJoint();
    if (!joint) return;
    this.opened = true;
    showNotice(`The joint ${joint.name ?? `of kind ${joint.kind}`} was open by ${quantityText(joint.largestDrift, 'm')}: ` +
      'bodies move too far in a step for it', this.waysOut());
  }

  settle() {
    this.trouble = null;
    hideNotice();
  }

  /** Sounds a body that was struck, where sound is asked for. @param {number[]} direction in the world */
  strike(body, vertex, direction) {
    const { engine, bodies, settings, shown } = this.world;
    if (!settings.sound) return;
    const matrix = engine.matrix(body);
    const inBody = [0, 4, 8].map((column) =>
      direction.reduce((sum, n, axis) => sum + n * matrix[column + axis], 0));
    const size = Math.hypot(...inBody);
    const along = inBody.map((n) => n / size);
    const { model } = bodies[body];
    const weights = strikeWeights(model, vertex, along);
    const frequencies = engine.frequencies(body);
    const damping = shown.bodies.length > 1 ? shown.bodies[body].damping ?? 0 : settings.damping;
    this.heard = { frequencies, weights };
    this.striker.play(engine.module, { model, frequencies, damping, vertex, direction: along }, weights);
  }

  /** Shows what files hold in place of what was shown, and runs it where that had failed; what cannot be shown leaves
   * everything as it was. @param {File[]} files */
  async open(files) {
    const { world, failed } = this;
    const { pack, engine, choice, compared } = world;
    const other = await engine.another();
    const models = [...pack.models, ...world.own.filter((model) => !pack.models.includes(model))];
    world.adopt(await packOfFiles(files, other, { ...pack, models }), other);
    this.show(world.choice, false, () => {
      world.adopt(pack, engine);
      world.show(choice, compared);
      this.forget();
      this.panel.listModels();
    });
    this.panel.listModels();
    this.panel.refresh();
    if (failed && !this.failed) this.pause(false);
  }

  /** Shows what an address asks for. @param {string} hash */
  obey(hash) {
    const { choice, compared, point, settings } = readHash(hash);
    const { world } = this;
    const known = choice === world.choice || world.pack.models[choice] !== undefined;
    this.show(known ? choice : world.choice, compared === true && !world.plays);
    for (const [name, value] of Object.entries(settings))
      if (!world.plays || SHOWN.includes(name)) this.set(name, value);
    if (point && world.orbit) this.pick(point - 1);
    this.panel.refresh();
  }

  /** Puts the settings into the address, and the address where one may paste it from. */
  async copyLink() {
    const { world } = this;
    history.replaceState(null, '', hashOf(world.settings, world)); // which is no change to be obeyed
    const copied = await navigator.clipboard?.writeText(location.href).then(() => true, () => false);
    showNotice(copied ? 'The link is copied' : 'The address of the page now carries the settings');
  }

  /** The view as a PNG file, as it is now and drawn as finely as the screen is. */
  async savePicture() {
    const { world } = this;
    const canvas = world.stage.renderer.domElement;
    const blob = await new Promise((done) => { world.drawFine(() => canvas.toBlob(done, 'image/png')); });
    save(blob, 'thrum.png');
  }

  /** Shows a model (-1: the pack's scene), perhaps in copies that are compared. @param {() => void} [back] to what was shown */
  show(choice, compared, back) {
    this.guard(() => {
      const { world } = this;
      const before = [world.choice, world.compared];
      try {
        world.show(choice, compared);
      } catch (error) {
        if (back) back();
        else if (world.bodies.length > 0) world.show(...before);
        throw error;
      }
      this.forget();
      this.fit(); // the legend may have other lines
      find('compare').setAttribute('aria-pressed', String(compared));
      find('labels').replaceChildren(...(compared ? world.shown.copies : []).map(label));
      this.panel.refresh();
      this.pause(this.paused);
    });
  }

  /** What was shown of the run before. */
  forget() {
    const { orbit, plays } = this.world;
    this.plot = orbit ? this.curvePlot : this.energyPlot;
    this.curvePlot.begin(orbit);
    if (!orbit) this.plot.begin(this.series());
    if (plays && !orbit) this.#plotRecording();
    find('plotted').textContent = orbit ? 'Response' : 'Energy';
    find('scrub').ariaLabel = orbit ? 'Point of the curve' : 'Time in the run';
    this.grown = this.opened = this.failed = false;
    this.settle();
    this.clock.restart();
    this.meters.step = new Meter();
  }

  // the energies of all bodies together, in every row
  #plotRecording() {
    const { rows, times } = this.world.recording;
    this.plot.showWhole(Array.from(times, (time, n) => {
      const sum = (of) => rows.reduce((all, { arrays }) => all + arrays.energies[2 * n + of], 0);
      return { time, values: [sum(0) + sum(1), sum(0), sum(1)] };
    }));
  }

  /** Changes a setting; a simulation that has failed is not changed but begun anew with it. */
  set(name, value) {
    if (this.failed) this.reset();
    this.guard(() => {
      this.world.set(name, value);
      if (!this.failed) this.settle();
    });
  }

  pause(on) {
    const { plays, recording } = this.world;
    if (plays && !on && recording.time === recording.end) recording.seek(recording.begin);
    this.paused = on;
    find('pause').textContent = on ? (plays ? 'Play' : 'Run') : 'Pause';
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
    if (this.world.plays) this.world.recording.tick();
    else this.step();
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
    if (recorder.recording) {
      await recorder.stop();
      this.world.keepFine(false);
    } else {
      this.guard(() => {
        this.world.keepFine(true);
        recorder.start();
      });
    }
    find('record').setAttribute('aria-pressed', String(recorder.recording));
  }

  /** The curves of the plot: parts of the total of all bodies, or one of each copy. */
  series() {
    const { compared, plays, shown } = this.world;
    if (plays) return RECORDED;
    if (compared) return shown.copies.map((copy) => ({ ...copy, name: shown.ofCoupling ? `strain, ${copy.name}` : copy.name }));
    const present = { contact: shown.obstacles.length > 0 || shown.collisions, links: shown.links?.length > 0 };
    return [...ENERGIES, ...OF_SCENES.filter(({ name }) => present[name])];
  }

  /** Energies of all bodies together; where copies are compared the total of each, or of those with and without coupling,
   * which both keep their total, what they are strained by. */
  energies() {
    const { engine, bodies, compared, shown } = this.world;
    if (!compared) {
      const account = engine.account();
      return this.series().map(({ name }) => account[name === 'strain' ? 'potential' : name]);
    }
    const each = bodies.map((_, n) => engine.energies(n));
    const springs = this.world.links();
    const sum = (list, name) => list.reduce((all, energies) => all + energies[name], 0);
    const copies = shown.copies.length;
    const of = (list, n) => list.slice(n * list.length / copies, (n + 1) * list.length / copies);
    return shown.copies.map((_, n) => (shown.ofCoupling ? sum(of(each, n), 'potential')
      : sum(of(each, n), 'total') + sum(of(springs, n), 'stored')));
  }

  advance(elapsed) {
    const { meters, clock, world } = this;
    if (world.plays) {
      if (!world.recording.advance(Math.min(elapsed, LEAP * this.speed))) this.pause(true);
      return;
    }
    const begin = performance.now();
    const steps = clock.advance(elapsed, world.settings.dt, () => this.step(), this.drew);
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
    const elapsed = this.last === undefined ? 0 : (now - this.last) / 1e3;
    this.last = now;
    if (!this.paused && elapsed > 0) this.advance(this.speed * elapsed);
    if (this.#isNew()) this.#draw(elapsed);
    if (this.reported !== this.shown) this.report(now);
  }

  #draw(elapsed) {
    const { meters, world } = this;
    if (elapsed > 0) meters.frame.add(1e3 * elapsed);
    const begin = performance.now();
    world.upload();
    world.colour();
    world.mark();
    const uploaded = performance.now();
    this.drawSprings();
    world.stage.draw();
    meters.upload.add(uploaded - begin);
    const slow = elapsed > SLOW_FRAME;
    if (this.drawn++ % TIMED_EVERY !== 0 && !slow) return;

    // calls of WebGL return before anything is drawn, and to wait for it takes time of its own
    world.stage.finish();
    const took = performance.now() - uploaded;
    this.drew = took;
    meters.draw.add(took);
    world.judge(took);
  }

  // is there anything to draw that the picture does not show yet?
  #isNew() {
    const { stage, motion } = this.world;
    stage.controls.update();
    const shown = `${motion.time} ${stage.version} ${this.paused}`;
    if (shown === this.shown) return false;
    this.shown = shown;
    return true;
  }

  /** The energies as they are now, for the plot; a body that failed may have none. */
  sample() {
    if (this.failed || this.world.plays) return;
    try {
      this.plot.add(this.world.engine.time, this.energies());
    } catch (error) {
      this.fail(error);
    }
  }

  // what the page says, not in every frame of a fast display
  report(now) {
    const { world, clock } = this;
    const { motion, plays, orbit } = world;
    this.sample();
    if (now - this.reportedAt < REPORT_EVERY) return;
    this.reportedAt = now;
    this.reported = this.shown;
    this.plot.draw(motion.time);
    this.panel.showTimes(this.meters);
    this.panel.showScale();
    if (plays) find('scrub').value = motion.slider.value;
    else this.panel.showSplit();
    this.warnOfGrowth();
    this.warnOfJoints();
    const pace = clock.behind && !this.paused && !plays
      ? `, ${(this.speed * clock.pace).toFixed(2)} of real time` : '';
    const of = plays ? ` of ${motion.end.toFixed(2)}` : '';
    find('clock').textContent = orbit ? pointText(orbit) : `${motion.time.toFixed(2)}${of} s${pace}`;
    this.placeLabels();
  }

  placeLabels() {
    const { bodies, stage } = this.world;
    [...find('labels').children].forEach((span, n) => {
      const { matrix, geometry } = bodies[n * this.world.each].mesh;
      const { min } = geometry.boundingBox;
      const foot = geometry.boundingBox.getCenter(min.clone()).setZ(min.z).applyMatrix4(matrix);
      const { x, y } = stage.project(foot.toArray());
      span.style.left = `${x}px`;
      span.style.top = `${y + 14}px`;
    });
  }
}

/** What stands under a compared body. */
function label({ name, colour }) {
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
  showNotice(`The viewer could not start: ${error.message}`);
});
