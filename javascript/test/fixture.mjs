// What the tests share: the package as it was built, and models that the program makes. THRUM_PROGRAM names
// the program. SPDX-License-Identifier: Apache-2.0
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

export const folder = mkdtempSync(join(tmpdir(), 'thrum-js-'));
process.on('exit', () => rmSync(folder, { recursive: true, force: true }));

/** Runs the program in the folder of the tests. */
export function thrum(...words) {
  return execFileSync(process.env.THRUM_PROGRAM, words, { cwd: folder, encoding: 'utf8', stdio: 'pipe' });
}

/** The bytes of a model that the program makes. */
export function modelBytes(name, ...words) {
  thrum('precompute', ...words, '-o', `${name}.npz`);
  return readFileSync(join(folder, `${name}.npz`));
}

export const beamBytes = () =>
  modelBytes('beam', 'beam:8x2x2@1x0.15x0.15,split=6', '--order', '1', '--fix', 'x<0.001', '--modes', '6', '--rank', '12');
export const blockBytes = () =>
  modelBytes('block', 'beam:2x2x2@0.2x0.2x0.2,split=6', '--order', '1', '--modes', '3', '--rank', '6');
