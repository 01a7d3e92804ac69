// The module's memory: what goes in, what comes out, and who owns what lies in it.
// SPDX-License-Identifier: Apache-2.0

/** What vsnprintf drags in; nothing is ever written. */
const wasi = { fd_close: () => 8, fd_seek: () => 8, fd_write: () => 8 };

const NUMBERS = 512;

/** A call failed: `status` is that of the C library (thrum/status.h), the message is for people. */
export class ThrumError extends Error {
  constructor(message, status) {
    super(message);
    this.name = 'ThrumError';
    this.status = status;
  }
}

/** Something in the module's memory, freed once its object and all that is built on it are gone. */
export class Owned {
  #uses = 1;
  #release;
  #parents;

  constructor(address, release, parents = []) {
    this.address = address;
    this.#release = release;
    this.#parents = parents;
    for (const parent of parents) parent.keep();
  }

  keep() {
    this.#uses += 1;
  }

  /** Needs another object from now on. */
  lean(parent) {
    parent.keep();
    this.#parents = [...this.#parents, parent];
  }

  drop() {
    this.#uses -= 1;
    if (this.#uses > 0) return;
    this.#release(this.address);
    for (const parent of this.#parents) parent.drop();
  }
}

const collected = new FinalizationRegistry((owned) => owned.drop());

/** An object of the package: free() ends it at once, otherwise it goes with the garbage. */
export class Resource {
  #owned;
  #name;

  constructor(name, owned) {
    this.#name = name;
    this.#owned = owned;
    collected.register(this, owned, this);
  }

  /** What it owns; throws after free(). */
  get owned() {
    if (this.#owned === undefined) throw new ThrumError(`the ${this.#name} was freed`, -1);
    return this.#owned;
  }

  get address() {
    return this.owned.address;
  }

  free() {
    if (this.#owned === undefined) return;
    collected.unregister(this);
    this.#owned.drop();
    this.#owned = undefined;
  }
}

/** The instance of the module, and copies in and out of its memory. */
export class Memory {
  constructor(exports) {
    this.calls = exports;
    this.calls._initialize();
    this.numbersAt = this.calls.js_numbers();
  }

  /** @param {BufferSource|WebAssembly.Module} wasm @returns {Promise<Memory>} */
  static async of(wasm) {
    const imports = { wasi_snapshot_preview1: wasi };
    const made = await WebAssembly.instantiate(wasm, imports);
    return new Memory((made.instance ?? made).exports);
  }

  /** A view that holds until memory grows, which any call that makes something may do. */
  view(Kind, at, count) {
    return new Kind(this.calls.memory.buffer, at, count);
  }

  get numbers() {
    return this.view(Float64Array, this.numbersAt, NUMBERS);
  }

  text(at) {
    const bytes = this.view(Uint8Array, at);
    return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
  }

  /** Throws what the library says is wrong. */
  check(status, message = this.calls.js_message) {
    if (status < 0) throw new ThrumError(this.text(message()), status);
    return status;
  }

  /** An address that is not 0; throws what the library says. */
  made(address, message = this.calls.js_message) {
    if (address === 0) throw new ThrumError(this.text(message()), -1);
    return address;
  }

  alloc(bytes) {
    const at = this.calls.js_alloc(bytes);
    if (at === 0) throw new ThrumError('there is no memory left', -5);
    return at;
  }

  /** Calls with the addresses of copies of arrays (0 for undefined), which are freed afterwards. */
  lend(arrays, call) {
    const at = [];
    try {
      for (const array of arrays) {
        at.push(array === undefined ? 0 : this.alloc(array.byteLength));
        if (array !== undefined) this.view(array.constructor, at.at(-1), array.length).set(array);
      }
      return call(...at);
    } finally {
      for (const address of at) if (address !== 0) this.calls.js_free(address);
    }
  }

  /** What a call writes into room for `count` numbers of a kind, as a new array or into `out`. */
  take(Kind, count, call, out) {
    const at = this.alloc(count * Kind.BYTES_PER_ELEMENT);
    try {
      call(at);
      const result = out ?? new Kind(count);
      result.set(this.view(Kind, at, count));
      return result;
    } finally {
      this.calls.js_free(at);
    }
  }
}

/** The most steps of one call, which nothing can interrupt: some ten seconds of a small model. */
const STEPS_MAX = 1e7;

/** `count`, where it is a number of steps. @returns {number} */
export function steps(count) {
  if (!Number.isSafeInteger(count) || count < 0)
    throw new ThrumError(`${String(count)} is no number of steps`, -1);
  if (count > STEPS_MAX)
    throw new ThrumError(`${count} steps are more than the ${STEPS_MAX} of one call: call step again for the rest`, -1);
  return count;
}

/** What is like an array, one entry after the other. */
function* entriesOf(value) {
  for (let n = 0; n < (value?.length ?? 0); n += 1) yield value[n];
}

/** The first `most` entries of an array, of what is like one or can be iterated, whatever length it claims.
 * @returns {Array} */
function firstOf(value, most) {
  const found = [];
  for (const entry of typeof value?.[Symbol.iterator] === 'function' ? value : entriesOf(value)) {
    if (found.length === most) break;
    found.push(entry);
  }
  return found;
}

/** `value` as doubles of that length. `unknown`: NaN in place of each number says that there is none.
 * @returns {Float64Array} */
export function doubles(value, length, name, unknown = false) {
  // what claims to be too long is not copied before it is refused
  const claimed = typeof value?.length === 'number' ? value.length : undefined;
  const found = claimed === undefined || claimed === length ? firstOf(value, length + 1) : [];
  if ((claimed ?? found.length) !== length) {
    const has = claimed ?? (found.length > length ? `more than ${length}` : found.length);
    throw new ThrumError(`${name}: it has ${has} numbers, not ${length}`, -11);
  }
  const array = Float64Array.from(found);
  const wrong = array.findIndex((number) => !Number.isFinite(number));
  if (wrong >= 0 && !(unknown && array.every(Number.isNaN)))
    throw new ThrumError(`${name}: number ${wrong} is ${array[wrong]}, which is no finite number`, -12);
  return array;
}

/** The bytes of a snapshot. @returns {Uint8Array} */
export function snapshotBytes(snapshot) {
  if (!(snapshot instanceof Uint8Array)) throw new ThrumError('a snapshot is a Uint8Array', -1);
  return snapshot;
}

/** `value` as 0-based vertices below `count`. @returns {Int32Array} */
export function vertices(value, count, name) {
  const array = [];
  // the first wrong one ends it, whatever length is claimed
  const entries = typeof value?.[Symbol.iterator] === 'function' ? value : entriesOf(value);
  for (const vertex of entries) {
    if (!Number.isInteger(vertex) || vertex < 0 || vertex >= count)
      throw new ThrumError(`${name}: ${String(vertex)} is no vertex of 0 to ${count - 1}`, -1);
    array.push(vertex);
  }
  if (array.length === 0) throw new ThrumError(`${name}: nothing is no vertex of 0 to ${count - 1}`, -1);
  return Int32Array.from(array);
}
