// Measures a frame of 50,000 shown vertices at rank 30: node test/measure.mjs, with THRUM_VIEWER
// and THRUM_PROGRAM set. Drawing is by Chromium's software renderer, where there is no GPU.
// SPDX-License-Identifier: Apache-2.0
import { launch, open, packOf, standalone, thrum } from './fixture.mjs';
import { subdivide } from './subdivide.mjs';

const VERTICES = 50000;
const SECONDS = 15; // of frames
const REPEATS = 3000;

thrum('precompute', 'beam:21x8x8@1x0.35x0.35,split=6', '--order', '1', '--fix', 'x<0.001', '--young', '1e5',
  '--modes', '20', '--rank', '30', '-o', 'fine.npz', '--quiet');
const pack = packOf('fine.npz');
while (pack.models[0].vertex_count < VERTICES) pack.models[0] = subdivide(pack.models[0]);
pack.scene.gravity = [0, 0, -9.81];
const browser = await launch();
const page = await open(browser, standalone(pack));
await page.waitForTimeout(1000 * SECONDS);
const measured = await page.evaluate((repeats) => {
  const { thrum } = window;
  const mean = (action, count) => {
    const begin = performance.now();
    action(count);
    return (performance.now() - begin) / count;
  };
  const gl = document.createElement('canvas').getContext('webgl2');
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const drawn = thrum.times();
  thrum.pause(true);
  thrum.step(repeats); // until the code is compiled well
  return {
    rank: thrum.report(0).rank,
    renderer: gl.getParameter(info.UNMASKED_RENDERER_WEBGL),
    step_ms: mean(thrum.step, repeats),
    upload_ms: mean(thrum.upload, repeats),
    pick_ms: mean((count) => { for (let i = 0; i < count; i++) thrum.pick(380, 200); }, 50),
    draw_ms: drawn.draw.mean,
    frame_ms: drawn.frame.mean,
  };
}, REPEATS);
const { vertex_count: vertices, triangle_count: triangles } = pack.models[0];
console.log(JSON.stringify({ vertices, triangles, ...measured }));
await browser.close();
