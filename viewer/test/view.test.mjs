// What `thrum view` hands out, in headless Chromium: the server's page and the one on the disk.
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { once } from 'node:events';
import { join } from 'node:path';
import { createInterface } from 'node:readline';
import { after, before, test } from 'node:test';
import { pathToFileURL } from 'node:url';
import { folder, launch, open, thrum } from './fixture.mjs';

let browser;

before(async () => {
  thrum('precompute', 'beam:8x2x2@1x0.2x0.2', '--fix', 'x<0.001', '--modes', '5', '--rank', '9',
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

test('the served page runs, until Ctrl-C', async () => {
  const server = spawn(process.env.THRUM_PROGRAM, ['view', 'beam.npz', '--json', '--no-open', '-q'],
    { cwd: folder, stdio: ['ignore', 'pipe', 'inherit'] });
  const [line] = await once(createInterface(server.stdout), 'line');
  const { url } = JSON.parse(line);
  await expectRunning(url);
  server.kill('SIGINT');
  assert.deepEqual(await once(server, 'exit'), [0, null]);
});

test('the page written by -o runs from the disk', async () => {
  thrum('view', 'beam.npz', '-o', 'beam.html', '-q');
  await expectRunning(pathToFileURL(join(folder, 'beam.html')).href);
});
