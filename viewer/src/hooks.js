// window.thrum: what tests and curious people may ask the page and tell it.
// SPDX-License-Identifier: Apache-2.0
import { displacedPositions } from './readback.js';

const STEPS_A_SAMPLE = 8;

/** @param {Promise<object>} starting the App */
export function hooks(starting) {
  const thrum = { ready: starting.then(() => true) };
  starting.then((app) => {
    const { world } = app;
    const { stage } = world;
    Object.assign(thrum, {
      bodies: () =>
        world.shown.bodies.map(({ name, model, position }) => ({ name, model, position })),
      time: () => world.motion.time,
      settings: () => ({ ...world.settings }),
      trouble: () => app.trouble,
      energies: (body) => world.motion.energies(body),
      account: () => world.engine.account(),
      report: (body) => world.engine.report(body),
      frequencies: (body) => world.engine.frequencies(body),
      steppedFrequencies: (body) => world.engine.steppedFrequencies(body),
      q: (body) => Array.from(world.motion.shape(body)),
      position: (body, vertex) => world.engine.position(body, vertex),
      pulls: () => [...world.pulls].map(([id, { body, vertex, target }]) =>
        ({ body, vertex, target, force: world.pullForce(id) })),
      level: () => world.level,
      judge: (time) => world.judge(time),
      heard: () => app.heard,
      links: () => world.links(),
      shownLinks: () => world.linkMarks.counts,
      touches: () => Array.from(world.engine.touches()),
      scaleTop: () => { world.colour(); return world.top; },
      values: (body) => Array.from(world.bodies[body].values.values),
      vertexCount: (body) => world.bodies[body].model.vertex_count,
      /** Per cent at each vertex, as they are kept: what is put in is said. */
      follows: (body) => world.bodies[body].model.arrays.follows,
      fixed: (body) => Array.from(world.bodies[body].model.arrays.fixed),
      matrix: (body) => Array.from(world.motion.matrix(body)),
      project: (body, vertex) => stage.project(world.engine.position(body, vertex)),
      projectPlace: (point) => stage.project(point),
      pick(x, y) {
        const { origin, direction } = stage.ray(x, y);
        return world.engine.pick(origin.toArray(), direction.toArray());
      },
      /** Where a vertex is drawn, of a recording too. */
      shownPosition(body, vertex) {
        const local = thrum.gpuPositions(body).slice(4 * vertex, 4 * vertex + 3);
        const m = world.motion.matrix(body);
        return [0, 1, 2].map((axis) => local.reduce((sum, x, n) => sum + m[4 * n + axis] * x, m[12 + axis]));
      },
      gpuPositions(body) {
        world.upload();
        return Array.from(displacedPositions(stage.renderer, world.bodies[body]));
      },
      set(name, value) {
        app.set(name, value);
        app.panel.refresh();
      },
      seek: (time) => app.seek(time),
      /** Which point of a curve is shown, from 1, and where it is drawn. */
      point: () => world.point,
      pointPlace: (point) => app.curvePlot.place(point - 1),
      show: (choice, compared) => app.show(choice, compared),
      pause: (on) => app.pause(on),
      reset: () => app.reset(),
      /** Steps `count` times without drawing; false: one failed. */
      step(count) {
        for (let i = 0; i < count; i++) {
          if (!app.step()) return false;
          if (i % STEPS_A_SAMPLE === 0) app.sample();
        }
        return true;
      },
      /** Hands q to the GPU `count` times, and waits until it has it. */
      upload(count) {
        for (let i = 0; i < count; i++) world.upload();
        stage.renderer.getContext().finish();
      },
      times: () => Object.fromEntries(
        Object.entries(app.meters).map(([name, { mean, count }]) => [name, { mean, count }])),
      open: (files) => app.open(files),
      recorded: () => app.recorder.size,
    });
  }, () => {});
  return thrum;
}
