// Takes the pictures of the viewer that docs/tutorial.md shows, in headless Chromium.
// usage: node docs/pictures/tutorial.mjs hook.html docs/pictures/tutorial_viewer.png
// hook.html is what `thrum view hook.npz -o hook.html` wrote; viewer/node_modules must be installed.
// SPDX-License-Identifier: Apache-2.0
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { chromium } from '../../viewer/node_modules/playwright-core/index.mjs';

const TIP = [0.0604, 0, 0.0777]; // metres; the tutorial pulls the vertex nearest to it
const [, , html, picture] = process.argv;

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
    '--disable-quic', '--no-first-run', '--disable-background-networking',
    '--disable-component-update', '--disable-sync'],
});
const page = await browser.newPage({ viewport: { width: 920, height: 560 } });
await page.goto(pathToFileURL(resolve(html)).href);
await page.evaluate(() => window.thrum.ready);

// the vertex under the pointer that is nearest to the tip, where the pointer reaches it
const at = await page.evaluate((tip) => {
  const { thrum } = window;
  thrum.pause(true);
  thrum.set('damping', 2);
  thrum.reset();
  let best;
  for (let v = 0; v < thrum.vertexCount(0); v++) {
    const off = Math.hypot(...thrum.position(0, v).map((x, axis) => x - tip[axis]));
    const { x, y } = thrum.project(0, v);
    const seen = thrum.pick(x, y)?.vertex === v;
    if (seen && (!best || off < best.off)) best = { off, x, y };
  }
  return best;
}, TIP);

await page.check('#tint').catch(() => {});

// pull it down and to the side, and let the body follow for a second
await page.mouse.move(at.x, at.y);
await page.mouse.down();
await page.mouse.move(at.x + 40, at.y + 90, { steps: 4 });
await page.evaluate(() => window.thrum.step(330));
await page.waitForTimeout(3000);
await page.screenshot({ path: picture });
await browser.close();
