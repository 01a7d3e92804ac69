// Takes the pictures of the viewer that docs/ shows, in headless Chromium.
// usage: node docs/pictures/viewer.mjs hook hook.html docs/pictures/tutorial_viewer.png
//        node docs/pictures/viewer.mjs pull horse.html docs/viewer_pull.png
//        node docs/pictures/viewer.mjs compare heart.html docs/viewer_compare.png
//        node docs/pictures/viewer.mjs links links.html docs/viewer_links.png
//        node docs/pictures/viewer.mjs coupling spin.html docs/viewer_coupling.png
//        node docs/pictures/viewer.mjs curve forced.html docs/pictures/response_viewer.png
// The pages are what `thrum view` wrote of hook.npz (docs/tutorial.md, meshed by TetGen), of horse, of
// heart, of examples/scenes/links.json and spin.json, and of the curve of docs/how-to/find_the_response.md; viewer/node_modules must be installed.
// SPDX-License-Identifier: Apache-2.0
import { resolve } from 'node:path';
import { pathToFileURL } from 'node:url';
import { chromium } from '../../viewer/node_modules/playwright-core/index.mjs';

/** Each picture: settings of the page, and what is done with it before it is taken. */
const PICTURES = {
  // the tip is pulled down and to the side at once, and the body follows for a second
  hook: {
    settings: { damping: 2, pull: 2, colour: 'displacement', quality: 'full' },
    async act(page) {
      await press(page, [0.0604, 0, 0.0777]);
      await drag(page, 40, 90, 4);
      await page.evaluate(() => window.thrum.step(330));
    },
  },

  // the nose is pulled down in steps, with a while between them
  pull: {
    settings: { gravity: 9.81, damping: 0.5, colour: 'displacement', quality: 'full' },
    async act(page) {
      await page.evaluate(() => window.thrum.step(600));
      await press(page, [1.37, -0.08, 1.5]);
      for (let n = 0; n < 10; n++) {
        await drag(page, -2, 5, 1);
        await page.evaluate(() => window.thrum.step(100));
      }
    },
  },

  // the bars swing, the handle holds the beam that it has bent
  links: {
    settings: { quality: 'full' },
    async act(page) {
      await page.evaluate(() => window.thrum.step(560));
    },
  },

  // the bar at the left is stretched by its spin, that at the right is not
  coupling: {
    settings: { quality: 'full' },
    async act(page) {
      await page.click('#compare');
      await page.evaluate(() => window.thrum.pause(true));
      await page.evaluate(() => window.thrum.step(205));
    },
  },

  // the largest motion, where the panel is the furthest out
  curve: {
    settings: { quality: 'full' },
    async act(page) {
      await page.evaluate(() => window.thrum.seek(0));
    },
  },

  // three soft hearts sag under their weight and swing
  compare: {
    settings: { gravity: 9.81, damping: 0, stiffness: 0.4, quality: 'full' },
    async act(page) {
      await page.click('#compare');
      await page.evaluate(() => window.thrum.pause(true));
      await page.evaluate(() => window.thrum.step(2600));
    },
  },
};

let pointer = { x: 0, y: 0 };

/** Presses the button over the visible vertex that is nearest to a point of the body at rest. */
async function press(page, point) {
  pointer = await page.evaluate((target) => {
    const { thrum } = window;
    let best;
    for (let v = 0; v < thrum.vertexCount(0); v++) {
      const off = Math.hypot(...thrum.position(0, v).map((x, axis) => x - target[axis]));
      const { x, y } = thrum.project(0, v);
      // not at an outline, which the pointer may miss
      const inside = [[-4, 0], [4, 0], [0, -4], [0, 4]].every(([right, down]) => thrum.pick(x + right, y + down));
      if (inside && thrum.pick(x, y)?.vertex === v && (!best || off < best.off)) best = { off, x, y };
    }
    return best;
  }, point);
  await page.mouse.move(pointer.x, pointer.y);
  await page.mouse.down();
}

/** Moves the pointer, in pixels. */
async function drag(page, right, down, steps) {
  pointer = { x: pointer.x + right, y: pointer.y + down };
  await page.mouse.move(pointer.x, pointer.y, { steps });
}

const [, , name, html, file] = process.argv;
const picture = PICTURES[name];
if (!picture || !file) throw new Error(`name one of ${Object.keys(PICTURES)}, a page and a picture`);

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader',
    '--disable-quic', '--no-first-run', '--disable-background-networking',
    '--disable-component-update', '--disable-sync'],
});
const page = await browser.newPage({ viewport: { width: 1080, height: 760 } });
await page.goto(pathToFileURL(resolve(html)).href);
await page.evaluate(() => window.thrum.ready);
await page.evaluate((settings) => {
  const { thrum } = window;
  thrum.pause(true);
  for (const [key, value] of Object.entries(settings)) thrum.set(key, value);
  thrum.reset();
}, picture.settings);

// a frame takes up to two seconds where there is no GPU
await picture.act(page);
await page.waitForTimeout(3000);
// what stepped goes into the caption; of a curve nothing did
console.log(JSON.stringify(await page.evaluate(() => window.thrum.point() ?? window.thrum.report(0))));
await page.screenshot({ path: file });
await browser.close();
