// SPDX-License-Identifier: Apache-2.0
import type { Thrum } from './index.js';

export * from './index.js';

/** The engine, from the binary that the package holds. */
export function load(): Promise<Thrum>;
