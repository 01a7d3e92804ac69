// The page as a person has it, in headless Chromium: opens, deforms, obeys each control.
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { copyFileSync, readFileSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { mostStepped } from '../src/pack.js';
import { folder, launch, open, packOf, serve, standalone, thrum } from './fixture.mjs';

const GRAVITY = [0, 0, -9.81];
let browser, pack, page;

before(async () => {
  thrum('precompute', 'beam:8x2x2@1x0.2x0.2,split=6', '--order', '1', '--fix', 'x<0.001', '--modes', '5', '--rank', '9',
    '-o', 'beam.npz', '--quiet');
  pack = packOf('beam.npz', 'heart');
  pack.scene = { ...pack.scene, gravity: GRAVITY, dt: 0.003, damping: 0.5, integrator: 'imexv' };
  browser = await launch();
  page = await open(browser, standalone(pack));
});

after(async () => {
  await browser?.close();
});

/** Begins anew with the first model, paused. */
const fresh = (compared = false) => page.evaluate((on) => {
  window.thrum.pause(true);
  window.thrum.show(1, false);
  window.thrum.show(0, on);
}, compared);

/** Moves a slider as a hand would: to the value nearest to `value` on its own scale. */
const slide = (id, place) => page.evaluate(([name, at]) => {
  const slider = document.getElementById(name);
  slider.value = at;
  slider.dispatchEvent(new Event('input', { bubbles: true }));
}, [id, place]);

/** The vertex whose x is nearest to `x` among those that a pointer reaches, and where it does. */
const reach = (along, of = page) => of.evaluate((wanted) => {
  const { thrum } = window;
  const all = Array.from({ length: thrum.vertexCount(0) }, (_, v) => {
    const { x, y } = thrum.project(0, v);
    return { v, x: Math.round(x), y: Math.round(y) };
  });
  // within a pixel of it too, for a browser may round
  const around = [[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]];
  const seen = all.filter(({ v, x, y }) => document.elementFromPoint(x, y)?.id === 'view' &&
    around.every(([dx, dy]) => {
      const pick = thrum.pick(x + dx, y + dy);
      return pick?.vertex === v && pick.body === 0;
    }));
  const away = ({ v }) => Math.abs(thrum.position(0, v)[0] - wanted);
  return seen.sort((a, b) => away(a) - away(b))[0];
}, along);

test('opens from the disk, moves by itself and complains of nothing', async () => {
  await page.waitForFunction(() => window.thrum.time() > 0.1);
  assert.equal(await page.evaluate(() => window.thrum.trouble()), null);
  assert.ok(await page.evaluate(() => window.thrum.times().draw.count) > 0);
  assert.deepEqual(page.complaints, []);

  // a page that is paused draws nothing, and leaves the machine to the others
  await page.evaluate(() => window.thrum.pause(true));
  await page.waitForFunction(() => {
    const { count } = window.thrum.times().draw;
    const same = window.drawnBefore === count;
    window.drawnBefore = count;
    return same;
  }, null, { polling: 200 });
});

test('opens from a server with the pack beside it', async () => {
  const server = await serve(pack);
  const own = await open(browser, server.url);
  await own.waitForFunction(() => window.thrum.time() > 0.1);
  assert.equal(await own.evaluate(() => window.thrum.bodies().length), 1);
  assert.deepEqual(own.complaints, []);
  await own.close();
  server.close();
});

test('says what is wrong with a pack that is none', async () => {
  const own = await browser.newPage();
  await own.goto(standalone({ scene: pack.scene, models: [{ ...pack.models[0], rank: 3000 }] }));
  await own.waitForSelector('#notice:not([hidden])');
  assert.match(await own.textContent('#notice'), /could not start/);
  await own.close();
});

test('sags under gravity, and the GPU shows what U q says', async () => {
  await fresh();
  const { v } = await reach(1);
  const [before, moved, shown, own] = await page.evaluate((vertex) => {
    const { thrum } = window;
    const at = thrum.position(0, vertex)[2];
    thrum.set('damping', 5);
    thrum.step(2000);
    const all = Array.from({ length: thrum.vertexCount(0) }, (_, n) => thrum.position(0, n));
    return [at, thrum.position(0, vertex)[2], thrum.gpuPositions(0), all];
  }, v);
  const sag = before - moved;
  assert.ok(sag > 0.01 && sag < 1, `the tip sinks by ${sag} m`);
  own.forEach((x, n) => x.forEach((value, axis) =>
    assert.ok(Math.abs(shown[4 * n + axis] - value) < 1e-3 * sag, `vertex ${n}, axis ${axis}`)));
});

test('something of the body is on the screen, and it moves', async () => {
  await fresh();
  const first = await page.locator('#view').screenshot();
  await page.evaluate(() => { window.thrum.step(60); });
  await page.waitForTimeout(500);
  assert.notDeepEqual(await page.locator('#view').screenshot(), first);
});

test('pause, step and reset', async () => {
  await fresh();
  const time = () => page.evaluate(() => window.thrum.time());
  await page.click('#step');
  assert.ok(Math.abs(await time() - 0.003) < 1e-12);
  assert.equal(await page.textContent('#pause'), 'Run');
  await page.click('#pause');
  await page.waitForFunction(() => window.thrum.time() > 0.05);
  await page.click('#pause');
  const stopped = await time();
  await page.waitForTimeout(200);
  assert.equal(await time(), stopped);
  await page.click('#reset');
  assert.equal(await time(), 0);
  assert.ok(await page.evaluate(() => window.thrum.q(0).every((q) => q === 0)));
});

test('gravity: without it nothing moves, and more of it bends further', async () => {
  const bend = () => page.evaluate(() => {
    window.thrum.reset();
    window.thrum.step(20);
    return Math.hypot(...window.thrum.q(0));
  });
  await fresh();
  const normal = await bend();
  await slide('gravity', 0);
  assert.equal(await bend(), 0);
  await slide('gravity', 19.62);
  assert.ok(Math.abs(await bend() / normal - 2) < 0.2);
});

test('stiffness: four times the modulus doubles the frequencies', async () => {
  await fresh();
  const frequency = () => page.evaluate(() => window.thrum.frequencies(0)[0]);
  const before = await frequency();
  await slide('stiffness', 2);
  assert.ok(Math.abs(await frequency() / before - 2) < 1e-9);
});

test('frequencies as stepped follow the integrator and the time step', async () => {
  await fresh();
  await page.selectOption('#integrator', 'newmark');
  const ask = (name) => page.evaluate((key) => window.thrum[key](0), name);
  const [own, stepped] = [await ask('frequencies'), await ask('steppedFrequencies')];
  const dt = await page.evaluate(() => window.thrum.settings().dt);
  own.forEach((frequency, n) => {
    const expected = Math.atan(Math.PI * dt * frequency) / (Math.PI * dt);
    assert.ok(Math.abs(stepped[n] / expected - 1) < 1e-9);
  });
  await page.waitForFunction(() => document.getElementById('split').title.includes('stepped'));
});

test('time step, rank and integrator', async () => {
  await fresh();
  await slide('dt', -2);
  await page.evaluate(() => window.thrum.step(10));
  assert.ok(Math.abs(await page.evaluate(() => window.thrum.time()) - 0.1) < 1e-9);
  await slide('rank', 4);
  const [rank, q] = await page.evaluate(() => {
    window.thrum.step(10);
    return [window.thrum.report(0).rank, window.thrum.q(0)];
  });
  assert.equal(rank, 4);
  assert.ok(q.every((value) => value !== 0)); // those that are not stepped follow
  for (const name of ['newmark', 'energy', 'verlet', 'midpoint', 'fox-goodwin', 'backward-euler',
    'semi-implicit-euler', 'rk4', 'imexv']) {
    await page.selectOption('#integrator', name);
    assert.equal(await page.evaluate(() => window.thrum.report(0).integrator), name);
  }
});

test('damping takes energy, and without it `energy` keeps it to 1e-9', async () => {
  await fresh();
  await page.selectOption('#integrator', 'energy');
  const run = () => page.evaluate(() => {
    window.thrum.reset();
    window.thrum.step(1000);
    return window.thrum.energies(0);
  });
  await slide('damping', 0);
  const free = await run();
  assert.ok(Math.abs(free.total) <= 1e-9 * Math.max(free.kinetic, -free.gravity));
  await slide('damping', 2);
  assert.ok((await run()).total < -0.1 * Math.abs(free.gravity));
});

test('colours have a scale, which stands for the largest value so far', async () => {
  await fresh();
  await page.selectOption('#colour', 'displacement');
  for (const name of ['edges', 'held']) await page.check(`#${name}`);
  await page.evaluate(() => window.thrum.step(60));
  const [top, values, moved] = await page.evaluate(() => {
    const { thrum } = window;
    const rest = thrum.scaleTop();
    const at = Array.from({ length: thrum.vertexCount(0) }, (_, v) => thrum.position(0, v));
    thrum.reset();
    const far = at.map((x, v) => Math.hypot(...thrum.position(0, v).map((y, i) => y - x[i])));
    return [rest, thrum.values(0), Math.max(...far)];
  });
  assert.ok(top > 0 && Math.abs(top / moved - 1) < 1e-4, `${top}, not ${moved}`);
  assert.ok(Math.abs(Math.max(...values) / top - 1) < 1e-6);
  await page.selectOption('#colour', 'stress');
  await page.evaluate(() => window.thrum.step(60));
  await page.waitForFunction(() => /[1-9].*Pa/.test(document.getElementById('scale-top').textContent));
  await page.selectOption('#colour', 'own');
  await page.waitForSelector('#scale', { state: 'hidden' });
});

test('the scale of a body at rest is not that of rounding', async () => {
  await fresh();
  await page.evaluate(() => { window.thrum.set('gravity', 0); window.thrum.reset(); });
  const top = (colour) => page.evaluate((name) => {
    window.thrum.set('colour', name);
    window.thrum.step(3);
    return [window.thrum.scaleTop(), Math.max(...window.thrum.values(0))];
  }, colour);
  const [stress, displacement] = [await top('stress'), await top('displacement')];
  const young = 1e-9 * pack.models[0].young;
  assert.ok(stress[0] >= young && stress[0] < 1.001 * young && stress[1] < 1e-3 * young, `${stress}`);
  assert.ok(Math.abs(displacement[0] / (1e-9 * Math.hypot(1, 0.2, 0.2)) - 1) < 1e-5, `${displacement}`);
  await page.evaluate(() => { window.thrum.set('colour', 'own'); window.thrum.set('gravity', 9.81); });
});

test('a model is chosen', async () => {
  await fresh();
  await page.selectOption('#model', '1');
  assert.equal(await page.evaluate(() => window.thrum.bodies()[0].model), 1);
  assert.equal(await page.evaluate(() => window.thrum.report(0).rank), mostStepped(pack.models[1]));
});

test('compare shows imexv, newmark and energy side by side, with their energies', async () => {
  await fresh();
  await page.click('#compare');
  const bodies = await page.evaluate(() => window.thrum.bodies());
  assert.deepEqual(bodies.map(({ name }) => name), ['imexv', 'newmark', 'energy']);
  assert.ok(bodies[0].position[0] < bodies[1].position[0]);
  assert.ok(bodies[1].position[0] < bodies[2].position[0]);
  const schemes = await page.evaluate(() =>
    [0, 1, 2].map((n) => window.thrum.report(n).integrator));
  assert.deepEqual(schemes, ['imexv', 'newmark', 'energy']);
  await page.evaluate(() => window.thrum.step(50));
  await page.waitForFunction(() => /imexv.*J.*newmark.*J.*energy.*J/.test(
    document.getElementById('legend').textContent));
  assert.equal(await page.locator('#labels span').count(), 3);
  await page.click('#compare');
  assert.equal(await page.evaluate(() => window.thrum.bodies().length), 1);
});

test('what a control is refused for is said on the page, until another is taken', async () => {
  await fresh();
  await page.evaluate(() => window.thrum.set('damping', -1));
  assert.ok(await page.locator('#notice').isVisible());
  await slide('damping', 1);
  assert.equal(await page.locator('#notice').isVisible(), false);
  assert.equal(await page.evaluate(() => window.thrum.settings().damping), 1);
});

test('a step that fails is said on the page, which stops', async () => {
  await fresh();
  await page.selectOption('#integrator', 'verlet');
  await slide('dt', -1.6);
  const went = await page.evaluate(() => window.thrum.step(3000));
  assert.equal(went, false);
  assert.ok(await page.locator('#notice').isVisible());
  assert.match(await page.textContent('#notice-text'), /^Stopped at 0\.\d+ s: .{20}/);
  await page.click('#reset');
  assert.equal(await page.locator('#notice').isVisible(), false);

  // each way out begins anew, with what it says
  await page.evaluate(() => window.thrum.step(3000));
  const { dt } = await page.evaluate(() => window.thrum.settings());

  // it runs at once; read before the next frame, as half the step fails soon as well
  const says = await page.locator('text=Halve the time step').evaluate((button) => {
    button.click();
    return document.querySelector('#pause').textContent;
  });
  assert.ok(Math.abs((await page.evaluate(() => window.thrum.settings().dt)) - dt / 2) < 1e-15);
  assert.equal(says, 'Pause');
  await page.evaluate(() => window.thrum.step(3000));
  await page.click('text=Use energy');
  await page.click('#pause');
  assert.equal(await page.inputValue('#integrator'), 'energy');
  assert.ok(await page.evaluate(() => window.thrum.step(300)));
  assert.equal(await page.locator('#notice').isVisible(), false);
});

test('keys act wherever the focus is', async () => {
  await fresh();
  const says = () => page.textContent('#pause');
  for (const focus of ['#reset', '#damping', '#speed']) {
    // as a click leaves it
    await page.evaluate((at) => {
      document.activeElement.blur();
      document.querySelector(at).focus({ focusVisible: false });
    }, focus);
    await page.keyboard.press(' ');
    assert.equal(await says(), 'Pause', focus);
    await page.keyboard.press(' ');
    assert.equal(await says(), 'Run', focus);
  }
  await page.keyboard.press(']');
  assert.equal(await page.inputValue('#speed'), '2');
  await page.keyboard.press('[');

  // a button that the keyboard has reached is pressed by Space
  await page.focus('#compare');
  await page.keyboard.press('Tab');
  await page.keyboard.press('Shift+Tab');
  await page.keyboard.press(' ');
  assert.equal(await page.evaluate(() => window.thrum.bodies().length), 3);
  assert.equal(await says(), 'Run');
});

/** Where the pointer and the pulled vertex are on the page, and their distance. */
const gap = (of, pull, at) => of.evaluate(([n, x, y]) => {
  const { body, vertex } = window.thrum.pulls()[n];
  const seen = window.thrum.project(body, vertex);
  return Math.hypot(seen.x - x, seen.y - y);
}, [pull, at.x, at.y]);

test('a mouse drags the vertex under it towards the cursor, and lets go', async () => {
  await fresh();
  await slide('damping', 5);
  await slide('gravity', 0);
  await slide('pull', 2);
  const at = await reach(1);
  await page.mouse.move(at.x, at.y);

  // a place that the model cannot show is told of while it is pulled
  await page.evaluate((v) => { window.thrum.follows(0)[v] = 30; }, at.v);
  await page.mouse.down();
  assert.equal(await page.evaluate(() => window.thrum.pulls()[0].vertex), at.v);
  assert.match(await page.locator('#hint').textContent(), /gives 30 % .* --touch/);
  const to = { x: at.x - 10, y: at.y - 60 };
  await page.mouse.move(to.x, to.y, { steps: 4 });
  const before = await gap(page, 0, to);
  await page.evaluate(() => window.thrum.step(1500));

  // the number beside the pointer is the force that holds the body where it is
  const force = await page.evaluate(() => window.thrum.pulls()[0].force);
  assert.ok(force > 1);
  await page.waitForFunction(() => /[\d.]+ k?N/.test(document.querySelector('#forces .force').textContent));
  const after = await gap(page, 0, to);
  assert.ok(before > 40 && after < 0.25 * before, `from ${before} to ${after} pixels`);
  await page.mouse.up();
  assert.equal(await page.evaluate(() => window.thrum.pulls().length), 0);
  assert.equal(await page.locator('#forces span').count(), 0);
  assert.ok(await page.locator('#hint').isHidden());
  await page.evaluate(() => window.thrum.step(2000));
  assert.ok(Math.hypot(...await page.evaluate(() => window.thrum.q(0))) < 1e-3);
  await slide('pull', 1);
});

test('a short press strikes a body, which sounds where that is asked for', async () => {
  await fresh();
  const at = await reach(1);
  const tap = () => page.evaluate(({ x, y }) => {
    const send = (type) => document.getElementById('view').dispatchEvent(new PointerEvent(type,
      { clientX: x, clientY: y, button: 0, pointerId: 1, bubbles: true }));
    document.getElementById('view').setPointerCapture = () => {};
    send('pointerdown');
    send('pointerup');
    delete document.getElementById('view').setPointerCapture;
  }, at);
  await tap();
  assert.equal(await page.evaluate(() => window.thrum.heard()), undefined);
  await page.check('#sound');
  await tap();
  await page.waitForFunction(() => document.getElementById('heard').textContent !== '');
  const { faster, frequencies } = await page.evaluate(() => window.thrum.heard());
  assert.ok(frequencies[0] < 20 && Math.abs(faster * frequencies[0] - 110) < 1e-9);

  // by the whole model where this machine is fast enough at that moment
  assert.match(await page.textContent('#heard'),
    /^(nonlinear, \d+ of \d+ coordinates|linear modes: a step takes .* µs of the .* µs of a sample), \d+ times as fast$/);
  assert.equal(await page.evaluate(() => window.thrum.pulls().length), 0);
  await page.uncheck('#sound');
});

test('a drag beside the body turns the view and pulls nothing', async () => {
  await fresh();
  const seen = () => page.evaluate(() => window.thrum.project(0, 0));
  const before = await seen();
  const beside = await page.evaluate(() => {
    for (let x = 20; ; x += 10) // below the buttons
      if (document.elementFromPoint(x, 120).id === 'view' && !window.thrum.pick(x, 120)) return x;
  });
  await page.mouse.move(beside, 120);
  await page.mouse.down();
  await page.mouse.move(beside + 60, 130, { steps: 3 });
  assert.equal(await page.evaluate(() => window.thrum.pulls().length), 0);
  await page.waitForTimeout(200);
  await page.mouse.up();
  const turned = await seen();
  assert.ok(Math.abs(turned.x - before.x) > 5, `${before.x} to ${turned.x}`);
});

test('two fingers pull two places', async () => {
  const own = await open(browser, standalone(pack), { hasTouch: true });
  await own.evaluate(() => {
    window.thrum.pause(true);
    window.thrum.set('damping', 5);
  });
  const touch = await own.context().newCDPSession(own);
  const places = [await reach(1, own), await reach(0.5, own)];
  const send = (type, shift) => touch.send('Input.dispatchTouchEvent', {
    type,
    touchPoints: type === 'touchEnd' ? [] : places.map(({ x, y }, id) => ({ x, y: y + shift, id })),
  });
  await send('touchStart', 0);
  await send('touchMove', -30);
  const pulls = await own.evaluate(() => window.thrum.pulls());
  assert.equal(pulls.length, 2);
  assert.notEqual(pulls[0].vertex, pulls[1].vertex);
  await own.evaluate(() => window.thrum.step(1500));
  assert.ok(await gap(own, 0, { x: places[0].x, y: places[0].y - 30 }) < 15);
  await send('touchEnd', 0);
  assert.equal(await own.evaluate(() => window.thrum.pulls().length), 0);
  assert.deepEqual(own.complaints, []);
  await own.close();
});

test('compared bodies are pulled alike', async () => {
  await fresh(true);
  await slide('damping', 5);
  const at = await reach(1);
  await page.mouse.move(at.x, at.y);
  await page.mouse.down();
  await page.mouse.move(at.x, at.y - 30, { steps: 3 });
  const shapes = await page.evaluate(() => {
    window.thrum.step(2000);
    return [0, 1, 2].map((n) => window.thrum.q(n));
  });
  await page.mouse.up();
  const size = Math.hypot(...shapes[0]);
  for (const q of shapes)
    assert.ok(Math.hypot(...q.map((value, i) => value - shapes[0][i])) < 1e-2 * size);
});

test('two bodies of a scene stay above its plane', async () => {
  const [body] = pack.scene.bodies;
  const floor = -0.12;
  const own = await open(browser, standalone({ ...pack, scene: {
    ...pack.scene, damping: 2,
    obstacles: [{ kind: 'plane', centre: [0, 0, floor], normal: [0, 0, 1] },
      { kind: 'sphere', centre: [0.5, 0.8, 0.1], radius: 0.1 }],
    bodies: [{ ...body, stiffness: 0.1 }, { ...body, name: 'other', position: [0, 0.5, 0.1] }],
  } }));
  const lowest = await own.evaluate(() => {
    window.thrum.pause(true);
    window.thrum.step(2000);
    return Math.min(...[0, 1].flatMap((body) => Array.from(
      { length: window.thrum.vertexCount(body) }, (_, v) => window.thrum.position(body, v)[2])));
  });
  assert.ok(Math.abs(lowest - floor) < 2e-3, `${lowest} m`);

  // what touches is marked where the floor is
  const touches = await own.evaluate(() => window.thrum.touches());
  assert.ok(touches.length >= 3);
  for (let n = 2; n < touches.length; n += 3)
    assert.ok(Math.abs(touches[n] - floor) < 2e-3, `${touches[n]} m`);
  assert.equal(await own.textContent('#model option:checked'), 'the scene');

  // three of the scene side by side, each with its own ball; a pull at one body is a pull at three
  await own.click('#compare');
  const bodies = await own.evaluate(() => window.thrum.bodies());
  assert.equal(bodies.length, 6);
  assert.deepEqual(bodies.slice(2, 4).map(({ position }) => position),
    [[0, 0, 0], [0, 0.5, 0.1]]); // that of newmark stays where it was
  assert.ok(bodies[4].position[0] > 1 && bodies[0].position[0] === -bodies[4].position[0]);
  const shapes = await own.evaluate(() => {
    window.thrum.step(100);
    return [1, 3, 5].map((n) => window.thrum.q(n));
  });
  const size = Math.hypot(...shapes[0]);
  assert.ok(size > 0);
  for (const q of shapes)
    assert.ok(Math.hypot(...q.map((x, i) => x - shapes[0][i])) < 0.1 * size);
  assert.deepEqual(own.complaints, []);
  await own.close();
});

test('links are marked as what they are, and a joint that comes open is said', async () => {
  const bar = { model: 'beam:4x2x2@0.4x0.1x0.1', free: true, collide: false };
  writeFileSync(join(folder, 'hung.json'), JSON.stringify({
    dt: 0.002, gravity: GRAVITY, bodies: [{ name: 'bar', ...bar }, { name: 'other', ...bar, position: [0, 1, 0] },
      { name: 'wheel', ...bar, coupled: true, position: [0, 2, 0] }],
    links: [{ name: 'pivot', kind: 'hinge', body: 'bar', place: [0, 0.05, 0.05], axis: [0, 1, 0] },
      { kind: 'spring', body: 'other', at: 'vertex=1', other_place: [0, 1, 0.5], stiffness: 400, until: 0.3 }],
  }));
  const own = await open(browser, standalone(packOf('hung.json')));
  const states = () => own.evaluate(() => window.thrum.links().map(({ state }) => state));
  const drawn = () => own.evaluate(() => window.thrum.shownLinks());
  await own.evaluate(() => {
    window.thrum.pause(true);
    window.thrum.reset();
    window.thrum.step(100);
  });
  assert.equal(await own.textContent('#model option:checked'), 'the scene');
  assert.deepEqual(await states(), ['joint', 'spring']);
  await own.waitForFunction(() => window.thrum.shownLinks().lines === 2);

  // what has let go keeps its points and loses its line
  await own.evaluate(() => window.thrum.step(100));
  assert.deepEqual(await states(), ['joint', 'released']);
  await own.waitForFunction(() => window.thrum.shownLinks().lines === 1);
  assert.deepEqual(await drawn(), { points: 4, lines: 1 });
  assert.equal(await own.evaluate(() => document.getElementById('notice').hidden), true);

  // bodies that are linked and those that are coupled keep their rank, and the latter their integrator
  const report = (name) => own.evaluate((of) => [0, 1, 2].map((body) => window.thrum.report(body)[of]), name);
  const ranks = await report('rank');
  await own.evaluate(() => window.thrum.set('rank', 3));
  assert.match(await own.evaluate(() => window.thrum.trouble()), /is or was linked/);
  await own.evaluate(() => window.thrum.set('integrator', 'newmark'));
  assert.deepEqual(await report('rank'), ranks);
  assert.deepEqual(await report('integrator'), ['newmark', 'newmark', 'energy']);
  assert.equal(await own.evaluate(() => window.thrum.trouble()), null);
  await own.evaluate(() => window.thrum.set('integrator', 'energy'));

  // copies are compared, in which what is coupled keeps its integrator
  await own.click('#compare');
  assert.equal(await own.evaluate(() => window.thrum.trouble()), null);
  assert.deepEqual(await own.evaluate(() => [1, 2, 4, 5, 7, 8].map((body) => window.thrum.report(body).integrator)),
    ['imexv', 'energy', 'newmark', 'energy', 'energy', 'energy']);
  await own.click('#compare');

  // where one moves too far in a step, its joint opens
  await own.evaluate(() => { window.thrum.set('dt', 0.05); window.thrum.step(20); });
  await own.waitForFunction(() => /The joint pivot was open by/.test(document.getElementById('notice-text').textContent));
  assert.equal((await states())[0], 'open');

  // unless it is asked for nothing is marked
  await own.click('#links');
  await own.waitForFunction(() => window.thrum.shownLinks().points === 0);
  assert.deepEqual(own.complaints, []);
  await own.close();
});

test('bodies that are all coupled are compared with the coupling and without', async () => {
  const bar = { model: 'beam:6x2x2@0.6x0.1x0.1', material: { young: 2e5 }, free: true, coupled: true };
  writeFileSync(join(folder, 'spun.json'), JSON.stringify({ dt: 0.002, bodies: [
    { name: 'bar', ...bar, spin: [0, 0, 900] }, { name: 'other', ...bar, position: [0, 2, 0], spin: [0, 0, 300] }] }));
  const own = await open(browser, standalone(packOf('spun.json')));
  await own.evaluate(() => window.thrum.pause(true));
  await own.click('#compare');
  assert.equal(await own.evaluate(() => window.thrum.trouble()), null);
  const bodies = await own.evaluate(() => window.thrum.bodies());
  assert.deepEqual(bodies.map(({ name }) => name), ['bar coupled', 'other coupled', 'bar not coupled', 'other not coupled']);
  assert.deepEqual(await own.locator('#labels span').allTextContents(), ['coupled', 'not coupled']);

  // what spins without coupling is not strained, and both keep their energy
  const strains = await own.evaluate(() => {
    const energies = () => [0, 1, 2, 3].map((n) => window.thrum.energies(n));
    const before = energies();
    window.thrum.step(40);
    return energies().map(({ potential, total }, n) => ({ potential, change: total / before[n].total - 1 }));
  });
  assert.ok(strains[0].potential > 1e-3 && strains[1].potential > 1e-6, JSON.stringify(strains));
  assert.ok(strains[2].potential < 1e-20 && strains[3].potential < 1e-20, JSON.stringify(strains));
  for (const { change } of strains) assert.ok(Math.abs(change) < 1e-12, JSON.stringify(strains));
  await own.waitForFunction(() => /strain, coupled .*J.*strain, not coupled .*J/.test(
    document.getElementById('legend').textContent));

  // and one of them alone is compared as well
  await own.selectOption('#model', '0');
  assert.deepEqual(await own.evaluate(() => window.thrum.bodies().map(({ name }) => name)), ['coupled', 'not coupled']);
  assert.deepEqual(own.complaints, []);
  await own.close();
});

test('nothing of the page lies over anything else, on screens of many sizes', async () => {
  const screens = [[1280, 800], [1010, 620], [920, 560], [800, 600], [730, 560], [600, 800], [390, 844], [844, 390], [667, 375]];
  for (const [width, height] of screens) {
    const own = await open(browser, standalone(pack), { viewport: { width, height } });
    await own.evaluate(() => window.thrum.pause(true));
    for (const settings of [true, false]) {
      if (await own.locator('#panel').isVisible() !== settings) await own.click('#menu');
      const over = await own.evaluate((bottom) => {
        const parts = ['header', '#panel', '#energy', '#hint'].map((name) => [name, document.querySelector(name)])
          .filter(([, part]) => !part.hidden && part.getClientRects().length > 0)
          .map(([name, part]) => [name, part.getBoundingClientRect()]);
        return parts.flatMap(([one, a], n) => parts.slice(n + 1).flatMap(([other, b]) => {
          // a sheet of settings from below covers the plot as long as it is open
          if (bottom && one === '#panel' && other === '#energy') return [];
          const apart = a.right <= b.left || b.right <= a.left || a.bottom <= b.top || b.bottom <= a.top;
          return apart ? [] : [`${one} and ${other}`];
        }));
      }, width <= 720 && height > 420);
      assert.deepEqual(over, [], `${width} x ${height}, settings ${settings ? 'open' : 'closed'}`);
    }
    await own.close();
  }
});

/** What the browser saves when a button is pressed. */
async function saved(button) {
  const download = page.waitForEvent('download');
  await page.click(button);
  const file = await download;
  return { name: file.suggestedFilename(), bytes: readFileSync(await file.path()) };
}

test('the picture is drawn as finely as asked for', async () => {
  await fresh();
  const width = () => page.evaluate(() => document.getElementById('view').width);
  await page.selectOption('#quality', 'full');
  assert.equal(await width(), 760);
  await page.selectOption('#quality', 'half');
  assert.equal(await width(), 380);
  await page.selectOption('#quality', 'auto');
  assert.ok(['full', 'plain', 'half', 'coarse'].includes(await page.evaluate(() => window.thrum.level())));
});

test('a picture is saved', async () => {
  await fresh();
  await page.selectOption('#quality', 'coarse');
  const { name, bytes } = await saved('#picture');
  assert.equal(name, 'thrum.png');
  assert.equal(bytes.toString('latin1', 1, 4), 'PNG');

  // as fine as the page, whatever is drawn on it, which stays as it was
  assert.deepEqual([16, 20].map((at) => bytes.readUInt32BE(at)), [760, 440]);
  assert.equal(await page.evaluate(() => document.getElementById('view').width), Math.floor(0.33 * 760));
  await page.selectOption('#quality', 'auto');
  assert.ok(bytes.length > 3000, `${bytes.length} bytes`); // an empty one is smaller
});

test('a link carries the settings', async () => {
  await fresh();
  await page.evaluate(() => { window.thrum.set('damping', 1.5); window.thrum.set('colour', 'stress'); });
  await page.click('#compare');
  await page.click('#link');
  const hash = await page.evaluate(() => window.location.hash);
  await fresh();
  await page.evaluate((to) => {
    window.thrum.set('damping', 0);
    window.thrum.set('colour', 'own');
    window.history.replaceState(null, '', '#');
    window.location.hash = to;
  }, hash);
  await page.waitForFunction(() => window.thrum.bodies().length === 3);
  const { damping, colour } = await page.evaluate(() => window.thrum.settings());
  assert.deepEqual([damping, colour], [1.5, 'stress']);

  // an address that names nothing known changes nothing, and says so
  await page.evaluate(() => { window.location.hash = '#integrator=none&colour=none&choice=9&dt=x'; });
  await page.waitForFunction(() => /there is no|there are no/.test(document.getElementById('notice-text').textContent));
  assert.equal((await page.evaluate(() => window.thrum.settings())).colour, 'stress');

  // one of a model of a larger rank shows all coordinates of this one
  const { pull } = await page.evaluate(() => window.thrum.settings());
  await page.evaluate(() => { window.location.hash = '#rank=9999&pull=-10'; });
  await page.waitForFunction(() => window.thrum.settings().rank !== 9999
    && window.location.hash === '#rank=9999&pull=-10');
  assert.equal(await page.evaluate(() => window.thrum.settings().rank),
    await page.evaluate(() => Number(document.getElementById('rank').max)));
  assert.equal((await page.evaluate(() => window.thrum.settings())).pull, pull);
  await page.evaluate(() => { window.history.replaceState(null, '', '#'); window.thrum.set('colour', 'own'); });
});

test('dark where the system is, and whole on a phone on its side', async () => {
  const paper = () => page.evaluate(() => window.getComputedStyle(document.body).backgroundColor);
  const light = await paper();
  await page.emulateMedia({ colorScheme: 'dark' });
  assert.notEqual(await paper(), light);

  // curves stand out from the page by what WCAG 2 asks of graphics, 3 : 1, in the light and in the dark
  const luminance = (hex) => [1, 3, 5].map((at) => parseInt(hex.slice(at, at + 2), 16) / 255)
    .map((c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4))
    .reduce((sum, c, n) => sum + [0.2126, 0.7152, 0.0722][n] * c, 0);
  for (const colorScheme of ['dark', 'light']) {
    await page.emulateMedia({ colorScheme });
    const [ground, ...curves] = (await page.evaluate(() => ['page', 'ink', 'kinetic', 'strain', 'gravity', 'contact', 'links']
      .map((name) => window.getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim()))).map(luminance);
    for (const curve of curves) {
      const contrast = (Math.max(curve, ground) + 0.05) / (Math.min(curve, ground) + 0.05);
      assert.ok(contrast >= 3, `${colorScheme}: ${curves} on ${ground}`);
    }
  }
  await page.setViewportSize({ width: 740, height: 340 });
  const [header, energy] = await Promise.all(['header', '#energy'].map((at) =>
    page.locator(at).boundingBox()));
  assert.ok(header.y + header.height < energy.y);
  assert.ok(energy.y + energy.height <= 340 && header.x + header.width <= 740);
  await page.setViewportSize({ width: 760, height: 440 });
});

test('records a video', async () => {
  await fresh();
  await page.click('#pause');

  // drawn as finely as the page is, also where that takes long
  const [level, judge] = [() => page.evaluate(() => window.thrum.level()),
    (time) => page.evaluate((ms) => { for (let n = 0; n < 12; n++) window.thrum.judge(ms); }, time)];
  await judge(1000);
  assert.equal(await level(), 'coarse');
  await page.click('#record');
  await judge(1000);
  assert.equal(await level(), 'plain');
  await page.waitForFunction(() => window.thrum.recorded() > 2000);
  const { name, bytes: video } = await saved('#record');
  assert.equal(name, 'thrum.webm');
  assert.equal(video.readUInt32BE(0), 0x1a45dfa3); // how every WebM begins, RFC 8794
  assert.ok(video.length > 2000);
  assert.notEqual(await level(), 'plain');
});

test('models and pages are opened in place of what was shown', async () => {
  // by another name than the body has that is shown already, so that one can wait for it
  copyFileSync(join(folder, 'beam.npz'), join(folder, 'opened.npz'));
  await page.setInputFiles('#files', join(folder, 'opened.npz'));
  await page.waitForFunction(() => window.thrum.bodies()[0].name === 'opened.npz');

  // as `thrum view` packs it, but for the order of the vertices
  const { rank, vertex_count: vertices, arrays } = pack.models[0];
  assert.equal(await page.evaluate(() => window.thrum.vertexCount(0)), vertices);
  const held = await page.evaluate(() => window.thrum.fixed(0).filter((bits) => bits === 7).length);
  assert.equal(held, arrays.fixed.filter((bits) => bits === 7).length);
  assert.equal((await page.evaluate(() => window.thrum.report(0))).rank, rank);
  await page.evaluate(() => { window.thrum.pause(true); window.thrum.set('gravity', 9.81); window.thrum.step(50); });
  assert.ok(Math.hypot(...await page.evaluate(() => window.thrum.q(0))) > 1e-3);

  // what cannot be shown is refused with what to do, and what is there stays
  for (const [name, words] of [['bridge.veg', /thrum precompute bridge.veg -o bridge.npz/],
    ['horse.obj', /thrum mesh horse.obj/], ['run.glb', /thrum view RUN/],
    ['scene.json', /^scene.json: .*JSON/], ['broken.npz', /^broken.npz: ./], ['a.html', /thrum view/]]) {
    writeFileSync(join(folder, name), 'nothing of use');
    await page.setInputFiles('#files', join(folder, name));
    await page.waitForFunction((pattern) => new RegExp(pattern).test(
      document.getElementById('notice-text').textContent), words.source);
  }
  assert.equal((await page.evaluate(() => window.thrum.bodies()))[0].name, 'opened.npz');

  // a scene with the model that it names
  writeFileSync(join(folder, 'small.json'), JSON.stringify({ gravity: GRAVITY, bodies: [{ name: 'left', model: 'opened.npz' },
    { name: 'right', model: 'opened.npz', position: [0, 1, 0] }], links: [{ kind: 'ball', body: 'right', at: 'tip' }] }));
  await page.setInputFiles('#files', [join(folder, 'small.json'), join(folder, 'opened.npz')]);
  await page.waitForFunction(() => window.thrum.bodies()[1]?.name === 'right');
  assert.deepEqual(await page.evaluate(() => window.thrum.links().map(({ state }) => state)), ['joint']);

  // one that is refused leaves what is there running, and the next one runs
  await page.evaluate(() => window.thrum.pause(false));
  const runs = async () => {
    const from = await page.evaluate(() => window.thrum.time());
    await page.waitForFunction((then) => window.thrum.time() > then, from);
  };
  const open = async (name, scene) => {
    writeFileSync(join(folder, name), JSON.stringify(scene));
    await page.setInputFiles('#files', [join(folder, name), join(folder, 'opened.npz')]);
  };
  await open('wrong.json', { bodies: [{ model: 'opened.npz' }], obstacles: [{ shape: 'box' }] });
  await page.waitForFunction(() => document.getElementById('notice-text').textContent === 'wrong.json: obstacles[0]: a box needs "size"');
  assert.equal((await page.evaluate(() => window.thrum.bodies())).length, 2);
  await runs();
  await open('plane.json', { gravity: GRAVITY, obstacles: [{ shape: 'plane' }],
    bodies: [{ name: 'over', model: 'opened.npz', position: [0, 0, 9] }] });
  await page.waitForFunction(() => window.thrum.bodies()[0].name === 'over');
  await runs();
  assert.equal(await page.evaluate(() => window.thrum.trouble()), null);

  // one may name the models that the page came with
  await open('own.json', { bodies: [{ name: 'own', model: 'beam' }] });
  await page.waitForFunction(() => window.thrum.bodies()[0].name === 'own');

  // one that is dropped after a simulation that failed runs, too
  await page.evaluate(() => { window.thrum.set('integrator', 'verlet'); window.thrum.set('dt', 0.02); window.thrum.set('gravity', 3000); });
  await page.waitForFunction(() => /^Stopped at/.test(document.getElementById('notice-text').textContent));
  await open('after.json', { bodies: [{ name: 'after', model: 'opened.npz' }] });
  await page.waitForFunction(() => window.thrum.bodies()[0].name === 'after');
  await runs();

  // a page of thrum view; the last file of packOf() is one
  await page.setInputFiles('#files', join(folder, 'packed.html'));
  await page.waitForFunction(() => document.querySelectorAll('#model option').length === 2);
});

test('after all that the console has nothing to complain of', () => {
  assert.deepEqual(page.complaints, []);
});
