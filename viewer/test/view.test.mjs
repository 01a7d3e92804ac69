// The pages that `thrum view` writes, in headless Chromium.
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { readFileSync, realpathSync, writeFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { stretchesOf } from '../src/curve_plot.js';
import { mostStepped } from '../src/pack.js';
import { folder, launch, open, packOf, thrum } from './fixture.mjs';

let browser;

before(async () => {
  thrum('precompute', 'beam:8x2x2@1x0.2x0.2,split=6', '--order', '1', '--fix', 'x<0.001', '--modes', '5', '--rank', '9',
    '-o', 'beam.npz', '--quiet');
  browser = await launch();
});

after(() => browser?.close());

/** The page runs: it has the model, and time goes on. */
async function expectRunning(url) {
  const page = await open(browser, url);
  await page.waitForFunction(() => window.thrum.time() > 0.05);
  assert.ok(await page.evaluate(() => window.thrum.vertexCount(0)) > 50);
  assert.deepEqual(page.complaints, []);
  await page.close();
}

test('the page without a name runs at the address that is printed', async () => {
  const { url } = JSON.parse(thrum('view', 'beam.npz', '--json', '--no-open', '-q'));
  assert.equal(url, pathToFileURL(join(realpathSync(folder), 'thrum_view.html')).href);
  await expectRunning(url);
});

test('the page written by -o runs from the disk', async () => {
  thrum('view', 'beam.npz', '-o', 'beam.html', '-q');
  await expectRunning(pathToFileURL(join(folder, 'beam.html')).href);
});

test('the models that come with Thrum follow a pull at any vertex by 80 % of what their meshes give', () => {
  for (const model of packOf('beam', 'basket', 'bridge', 'horse', 'tower', 'heart').models) {
    assert.ok(Math.min(...model.arrays.follows) >= 80, model.name);
    assert.ok(mostStepped(model) <= 30, model.name);
  }
});

const SCENE = {
  dt: 0.002, time: 1, gravity: [0, 0, -9.81], damping: 0.5,
  bodies: [
    { name: 'held', model: 'beam.npz', rank: 6, integrator: 'newmark', position: [0, 1, 1],
      rotation: { axis: [0, 0, 1], angle: 40 }, stiffness: 2 },
    { name: 'block', model: 'beam:4x3x2@0.4x0.3x0.2', material: { young: 2e5 }, free: true,
      position: [0, 0, 0.5], velocity: [0.2, 0, 0], spin: [20, -30, 40], colour: '#d08030' },
    { name: 'few', model: 'beam.npz', condense: 4, integrator: 'manifold', position: [0, -2, 1],
      scale: 0.5 },
  ],
  obstacles: [{ shape: 'plane' }, { shape: 'sphere', centre: [0.5, 0, 0], radius: 0.15 }],
  probes: [{ name: 'a', body: 'held', at: 'vertex=5' }, { name: 'b', body: 'block', at: 'vertex=1' },
    { name: 'c', body: 'few', at: 'vertex=5' }],
};

test('a scene moves on the page as thrum simulate moves it', async () => {
  writeFileSync(join(folder, 'scene.json'), JSON.stringify(SCENE));
  thrum('simulate', 'scene.json', '-o', 'run', '-q');
  thrum('view', 'scene.json', '-o', 'scene.html', '-q');
  const rows = readFileSync(join(folder, 'run/probes.csv'), 'utf8').trim().split('\n').slice(1)
    .map((line) => line.split(',').map(Number));
  const page = await open(browser, pathToFileURL(join(folder, 'scene.html')).href);
  await page.evaluate(() => {
    window.thrum.pause(true);
    window.thrum.reset();
  });
  // at the start, in free fall, and some touches later; the page has X and U in single precision, and
  // a start that is 1e-7 m off has grown tenfold then. At 1 s, after more touches, one of 1e-9 m has
  // grown to 6 mm
  for (const [steps, within] of [[0, 1e-7], [100, 1e-7], [200, 1e-5]]) {
    const [held, block, few] = await page.evaluate((count) => {
      window.thrum.step(count);
      return [window.thrum.position(0, 4), window.thrum.position(1, 0),
        window.thrum.position(2, 4)];
    }, steps);
    const row = rows[{ 0: 0, 100: 100, 200: 300 }[steps]];
    held.forEach((x, axis) => assert.ok(Math.abs(x - row[2 + axis]) < 1e-6, `held: ${x}`));
    few.forEach((x, axis) => assert.ok(Math.abs(x - row[14 + axis]) < 1e-6, `few: ${x}`));
    block.forEach((x, axis) =>
      assert.ok(Math.abs(x - row[8 + axis]) < within, `${row[1]} s: ${block}, not ${row.slice(8, 11)}`));
  }
  assert.deepEqual(page.complaints, []);
  await page.close();
});

test('a finished run is played, with its obstacles, at any moment of it', async () => {
  thrum('view', 'run', '-o', 'run.html', '--fps', '0', '-q');
  const page = await open(browser, pathToFileURL(join(folder, 'run.html')).href);
  assert.equal(await page.textContent('#model option:checked'), 'the run');
  assert.equal(await page.locator('#integrator').isVisible(), false);
  await page.waitForFunction(() => window.thrum.time() > 0.1);

  // the block where its probe was, between rows too; the page has q and places in single precision
  const rows = readFileSync(join(folder, 'run/probes.csv'), 'utf8').trim().split('\n').slice(1)
    .map((line) => line.split(',').map(Number));
  for (const row of [0, 150, 333.5]) {
    const at = [rows[Math.floor(row)], rows[Math.ceil(row)]];
    const mean = (column) => (at[0][column] + at[1][column]) / 2;
    const place = await page.evaluate((time) => {
      window.thrum.seek(time);
      return window.thrum.shownPosition(1, 0);
    }, mean(1));
    place.forEach((x, axis) => assert.ok(Math.abs(x - mean(8 + axis)) < 1e-5, `${row}: ${place}`));
  }

  // by whole rows, to its ends, and from its end from the beginning again
  const time = () => page.evaluate(() => window.thrum.time());
  await page.keyboard.press('ArrowRight');
  assert.ok(Math.abs(await time() - rows[334][1]) < 1e-12);
  await page.keyboard.press('End');
  assert.equal(await time(), rows.at(-1)[1]);
  assert.equal(await page.evaluate(() => {
    document.getElementById('pause').click();
    return window.thrum.time();
  }), 0);
  assert.equal(await page.textContent('#pause'), 'Pause');
  await page.fill('#scrub', '0.25');
  assert.equal(await time(), 0.25);
  assert.match(await page.textContent('#legend'), /kinetic \+ strain .*J/);
  assert.deepEqual(page.complaints, []);
  await page.close();
});

test('stable and unstable stretches of a curve meet in a point', () => {
  const stretches = (...unstable) => stretchesOf(Int32Array.from(unstable)).map(({ first, last, isUnstable }) => [first, last, isUnstable]);
  assert.deepEqual(stretches(0, 0, 1, 2, -1), [[0, 2, false], [2, 4, true], [4, 4, false]]);
  assert.deepEqual(stretches(1), [[0, 0, true]]);
});

test('a point of a curve is picked on its drawing, and the body moves as in its row', async () => {
  thrum('precompute', 'beam:8x1x1@1x0.02x0.04', '--fix', 'x<0.001', '--fix', 'x>0.999', '--modes', '2', '--rank', '5', '-o', 'thin.npz',
    '--quiet');
  thrum('response', 'thin.npz', '--load', 'sine:0,0.004,0@vertex=17', '--at', 'vertex=17', '--damping-ratio', '0.01', '--from', '1.5', '--to', '2',
    '-o', 'curve', '--no-check', '-q');
  thrum('view', 'curve', '-o', 'curve.html', '-q');
  const [names, ...rows] = readFileSync(join(folder, 'curve/response.csv'), 'utf8').trim().split('\n').map((line) => line.split(','));
  const of = (row, name) => Number(rows[row][names.indexOf(name)]);
  const page = await open(browser, pathToFileURL(join(folder, 'curve.html')).href);
  assert.equal(await page.textContent('#model option:checked'), 'the curve');

  // it begins with the largest motion, and a press on an unstable one shows that
  const peaks = rows.map((_, row) => of(row, 'peak1_m'));
  assert.equal(await page.evaluate(() => window.thrum.point()), 1 + peaks.indexOf(Math.max(...peaks)));
  const row = rows.findIndex((cells) => cells[names.indexOf('unstable')] === '1') + 4;
  const box = await page.locator('#plot').boundingBox();
  const [x, y] = await page.evaluate((point) => window.thrum.pointPlace(point), row + 1);
  await page.mouse.click(box.x + x, box.y + y);
  await page.waitForFunction((point) => window.thrum.point() === point, row + 1);
  await page.waitForFunction(() => /unstable/.test(document.getElementById('clock').textContent));
  assert.match(await page.textContent('#legend'), /stable.*unstable.*fold/);

  // magnified, it is where its harmonics say; the page has U and the motion in single precision
  const moved = (phase) => page.evaluate((time) => {
    window.thrum.seek(time);
    return window.thrum.shownPosition(0, 16);
  }, phase);
  await page.evaluate(() => window.thrum.set('magnify', 3));
  const rest = await page.evaluate(() => {
    window.thrum.set('magnify', 1e-9);
    const at = window.thrum.shownPosition(0, 16);
    window.thrum.set('magnify', 3);
    return at;
  });
  const harmonics = names.filter((name) => /^y1_h[0-9]+_m$/.test(name)).length;
  for (const phase of [0, 0.2, 0.65]) {
    const place = await moved(phase);
    [...'xyz'].forEach((axis, n) => {
      let u = of(row, `${axis}1_mean_m`);
      for (let k = 1; k <= harmonics; k++)
        u += of(row, `${axis}1_h${k}_m`) * Math.sin(2 * Math.PI * k * phase + of(row, `${axis}1_h${k}_deg`) * Math.PI / 180);
      assert.ok(Math.abs(place[n] - rest[n] - 3 * u) < 2e-6 + 1e-3 * peaks[row], `${axis} at ${phase}: ${place[n] - rest[n]}, not ${3 * u}`);
    });
  }

  // along the curve by keys while the motion goes on
  await page.evaluate(() => window.thrum.pause(false));
  await page.keyboard.press('ArrowRight');
  assert.equal(await page.evaluate(() => window.thrum.point()), row + 2);
  assert.equal(await page.textContent('#pause'), 'Pause');
  assert.deepEqual(page.complaints, []);
  await page.close();
});

const LINKS = new URL('../../examples/scenes/links.json', import.meta.url).pathname;

test('what swings on joints stays in the picture, stepped and played', async () => {
  thrum('simulate', LINKS, '-o', 'swung', '--quiet');
  for (const [shown, plays] of [[LINKS, false], ['swung', true]]) {
    thrum('view', shown, '-o', 'swung.html', '--quiet');
    const page = await open(browser, pathToFileURL(join(folder, 'swung.html')).href);
    const outside = await page.evaluate((recorded) => {
      const { thrum: page } = window;
      page.pause(true);
      if (!recorded) page.reset();
      const { width, height } = document.getElementById('view').getBoundingClientRect();
      let worst = -Infinity;
      for (let time = 0.05; time < 2; time += 0.05) { // then the lower bar falls
        if (recorded) page.seek(time);
        else page.step(25);
        for (const body of [0, 1]) // bars of 0.4 x 0.1 x 0.1
          for (let corner = 0; corner < 8; corner++) {
            const at = [0.4 * (corner & 1), 0.05 * ((corner & 2) - 1), 0.05 * ((corner & 4) / 2 - 1)];
            const m = page.matrix(body);
            const { x, y } = page.projectPlace([0, 1, 2].map((axis) =>
              m[axis] * at[0] + m[4 + axis] * at[1] + m[8 + axis] * at[2] + m[12 + axis]));
            worst = Math.max(worst, -x, x - width, -y, y - height);
          }
      }
      return worst;
    }, plays);
    assert.ok(outside < 0, `${shown}: ${outside} px outside`);
    assert.deepEqual(page.complaints, []);
    await page.close();
  }
});
