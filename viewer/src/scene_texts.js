// The short texts of scene files that say how a body starts and how the ground moves. SPDX-License-Identifier: Apache-2.0

/** Numbers between commas; null where one is none. @returns {number[]|null} */
function numbersOf(text, length) {
  const numbers = text.split(',').map((part) => (part.trim() === '' ? NaN : Number(part)));
  return numbers.length === length && numbers.every(Number.isFinite) ? numbers : null;
}

/** A motion of the ground, sine:AX,AY,AZ,f=HZ[,from=S][,until=S]; null: another, which the page does not read.
 * @param {string} text @returns {{shape: string, amplitude: number[], from: number, until?: number, frequency: number}|null} */
export function baseMotionOf(text) {
  const found = /^sine:([^=]*?)((?:,(?:f|from|until)=[^,]*)+)$/.exec(text);
  const amplitude = found && numbersOf(found[1], 3);
  if (!amplitude) return null;
  const given = Object.fromEntries(found[2].slice(1).split(',').map((pair) => pair.split('=')).map(([key, value]) => [key, Number(value)]));
  const { f: frequency, from = 0, until = Infinity } = given;
  if (!(frequency > 0 && from >= 0 && until > from)) return null;
  return { shape: 'sine', amplitude, from, ...(until < Infinity && { until }), frequency };
}

/** A start in a shape of the model, mode:NUMBER,METRES; null: another, which the page does not read.
 * @param {string} text @returns {{mode: number, amplitude: number}|null} the mode from 0 on, and how far its farthest vertex is */
export function startOf(text) {
  const numbers = text.startsWith('mode:') ? numbersOf(text.slice(5), 2) : null;
  if (!numbers || !Number.isInteger(numbers[0]) || numbers[0] < 1) return null;
  return { mode: numbers[0] - 1, amplitude: numbers[1] };
}
