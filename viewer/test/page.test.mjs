// The page as a person has it, in headless Chromium: opens, deforms, obeys each control.
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { after, before, test } from 'node:test';
import { launch, open, packOf, serve, standalone, thrum } from './fixture.mjs';

const GRAVITY = [0, 0, -9.81];
let browser, pack, page;

before(async () => {
  thrum('precompute', 'beam:8x2x2@1x0.2x0.2', '--fix', 'x<0.001', '--modes', '5', '--rank', '9',
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

/** The free vertex that lies furthest along x: the tip. */
const tip = (of = page) => of.evaluate(() => {
  const { thrum } = window;
  const x = Array.from({ length: thrum.vertexCount(0) }, (_, v) => thrum.position(0, v)[0]);
  return x.indexOf(Math.max(...x));
});

test('opens from the disk, moves by itself and complains of nothing', async () => {
  const own = await open(browser, standalone(pack));
  await own.waitForFunction(() => window.thrum.time() > 0.1);
  assert.equal(await own.evaluate(() => window.thrum.trouble()), null);
  assert.ok(await own.evaluate(() => window.thrum.times().draw.count) > 0);
  assert.deepEqual(own.complaints, []);
  await own.close();
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
  const v = await tip();
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
  assert.ok(q[3] !== 0 && q.slice(4).every((value) => value === 0));
  for (const name of ['newmark', 'energy', 'verlet', 'midpoint', 'imexv']) {
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

test('a model is chosen', async () => {
  await fresh();
  await page.selectOption('#model', '1');
  assert.equal(await page.evaluate(() => window.thrum.bodies()[0].model), 1);
  assert.equal(await page.evaluate(() => window.thrum.report(0).rank), pack.models[1].rank);
});

test('compare shows imexv, newmark and energy side by side, with their energies', async () => {
  await fresh();
  await page.click('#compare');
  const bodies = await page.evaluate(() => window.thrum.bodies());
  assert.deepEqual(bodies.map(({ name }) => name), ['imexv', 'newmark', 'energy']);
  assert.ok(bodies[0].position[0] < bodies[1].position[0]);
  assert.ok(bodies[1].position[0] < bodies[2].position[0]);
  const schemes = await page.evaluate(() => [0, 1, 2].map((n) => window.thrum.report(n).integrator));
  assert.deepEqual(schemes, ['imexv', 'newmark', 'energy']);
  await page.evaluate(() => window.thrum.step(50));
  await page.waitForFunction(() => /imexv.*J.*newmark.*J.*energy.*J/.test(
    document.getElementById('legend').textContent));
  assert.equal(await page.locator('#labels span').count(), 3);
  await page.click('#compare');
  assert.equal(await page.evaluate(() => window.thrum.bodies().length), 1);
});

test('a step that fails is said on the page, which stops', async () => {
  await fresh();
  await page.selectOption('#integrator', 'verlet');
  await slide('dt', -1.6);
  const went = await page.evaluate(() => window.thrum.step(3000));
  assert.equal(went, false);
  assert.ok(await page.locator('#notice').isVisible());
  assert.ok((await page.textContent('#notice')).length > 20);
  await page.click('#reset');
  assert.equal(await page.locator('#notice').isVisible(), false);
});

test('records a video', async () => {
  await fresh();
  await page.click('#pause');
  await page.click('#record');
  await page.waitForTimeout(1500);
  const download = page.waitForEvent('download');
  await page.click('#record');
  assert.equal((await download).suggestedFilename(), 'thrum.webm');
  assert.ok(await page.evaluate(() => window.thrum.video()) > 1000);
});

test('after all that the console has nothing to complain of', () => {
  assert.deepEqual(page.complaints, []);
});
