// The sound of a struck body: the velocity of the struck place after an impulse there, by the model
// itself where this machine steps it once a sample (sound.js), else as the linear modes give it,
// sum_i (U_vi . n)^2 exp(-alpha t / 2) cos(2 pi f_i t). Bodies whose lowest mode is too low to be heard
// are played faster, all modes alike.
// SPDX-License-Identifier: Apache-2.0

export const SECONDS = 2; // of sound
const LOWEST_HEARD = 50; // [Hz]
const LOWEST_PLAYED = 110; // of what is played faster [Hz]
export const FADE = 1.5; // e-foldings of what has no damping, over the sound
export const LOUDNESS = 0.5;
const AHEAD = 0.05; // by which sound begins after its first samples are there [s]

/** How many times as fast modes are played so that the lowest is heard. @param {number[]} frequencies [Hz] */
export const haste = ([lowest]) => (lowest >= LOWEST_HEARD ? 1 : LOWEST_PLAYED / lowest);

/** @param {number[]} frequencies ascending [Hz] @param {number[]} weights (U_vi . n)^2 of each
 * @param {number} damping alpha [1/s] @param {number} rate of samples [Hz] @returns {Float32Array} */
export function strikeSamples(frequencies, weights, damping, rate) {
  const faster = haste(frequencies);
  const samples = new Float32Array(SECONDS * rate);
  const decay = Math.max((faster * damping) / 2, FADE / SECONDS) / rate;
  frequencies.forEach((frequency, i) => {
    const angle = (2 * Math.PI * frequency * faster) / rate;
    if (!(angle > 0 && angle < Math.PI)) return; // higher than the samples can be

    // each sample from the one before, turned and shortened
    const [c, s] = [Math.cos(angle) * Math.exp(-decay), Math.sin(angle) * Math.exp(-decay)];
    let [x, y] = [weights[i], 0];
    for (let n = 0; n < samples.length; n++) {
      samples[n] += x;
      [x, y] = [c * x - s * y, s * x + c * y];
    }
  });
  const most = samples.reduce((top, sample) => Math.max(top, Math.abs(sample)), 0);
  return most > 0 ? samples.map((sample) => (LOUDNESS * sample) / most) : samples;
}

/** (U_vi . n)^2 of each mode. @param {import('./pack.js').Model} model @param {number} vertex
 * @param {number[]} direction n, in the axes of the body */
export function strikeWeights({ rank, arrays: { basis } }, vertex, direction) {
  return Array.from({ length: rank }, (_, i) =>
    direction.reduce((sum, n, axis) => sum + n * basis[(3 * vertex + axis) * rank + i], 0) ** 2);
}

/** What is heard, in words. @param {{rank: number, faster: number, step: number, rate: number, of: number}} heard rank 0:
 * the linear modes, as a step [s] takes longer than a sample */
export function heardText({ rank, faster, step, rate, of }) {
  const micro = (time) => `${(1e6 * time).toPrecision(2)} µs`;
  const slow = step > 0 && step < Infinity ? `: a step takes ${micro(step)} of the ${micro(1 / rate)} of a sample` : '';
  const how = rank > 0 ? `nonlinear, ${rank} of ${of} coordinates` : `linear modes${slow}`;
  return faster > 1 ? `${how}, ${faster.toPrecision(2)} times as fast` : how;
}

export class Striker {
  /** @param {string} script of the thread that steps what is struck; '' for none
   * @param {(heard: object) => void} tell takes what is heard */
  constructor(script, tell) {
    Object.assign(this, { script, tell, id: 0 });
  }

  /** Plays a struck body. It begins with the first strike, since a browser is silent before a person does
   * something. @param {WebAssembly.Module} module @param {object} strike as in sound.js, but for the rate
   * @param {number[]} weights */
  play(module, strike, weights) {
    this.context ??= new AudioContext();
    const { sampleRate: rate } = this.context;
    const faster = haste(strike.frequencies);
    const linear = (step) => {
      this.#sound(strikeSamples(strike.frequencies, weights, strike.damping, rate), this.context.currentTime);
      this.tell({ rank: 0, faster, step, rate });
    };
    const id = ++this.id;

    // bodies of which a part follows the rest are left to their modes
    const thread = strike.model.masters > 0 ? undefined : this.#thread();
    if (!thread) return linear(0);
    let at = 0;
    thread.onerror = () => { this.broken = true; if (id === this.id) linear(0); };
    thread.onmessage = ({ data }) => {
      if (data.id !== this.id) return;
      if (data.samples) {
        if (at === 0) at = this.context.currentTime + AHEAD;
        this.#sound(data.samples, at);
        at += data.samples.length / rate;
      } else if (data.rank > 0) {
        this.tell({ rank: data.rank, of: strike.model.rank, faster, step: data.step, rate });
      } else if (at === 0) linear(data.step ?? 0);
    };
    thread.postMessage({ id, module, strike: { ...strike, rate } });
  }

  // made at the first strike; undefined where a page may not have one
  #thread() {
    if (!this.script || this.broken || typeof Worker === 'undefined') return undefined;
    try {
      this.worker ??= new Worker(URL.createObjectURL(new Blob([this.script], { type: 'text/javascript' })));
    } catch {
      this.broken = true;
    }
    return this.worker;
  }

  #sound(samples, at) {
    const { context } = this;
    const buffer = context.createBuffer(1, samples.length, context.sampleRate);
    buffer.copyToChannel(samples, 0);
    const source = context.createBufferSource();
    source.buffer = buffer;
    source.connect(context.destination);
    source.start(at);
  }
}
