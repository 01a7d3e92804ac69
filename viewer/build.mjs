// Builds the viewer into one file: node build.mjs FOLDER writes FOLDER/viewer.html, with
// FOLDER/thrum.wasm beside it for the tests. Needs clang with lld and wasi-libc, and `npm ci`.
// SPDX-License-Identifier: Apache-2.0
import { spawnSync } from 'node:child_process';
import { mkdirSync, readFileSync, readdirSync, renameSync, writeFileSync } from 'node:fs';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { build } from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
const root = dirname(here);

/** @param {string} folder @returns {string[]} the C files directly in it and in its folders */
const sources = (folder) =>
  readdirSync(folder, { withFileTypes: true }).sort((a, b) => (a.name < b.name ? -1 : 1))
    .flatMap((entry) => entry.isDirectory()
      ? (['node_modules', 'src', 'test'].includes(entry.name) ? [] : sources(join(folder, entry.name)))
      : entry.name.endsWith('.c') ? [join(folder, entry.name)] : []);

/** Writes beside, then renames, so that there is never half a file. */
function writeWhole(path, content) {
  writeFileSync(`${path}.part`, content);
  renameSync(`${path}.part`, path);
}

/** libthrum, the scene and the bridge as WebAssembly. Clang 13 to 15 may move a load into both lanes
 * (v128.load64_splat) behind stores and calls that follow it: nothing in their selection orders it
 * against those. The SLP vectoriser makes such loads of numbers that change, as of touch.force in
 * solve_row of runtime/contact/contact_solve.c, whose `before` then has the force after: it stays off.
 * Loops and the kernel have such loads too, of numbers that nothing in their block writes. Clang 16
 * and 19 are right with it on. @param {string} path */
function compile(path) {
  const part = `${path}.part`;
  const clang = spawnSync(process.env.CLANG ?? 'clang', [
    '--target=wasm32-wasi', '-mexec-model=reactor', '-msimd128', '-O3', '-fno-slp-vectorize',
    '-std=c11', '-ffp-contract=off', '-Wall', '-Wextra', '-Wshadow', '-Wconversion',
    '-Wno-sign-conversion', '-Werror', '-I', join(root, 'include'), '-I', root,
    ...['runtime', 'scene', 'viewer'].flatMap((folder) => sources(join(root, folder))),
    '-Wl,--strip-debug', '-o', part,
  ], { stdio: 'inherit' });
  if (clang.error) throw clang.error;
  if (clang.status !== 0) process.exit(1);
  renameSync(part, path);
}

/** main.js with all it imports, as one script. @returns {Promise<string>} */
async function bundle() {
  const made = await build({
    entryPoints: [join(here, 'src/main.js')], bundle: true, minify: true, format: 'iife',
    target: 'es2022', write: false, legalComments: 'inline', logLevel: 'warning',
  });
  return made.outputFiles[0].text.replaceAll('</script', '<\\/script');
}

const out = resolve(process.argv[2] ?? 'build');
mkdirSync(out, { recursive: true });
const wasm = join(out, 'thrum.wasm');
compile(wasm);
const parts = {
  STYLE: readFileSync(join(here, 'src/style.css'), 'utf8'),
  WASM: readFileSync(wasm).toString('base64'),
  SCRIPT: await bundle(),
};
const page = readFileSync(join(here, 'src/index.html'), 'utf8')
  .replace(/@(STYLE|WASM|SCRIPT)@/g, (_, name) => parts[name]);
writeWhole(join(out, 'viewer.html'), page);
console.log(`${join(out, 'viewer.html')}: ${(page.length / 1024).toFixed(0)} KiB`);
