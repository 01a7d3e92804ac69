// The pages of the committed results as a browser lays them out: at 1200 pixels no table is wider than its page and nothing of
// a plot lies over anything else of it, and on a telephone the page is no wider than the screen.
// usage: report_pages.mjs SOURCE PYTHON     (playwright-core of viewer/; CHROMIUM names the browser)
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { cpSync, mkdtempSync, readdirSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { basename, dirname, join } from 'node:path';
import { pathToFileURL } from 'node:url';

const [source, python] = process.argv.slice(2);
const { chromium } = createRequire(join(source, 'viewer/package.json'))('playwright-core');
const TABLES = ['matrix/runs', 'step_sizes/runs', 'sweep/sweep', 'variable/variable', 'work_precision/work_precision',
  'extremes/extremes', 'linear/linear', 'long/long', 'tradeoff/bridge'];
const folder = mkdtempSync(join(tmpdir(), 'thrum-pages-'));

/** What is wrong with the page as it is laid out: tables that do not fit, texts of a plot over each other. */
function faults() {
  const found = [];
  const over = document.documentElement.scrollWidth - innerWidth;
  if (over > 0) found.push(`the page is ${over} pixels wider than the screen`);
  if (innerWidth < 1200) return found;
  const { right } = document.body.getBoundingClientRect();
  document.querySelectorAll('table').forEach((table, n) => {
    const box = table.getBoundingClientRect();
    if (box.right > right + 1) found.push(`table ${n + 1} is ${Math.ceil(box.right - right)} pixels too wide`);
  });
  document.querySelectorAll('svg').forEach((svg) => {
    const texts = [...svg.querySelectorAll('text')].map((text) => [text.textContent.trim(), text.getBoundingClientRect()])
      .filter(([text]) => text);
    texts.forEach(([one, a], n) => texts.slice(n + 1).forEach(([other, b]) => {
      const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (wide > 2 && high > 4) found.push(`"${one}" and "${other}" lie over each other`);
    }));
  });
  return found;
}

try {
  const browser = await chromium.launch({ executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium', args: ['--no-sandbox'] });
  for (const table of TABLES) {
    const [kind] = table.split('/');
    const own = join(folder, kind);
    cpSync(join(source, 'validation/results', dirname(table)), own, { recursive: true });
    execFileSync(python, [join(source, 'validation/report.py'), kind, join(own, `${basename(table)}.csv`)]);
    const [name] = readdirSync(own).filter((file) => file.endsWith('.html'));
    for (const width of [1200, 390]) {
      const page = await browser.newPage({ viewport: { width, height: 800 } });
      await page.goto(pathToFileURL(join(own, name)).href);
      assert.deepEqual(await page.evaluate(faults), [], `${table} at ${width} pixels`);
      await page.close();
    }
  }
  await browser.close();
} finally {
  rmSync(folder, { recursive: true, force: true });
}
