// Counts the pictures a second of the horse at 1280 x 800, drawn by Chromium's software renderer, at each quality while
// it sways: node test/rate.mjs [MODEL], with THRUM_VIEWER and THRUM_PROGRAM set. Run it on a machine with nothing else to do.
// SPDX-License-Identifier: Apache-2.0
import { launch, open, packOf, standalone } from './fixture.mjs';
import { QUALITIES } from '../src/quality.js';

const MODEL = process.argv[2] ?? 'horse';
const SETTLE = 12; // until auto has chosen and shaders are compiled [s]
const SECONDS = 10; // counted at each quality [s]

const pack = packOf(MODEL);
pack.scene.gravity = [0, 0, -9.81];
const browser = await launch();
const page = await open(browser, standalone(pack), { viewport: { width: 1280, height: 800 } });
const rates = {};
for (const quality of QUALITIES) {
  await page.selectOption('#quality', quality);
  await page.waitForTimeout(1000 * SETTLE);
  const before = await page.evaluate(() => window.thrum.times().frame.count);
  const begin = performance.now();
  await page.waitForTimeout(1000 * SECONDS);
  const { count, level } = await page.evaluate(() => ({ count: window.thrum.times().frame.count, level: window.thrum.level() }));
  rates[quality] = { level, pictures_per_s: (count - before) / (1e-3 * (performance.now() - begin)) };
}
console.log(JSON.stringify({ model: MODEL, rates }));
await browser.close();
