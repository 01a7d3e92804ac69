// Builds the viewer into one file: node build.mjs FOLDER writes FOLDER/viewer.html, with
// FOLDER/thrum.wasm beside it for the tests. Needs clang with lld and wasi-libc, and `npm ci`.
// SPDX-License-Identifier: Apache-2.0
import { mkdirSync, readFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';
import { compile, writeWhole } from '../javascript/compile.mjs';

const here = dirname(fileURLToPath(import.meta.url));

/** A file of src with all it imports, as one script. @param {string} entry @returns {Promise<string>} */
async function bundle(entry) {
  const made = await build({
    entryPoints: [join(here, 'src', entry)], bundle: true, minify: true, format: 'iife',
    target: 'es2022', write: false, legalComments: 'inline', logLevel: 'warning',
  });
  return made.outputFiles[0].text.replaceAll('</script', '<\\/script');
}

const out = resolve(process.argv[2] ?? 'build');
mkdirSync(out, { recursive: true });
const wasm = join(out, 'thrum.wasm');
compile('viewer', wasm);
const parts = {
  STYLE: readFileSync(join(here, 'src/style.css'), 'utf8'),
  WASM: readFileSync(wasm).toString('base64'),
  SOUND: await bundle('sound_worker.js'),
  SCRIPT: await bundle('main.js'),
};
const page = readFileSync(join(here, 'src/index.html'), 'utf8')
  .replace(/@(STYLE|WASM|SOUND|SCRIPT)@/g, (_, name) => parts[name]);
writeWhole(join(out, 'viewer.html'), page);
console.log(`${join(out, 'viewer.html')}: ${(page.length / 1024).toFixed(0)} KiB`);
