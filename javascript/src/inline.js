// The engine with its binary inside, which the build puts here. SPDX-License-Identifier: Apache-2.0
import { loadFrom } from './index.js';
import { wasm } from './wasm.js';

export * from './index.js';

/** The engine, from the binary that this file holds. */
export async function load() {
  const text = atob(wasm);
  return loadFrom(Uint8Array.from(text, (letter) => letter.charCodeAt(0)));
}
