// Looks at the built site in headless Chromium, on a desktop and a telephone: no page is wider than its screen, no
// script fails, the viewer steps, the search finds. Writes pictures of some pages.
// usage: node look.mjs HTML PICTURES      (playwright-core of viewer/, so build the viewer first)
// SPDX-License-Identifier: Apache-2.0
import { mkdirSync, readFileSync, readdirSync, statSync } from 'node:fs';
import { createServer } from 'node:http';
import { createRequire } from 'node:module';
import { extname, join, relative, resolve } from 'node:path';

const { chromium } = createRequire(new URL('../../viewer/package.json', import.meta.url))('playwright-core');
const [html, pictures] = process.argv.slice(2).map((path) => resolve(path));
if (!html || !pictures) throw new Error('usage: node look.mjs HTML PICTURES');
mkdirSync(pictures, { recursive: true });

const SCREENS = { desktop: { width: 1440, height: 900 }, telephone: { width: 390, height: 844 } };
const DRAWN = ['index', 'docs/tutorial', 'site/viewer', 'site/c', 'site/python', 'site/javascript', 'site/swinging_hook',
  'docs/reference/commands', 'docs/beside_mujoco', 'packaging/README'];
const TYPES = { '.html': 'text/html', '.css': 'text/css', '.js': 'text/javascript', '.svg': 'image/svg+xml', '.png': 'image/png' };

// the site on loopback
const server = createServer((request, answer) => {
  const path = join(html, decodeURIComponent(new URL(request.url, 'http://x').pathname));
  try {
    const bytes = readFileSync(path);
    answer.writeHead(200, { 'content-type': TYPES[extname(path)] ?? 'application/octet-stream' }).end(bytes);
  } catch {
    answer.writeHead(404).end();
  }
});
await new Promise((done) => { server.listen(0, '127.0.0.1', done); });
const root = `http://127.0.0.1:${server.address().port}/`;

/** Every page but those of the viewer, which fill what they are given, and files to take away. */
const pages = (folder) => readdirSync(folder).flatMap((name) => {
  const path = join(folder, name);
  if (statSync(path).isDirectory()) return ['viewer', '_downloads'].some((other) => path === join(html, other)) ? [] : pages(path);
  return name.endsWith('.html') ? [relative(html, path)] : [];
});

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
});
const wrong = [];
let looked = 0;
for (const [screen, viewport] of Object.entries(SCREENS)) {
  const context = await browser.newContext({ viewport, isMobile: screen === 'telephone', hasTouch: screen === 'telephone' });
  const page = await context.newPage();
  page.on('pageerror', (error) => wrong.push(`${screen}: ${page.url().slice(root.length)}: ${error.message}`));
  page.on('response', (answer) => answer.status() >= 400 && !answer.url().endsWith('favicon.ico')
    && wrong.push(`${screen}: ${answer.url()}: ${answer.status()}`));
  for (const name of pages(html)) {
    await page.goto(root + name, { waitUntil: 'load' });
    const over = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
    if (over > 1) wrong.push(`${screen}: ${name} is ${over} pixels wider than the screen`);
    looked += 1;
    if (DRAWN.includes(name.replace(/\.html$/, ''))) {
      await page.waitForTimeout(1500);
      await page.screenshot({ path: join(pictures, `${screen}-${name.replace(/\//g, '_').replace('.html', '.png')}`) });
    }
  }

  // the engine in the frame steps: its clock goes on
  await page.goto(`${root}site/viewer.html`);
  const element = await page.waitForSelector('iframe.viewer');
  await element.scrollIntoViewIfNeeded();
  const frame = await element.contentFrame();
  await frame.waitForFunction(() => /[1-9]\d* ?s|0\.\d*[1-9]\d* s/.test(document.getElementById('energy')?.textContent ?? ''),
    null, { timeout: 30000 }).catch(() => wrong.push(`${screen}: the viewer does not step`));

  await page.goto(`${root}search.html?q=fallback`);
  await page.waitForSelector('#search-results li', { timeout: 15000 })
    .catch(() => wrong.push(`${screen}: the search for "fallback" finds nothing`));
  await page.screenshot({ path: join(pictures, `${screen}-search.png`) });
  await context.close();
}
await browser.close();
server.close();
for (const line of wrong) console.error(line);
console.log(`${looked} pages looked at, ${wrong.length} faults`);
process.exit(wrong.length ? 1 : 0);
