// How finely the picture is drawn: chosen by a person, or by how long drawing takes.
// SPDX-License-Identifier: Apache-2.0

/** `ratio`: pixels drawn for one of the page's; `full` is as fine as the screen, at most 2. */
export const LEVELS = {
  full: { ratio: 2, shadows: true },
  plain: { ratio: 1, shadows: false },
  half: { ratio: 0.5, shadows: false },
  coarse: { ratio: 0.33, shadows: false },
};
export const QUALITIES = ['auto', ...Object.keys(LEVELS)];

const NAMES = Object.keys(LEVELS);
const SLOW = 45; // of a drawing, so that with what else a frame does there are 15 in a second [ms]
const QUICK = 8; // with this there is time for the next finer level [ms]
const SAMPLES = 3; // before it is judged
const PATIENCE = 40; // samples before a level that was too slow is tried again

/** The finer one of two levels. @param {string} one @param {string} other @returns {string} */
export const atLeast = (one, other) => NAMES[Math.min(NAMES.indexOf(one), NAMES.indexOf(other))];

/** Looks for the finest level that is quick enough. */
export class QualityChooser {
  constructor() {
    this.place = 0;
    this.times = [];
    this.waits = NAMES.map(() => 0);
  }

  get level() {
    return NAMES[this.place];
  }

  /** Takes the time of a whole drawing. @param {number} time [ms] @returns {string} the level for the next */
  add(time) {
    this.waits = this.waits.map((wait) => Math.max(0, wait - 1));
    this.times.push(time);
    if (this.times.length < SAMPLES) return this.level;

    // the middle one: the first drawing of a level compiles its shaders
    const [, middle] = this.times.splice(0).sort((a, b) => a - b);
    if (middle > SLOW && this.place + 1 < NAMES.length) {
      this.waits[this.place] = PATIENCE;
      this.place++;
    } else if (middle < QUICK && this.place > 0 && this.waits[this.place - 1] === 0) {
      this.place--;
    }
    return this.level;
  }
}

/** Is WebGL drawn by the processor? Smooth edges then take most of the time. */
export function drawsInSoftware() {
  const gl = document.createElement('canvas').getContext('webgl2');
  const info = gl?.getExtension('WEBGL_debug_renderer_info');
  const renderer = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : '';
  gl?.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(renderer);
}
