// The package as a stranger gets it: packed, installed into a fresh application, run in node and in a
// browser, and read by the tools that judge packages. SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { copyFileSync, cpSync, existsSync, mkdirSync, readFileSync, statSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { dirname, extname, join } from 'node:path';
import { before, test } from 'node:test';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';
import { beamBytes, folder } from './fixture.mjs';

const here = dirname(dirname(fileURLToPath(import.meta.url)));
const app = join(folder, 'app');
const run = (command, words, cwd = here) => execFileSync(command, words, { cwd, encoding: 'utf8', stdio: 'pipe' });
const tool = (name) => join(here, 'node_modules/.bin', name);
let packed;

before(() => {
  packed = JSON.parse(run('npm', ['pack', '--ignore-scripts', '--json', '--pack-destination', folder]))[0];
  mkdirSync(app);
  writeFileSync(join(app, 'package.json'), '{"name": "app", "private": true, "type": "module"}\n');
  run('npm', ['install', '--offline', '--ignore-scripts', '--no-audit', '--no-fund',
    join(folder, packed.filename)], app);
  beamBytes();
  copyFileSync(join(folder, 'beam.npz'), join(app, 'beam.npz'));
});

test('the engine is below 340 kB in gzip, and the licence comes along', () => {
  assert.ok(gzipSync(readFileSync(join(here, 'dist/thrum.wasm'))).length < 340e3);
  assert.ok(packed.files.some(({ path }) => path === 'LICENSE'));
  assert.ok(!packed.files.some(({ path }) => /test|bridge|node_modules/.test(path)));
});

test('the example runs in node', () => {
  copyFileSync(join(here, 'examples/node.mjs'), join(app, 'node.mjs'));
  const text = run('node', ['node.mjs', 'beam.npz'], app);
  const [, first, last] = text.match(/energy (\S+) J, after a minute (\S+) J/);
  assert.equal(first, last);
});

test('the README runs as it stands', () => {
  const block = readFileSync(join(here, 'README.md'), 'utf8').match(/```js\n(.*?)```/s)[1];
  const text = block.replace("await (await fetch('beam.npz')).arrayBuffer()", "readFileSync('beam.npz')");
  assert.notEqual(text, block);
  writeFileSync(join(app, 'readme.mjs'), `import { readFileSync } from 'node:fs';\n${text}\nconsole.log(positions.length > 0);\n`);
  assert.match(run('node', ['readme.mjs'], app), /true\n$/);
});

test('the binary may lie apart', () => {
  writeFileSync(join(app, 'apart.mjs'), `
    import { readFile } from 'node:fs/promises';
    import { createRequire } from 'node:module';
    import { loadFrom } from 'thrum/apart';
    const path = createRequire(import.meta.url).resolve('thrum/thrum.wasm');
    const thrum = await loadFrom(await readFile(path));
    const compiled = await loadFrom(await WebAssembly.compile(await readFile(path)));
    console.log(thrum.version === compiled.version && thrum.integrators.join());\n`);
  assert.match(run('node', ['apart.mjs'], app), /energy/);
});

test('publint and arethetypeswrong have nothing to say', () => {
  run(tool('publint'), ['--strict', here]);
  run(tool('attw'), [join(folder, packed.filename), '--profile', 'esm-only', '--exclude-entrypoints', './thrum.wasm']);
});

test('the types hold under tsc --strict, and refuse what is wrong', () => {
  const options = ['--strict', '--noEmit', '--module', 'nodenext', '--target', 'es2022', '--skipLibCheck', 'false'];
  writeFileSync(join(app, 'right.mts'), `
    import { load, Status, ThrumError, type Model, type State } from 'thrum';
    const thrum = await load();
    const model: Model = thrum.model(new Uint8Array(8));
    const state: State = model.state({ integrator: 'energy', dt: 0.003 });
    if (state.step(3) === Status.OK) state.setForce(model.externalLoad({ force: [0, 0, 1], group: 'tip' }));
    const positions: Float32Array = model.surface({ triangles: model.outerTriangles() }).positions(state.q);
    const body = thrum.scene({ gravity: [0, 0, -9.81] }).addBody(model, { touch: 'all', condense: 4 });
    console.log(positions, body.matrix, new ThrumError instanceof Error);\n`.replace('new ThrumError instanceof Error', 'ThrumError.name'));
  run(tool('tsc'), [...options, 'right.mts'], app);
  for (const wrong of ["model.state({ integrator: 'euler' })", 'model.state().step("3")', 'new Model()', 'model.rank = 3']) {
    writeFileSync(join(app, 'wrong.mts'),
      `import { load, Model } from 'thrum';\nconst model = (await load()).model(new ArrayBuffer(8));\n${wrong};\n`);
    assert.throws(() => run(tool('tsc'), [...options, 'wrong.mts'], app), wrong);
  }
});

const chromium = ['/usr/bin/chromium', '/usr/bin/google-chrome'].find(existsSync);
const three = join(here, '../viewer/node_modules/three');
const playwright = join(here, '../viewer/node_modules/playwright-core/index.mjs');
const cannot = !(chromium && existsSync(three) && existsSync(playwright)) && 'chromium, three or playwright is missing';

test('the three.js example moves in a browser', { skip: cannot }, async () => {
  cpSync(three, join(app, 'node_modules/three'), { recursive: true });
  copyFileSync(join(here, 'examples/three.html'), join(app, 'three.html'));
  const types = { '.html': 'text/html', '.js': 'text/javascript', '.npz': 'application/octet-stream' };
  const server = createServer((request, response) => {
    const path = join(app, decodeURIComponent(request.url));
    const known = existsSync(path) && statSync(path).isFile();
    response.writeHead(known ? 200 : 404, { 'content-type': types[extname(path)] ?? 'text/plain' });
    response.end(known ? readFileSync(path) : '');
  }).listen(0, '127.0.0.1');
  const { chromium: browsers } = await import(playwright);
  const browser = await browsers.launch({ executablePath: chromium, args: ['--no-sandbox', '--use-gl=swiftshader'] });
  try {
    const page = await browser.newPage({ viewport: { width: 480, height: 320 } });
    const complaints = [];
    page.on('pageerror', (error) => complaints.push(error.message));
    await page.goto(`http://127.0.0.1:${server.address().port}/three.html`);
    // a second of simulated time, with its energy in the title
    await page.waitForFunction(() => Number.parseFloat(document.title) > 1, undefined, { timeout: 60000 });
    assert.match(await page.title(), /-?\d+\.\d+ J$/);
    assert.deepEqual(complaints, []);
    if (process.env.THRUM_PICTURE) await page.screenshot({ path: process.env.THRUM_PICTURE });
  } finally {
    await browser.close();
    server.close();
  }
});
