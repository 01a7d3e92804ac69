// Builds the npm package into dist/: node build.mjs. SPDX-License-Identifier: Apache-2.0
import { copyFileSync, mkdirSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';
import { compile, writeWhole } from './compile.mjs';
import { typesOf } from './types.mjs';

const here = dirname(fileURLToPath(import.meta.url));
const dist = join(here, 'dist');

rmSync(dist, { recursive: true, force: true });
mkdirSync(dist);
for (const name of readdirSync(join(here, 'src'))) copyFileSync(join(here, 'src', name), join(dist, name));

const wasm = join(dist, 'thrum.wasm');
compile('javascript', wasm, ['-DTHRUM_WITHOUT_TEXTS']);
const bytes = readFileSync(wasm);
writeWhole(join(dist, 'wasm.js'),
  `// The binary of the engine, made by build.mjs.\nexport const wasm = '${bytes.toString('base64')}';\n`);

// options by the rows of thrum/fields.h, but for those that have types of their own
const OWN = { BODY: ['touch'], OBSTACLE: ['rotation'], LINK: ['kind', 'vertices'], WIND: ['velocity'],
  LOAD: ['kind', 'vector', 'vertices', 'reduced', 'parts', 'moments', 'resultant'] };
const types = readFileSync(join(here, 'src/index.d.ts'), 'utf8').replace(/@(\w+)@/g, (_, record) => typesOf(record, OWN[record] ?? []));
writeWhole(join(dist, 'index.d.ts'), types);
copyFileSync(join(here, '..', 'LICENSE'), join(here, 'LICENSE'));
console.log(`dist/thrum.wasm: ${bytes.length} bytes, ${gzipSync(bytes).length} in gzip`);
