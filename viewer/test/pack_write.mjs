// Writes a pack (docs/viewer.md) of what src/pack.js reads.
// SPDX-License-Identifier: Apache-2.0

const TYPES = new Map([
  [Float64Array, 'f8'], [Float32Array, 'f4'], [Int32Array, 'i4'], [Uint8Array, 'u1'],
]);
const padded = (bytes) => Math.ceil(bytes / 8) * 8;

/** @param {import('../src/pack.js').Pack} pack @returns {Buffer} */
export function writePack(pack) {
  const data = [];
  let size = 0;
  const put = (array) => {
    const entry = [size, array.length, TYPES.get(array.constructor)];
    const bytes = Buffer.alloc(padded(array.byteLength));
    bytes.set(new Uint8Array(array.buffer, array.byteOffset, array.byteLength));
    data.push(bytes);
    size += bytes.length;
    return entry;
  };
  const models = pack.models.map((model) => ({
    ...model,
    arrays: Object.fromEntries(
      Object.entries(model.arrays).map(([name, array]) => [name, put(array)])),
  }));
  const json = Buffer.from(JSON.stringify({ format: 1, scene: pack.scene, models }));
  const text = Buffer.alloc(padded(json.length), ' ');
  json.copy(text);
  const head = Buffer.alloc(16);
  head.write('THRUMPK1');
  head.writeUInt32LE(text.length, 8);
  return Buffer.concat([head, text, ...data]);
}
