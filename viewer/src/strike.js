// The sound of a struck body: the velocity of the struck place after an impulse there, as the linear
// modes give it, sum_i (U_vi . n)^2 exp(-alpha t / 2) cos(2 pi f_i t). Bodies whose lowest mode is
// too low to be heard are played faster, all modes alike.
// SPDX-License-Identifier: Apache-2.0

const SECONDS = 2; // of sound
const LOWEST_HEARD = 50; // [Hz]
const LOWEST_PLAYED = 110; // of what is played faster [Hz]
const FADE = 1.5; // e-foldings of what has no damping, over the sound
const LOUDNESS = 0.5;

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

export class Striker {
  /** Plays a struck body. It begins with the first strike, since a browser is silent before a person does
   * something. @returns {number} how many times as fast it is played */
  play(frequencies, weights, damping) {
    this.context ??= new AudioContext();
    const { sampleRate } = this.context;
    const samples = strikeSamples(frequencies, weights, damping, sampleRate);
    const buffer = this.context.createBuffer(1, samples.length, sampleRate);
    buffer.copyToChannel(samples, 0);
    const source = this.context.createBufferSource();
    source.buffer = buffer;
    source.connect(this.context.destination);
    source.start();
    return haste(frequencies);
  }
}
