// libthrum, its scenes, gradients of runs and the C files of a folder as one WebAssembly module. Needs clang with lld and
// wasi-libc. SPDX-License-Identifier: Apache-2.0
import { spawnSync } from 'node:child_process';
import { mkdirSync, mkdtempSync, readdirSync, renameSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { basename, dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';

const root = dirname(dirname(fileURLToPath(import.meta.url)));

/** Where the step of a model spends its time: the passes of this architecture over coefficients and points, and solves.
 * The laws of materials at cubature points, and what is done once for a model, are small instead. */
const FAST = ['runtime/kernels/kernel_wasm.c', 'runtime/batch/batch_kernel.c', 'core/polynomial/polynomial.c',
  'core/linear_algebra/dense.c'];

/** The same, at -O2: -O3 doubles its size and makes it no faster. */
const FAST_AND_SMALL = ['runtime/points/kernel_points.c'];

/** Folders that hold no C of the package, and the tables of the core alone. */
const OTHER = ['alone.c', 'node_modules', 'src', 'test', 'dist', 'examples'];

/** @param {string} folder @returns {string[]} the C files directly in it and in its folders */
const sources = (folder) =>
  readdirSync(folder, { withFileTypes: true }).sort((a, b) => (a.name < b.name ? -1 : 1))
    .filter((entry) => !OTHER.includes(entry.name))
    .flatMap((entry) => entry.isDirectory() ? sources(join(folder, entry.name))
      : entry.name.endsWith('.c') ? [join(folder, entry.name)] : []);

/** Writes beside, then renames, so that there is never half a file. */
export function writeWhole(path, content) {
  writeFileSync(`${path}.part`, content);
  renameSync(`${path}.part`, path);
}

/** Compiles the runtime, the scenes, the bridge of the package and `folder` into the module at `path`. Clang 13 to 15 may move a
 * load into both lanes (v128.load64_splat) behind stores and calls that follow it: nothing in their
 * selection orders it against those. The SLP vectoriser makes such loads of numbers that change, as of
 * touch.force in solve_row of contact/contact_solve.c, whose `before` then has the force
 * after: it stays off. Loops and the kernel have such loads too, of numbers that nothing in their
 * block writes. Clang 16 and 19 are right with it on. @param {string} folder @param {string} path @param {string[]} defines */
export function compile(folder, path, defines = []) {
  const part = resolve(`${path}.part`);
  const work = mkdtempSync(join(tmpdir(), 'thrum-wasm-'));
  try {
    // what a step spends its time in is fast, all else small: the package is to stay below 340 kB in gzip
    const all = [...new Set(['core', 'runtime', 'contact', 'scene', 'gradient', 'javascript', folder])].flatMap((name) => sources(join(root, name)));
    const among = (names) => all.filter((name) => names.some((of) => name.startsWith(join(root, of))));
    const [fast, faster] = [among(FAST_AND_SMALL), among(FAST)];
    const objects = [['-O3', faster], ['-O2', fast], ['-Oz', all.filter((name) => ![...fast, ...faster].includes(name))]]
      .flatMap(([level, names]) => compileAll([level, ...defines], names, join(work, level)));
    run(['-mexec-model=reactor', ...objects, '-Wl,--strip-all', '-o', part], work);
  } finally {
    rmSync(work, { recursive: true, force: true });
  }
  renameSync(part, path);
}

/** Compiles C files to objects in a folder of their own, one call each, which is what a cache of the compiler can
 * answer: the viewer and the package have all of the runtime in common. @returns {string[]} the objects */
function compileAll(options, names, folder) {
  mkdirSync(folder);
  return names.map((name) => {
    const object = join(folder, basename(name).replace(/\.c$/, '.o'));
    run([...options, '-c', '-msimd128', '-fno-slp-vectorize', '-std=c11', '-ffp-contract=off', '-Wall', '-Wextra', '-Wshadow',
      '-Wconversion', '-Wno-sign-conversion', '-Werror', '-I', join(root, 'include'), '-I', root, '-o', object, name], folder);
    return object;
  });
}

/** Calls clang, by way of the launcher that CMake takes for its compilers too, such as ccache. */
function run(words, folder) {
  const [program, ...first] = [process.env.CMAKE_C_COMPILER_LAUNCHER, process.env.CLANG ?? 'clang'].filter(Boolean);
  const clang = spawnSync(program, [...first, '--target=wasm32-wasi', ...words], { cwd: folder, stdio: 'inherit' });
  if (clang.error) throw clang.error;
  if (clang.status !== 0) throw new Error(`clang ended with ${clang.status ?? clang.signal}`);
}
