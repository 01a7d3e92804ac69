// What the tests share: packs made by `thrum view`, a browser, and pages on the disk or served.
// THRUM_VIEWER names viewer.html, with thrum.wasm beside it; THRUM_PROGRAM the thrum program.
// SPDX-License-Identifier: Apache-2.0
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';
import { Engine } from '../src/engine.js';
import { readPack } from '../src/pack.js';
import { writePack } from './pack_write.mjs';

const SLOT = 'id="thrum-pack">';
const VIEWPORT = { width: 760, height: 440 }; // small: Chromium draws in software

const viewer = process.env.THRUM_VIEWER;
const program = process.env.THRUM_PROGRAM;
if (!viewer || !program) throw new Error('set THRUM_VIEWER and THRUM_PROGRAM');

export const wasmBytes = () => readFileSync(join(dirname(viewer), 'thrum.wasm'));

/** A folder that goes when the tests end. */
export const folder = mkdtempSync(join(tmpdir(), 'thrum-viewer-'));
process.on('exit', () => rmSync(folder, { recursive: true, force: true }));

/** Runs thrum. @param {string[]} args */
export const thrum = (...args) => execFileSync(program, args, { cwd: folder, encoding: 'utf8' });

/** The pack that `thrum view` makes of models, parsed. @param {string[]} models */
export function packOf(...models) {
  thrum('view', ...models, '-o', 'packed.html', '--quiet');
  const html = readFileSync(join(folder, 'packed.html'), 'utf8');
  const [, text] = /id="thrum-pack"[^>]*>([^<]*)</.exec(html);
  return readPack(Buffer.from(text, 'base64'));
}

/** The last row of a .npy of doubles in C order. @param {string} path @param {number} columns */
export function lastRow(path, columns) {
  const bytes = readFileSync(path);
  return Array.from({ length: columns }, (_, i) => bytes.readDoubleLE(bytes.length - 8 * (columns - i)));
}

/** An engine with the models of a pack and a scene of them, some steps later. */
export async function stepped(pack, scene, steps) {
  const engine = await Engine.load(wasmBytes());
  pack.models.forEach((model) => engine.addModel(model));
  engine.build(scene);
  for (let i = 0; i < steps; i++) engine.step();
  return engine;
}

/** A page with the pack inside. @returns {string} its address on the disk */
export function standalone(pack) {
  const html = readFileSync(viewer, 'utf8')
    .replace(`${SLOT}</script>`, () => `${SLOT}${writePack(pack).toString('base64')}</script>`);
  const path = join(folder, `page${performance.now()}.html`);
  writeFileSync(path, html);
  return pathToFileURL(path).href;
}

/** Serves the empty page and the pack beside it on loopback. */
export async function serve(pack) {
  const files = { '/': ['text/html', readFileSync(viewer)],
    '/pack': ['application/octet-stream', writePack(pack)] };
  const server = createServer((request, answer) => {
    const [type, body] = files[request.url] ?? [];
    answer.writeHead(body ? 200 : 404, { 'content-type': type ?? 'text/plain' }).end(body);
  });
  await new Promise((done) => { server.listen(0, '127.0.0.1', done); });
  return { url: `http://127.0.0.1:${server.address().port}/`, close: () => server.close() };
}

export const launch = () => chromium.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader',
    '--enable-unsafe-swiftshader'],
});

/** Opens a page that runs; `page.complaints` gathers what the console says is wrong.
 * @param {import('playwright-core').Browser} browser @param {string} url */
export async function open(browser, url, options = {}) {
  const page = await browser.newPage({ viewport: VIEWPORT, ...options });
  page.complaints = [];

  // a busy machine draws the page in software for as long as this
  page.setDefaultNavigationTimeout(120_000);
  page.on('pageerror', (error) => page.complaints.push(error.message));
  page.on('console', (message) => {
    if (message.type() === 'error') page.complaints.push(message.text());
  });
  await page.goto(url);
  await page.evaluate(() => window.thrum.ready);
  return page;
}
