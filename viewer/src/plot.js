// Two small drawings: energies over the last seconds, and the frequencies of the modes.
// SPDX-License-Identifier: Apache-2.0
import { quantityText } from './numbers.js';
import { cssColour } from './theme.js';

const SPAN = 8; // seconds of simulated time in the plot of what is stepped
const EDGE = 16; // room for the least and the largest value [px]
const SAMPLES_MAX = 4000;

/** Sizes a canvas to its place on the page, in device pixels.
 * @param {HTMLCanvasElement} canvas */
export function prepare(canvas) {
  const scale = Math.min(devicePixelRatio, 2);
  const { clientWidth: width, clientHeight: height } = canvas;
  if (canvas.width !== width * scale || canvas.height !== height * scale) {
    canvas.width = width * scale;
    canvas.height = height * scale;
  }
  const pen = canvas.getContext('2d');
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.clearRect(0, 0, width, height);
  return { pen, width, height };
}

export class EnergyPlot {
  /** @param {HTMLCanvasElement} canvas @param {HTMLElement} legend */
  constructor(canvas, legend) {
    Object.assign(this, { canvas, legend, series: [], samples: [], whole: false });
  }

  /** @param {{name: string, colour: string, dash: number[]}[]} series dash: lengths of strokes and gaps [px] */
  begin(series) {
    this.series = series;
    this.samples = [];
    this.whole = false;
    this.legend.replaceChildren(...series.map(({ name, colour, dash }) => {
      const entry = document.createElement('span');
      const key = document.createElement('i');
      key.style.background = dashed(colour, dash);
      entry.append(key, `${name} `, document.createElement('b'));
      return entry;
    }));
  }

  /** @param {number} time [s] @param {number[]} values one of each series [J] */
  add(time, values) {
    if (this.samples.length > 0 && time <= this.samples.at(-1).time) return;
    this.samples.push({ time, values });
    while (this.samples[0].time < time - SPAN || this.samples.length > SAMPLES_MAX)
      this.samples.shift();
  }

  /** Shows a recorded run whole. @param {{time: number, values: number[]}[]} samples */
  showWhole(samples) {
    const every = Math.ceil(samples.length / SAMPLES_MAX);
    this.samples = samples.filter((_, n) => n % every === 0 || n === samples.length - 1);
    this.whole = true;
  }

  /** @param {number} [now] in a run that is shown whole, the moment to be marked [s] */
  draw(now) {
    const { pen, width, height } = prepare(this.canvas);
    if (this.samples.length === 0) return;
    const newest = this.samples.at(-1);
    const last = this.whole ? this.samples.findLast(({ time }) => time <= now) ?? newest : newest;
    const values = this.samples.flatMap((sample) => sample.values);
    const top = Math.max(0, ...values);
    const bottom = Math.min(0, ...values);
    const range = top - bottom || 1;
    const start = this.whole ? this.samples[0].time : Math.max(0, newest.time - SPAN);
    const span = this.whole ? newest.time - start || 1 : SPAN;
    const x = (time) => (width * (time - start)) / span;
    const y = (value) => EDGE + (height - 2 * EDGE) * (1 - (value - bottom) / range);
    pen.strokeStyle = cssColour('var(--line)');
    pen.lineWidth = 1;
    pen.strokeRect(0.5, 0.5, width - 1, height - 1);
    line(pen, [[0, y(0)], [width, y(0)]]);
    pen.lineWidth = 1.6;
    this.series.forEach(({ colour, dash }, n) => {
      pen.strokeStyle = cssColour(colour);
      pen.setLineDash(dash);
      line(pen, this.samples.map((sample) => [x(sample.time), y(sample.values[n])]));
    });
    pen.setLineDash([]);
    if (this.whole) {
      pen.strokeStyle = cssColour('var(--soft)');
      pen.lineWidth = 1;
      line(pen, [[x(now), 0], [x(now), height]]);
    }
    pen.fillStyle = cssColour('var(--soft)');
    pen.font = '11px system-ui, sans-serif';
    pen.fillText(quantityText(top, 'J'), 5, 12);
    if (bottom < 0) pen.fillText(quantityText(bottom, 'J'), 5, height - 4);
    [...this.legend.querySelectorAll('b')].forEach((entry, n) => {
      entry.textContent = quantityText(last.values[n], 'J');
    });
  }
}

/** The background of a key in the legend: the strokes of its curve. */
export function dashed(colour, dash) {
  if (dash.length === 0) return colour;
  let at = 0;
  const stops = dash.map((length, n) => `${n % 2 === 0 ? colour : 'transparent'} ${at}px ${at += length}px`);
  return `repeating-linear-gradient(90deg, ${stops.join(', ')})`;
}

export function line(pen, points) {
  pen.beginPath();
  for (const [x, y] of points) pen.lineTo(x, y);
  pen.stroke();
}

/** Modes as bars, as high as their frequency, blue where they are stepped explicitly, with a line
 * across at the frequency at which they are stepped. The title has both in numbers.
 * @param {HTMLCanvasElement} canvas @param {number[]} frequencies ascending [Hz]
 * @param {number[]} stepped those of the steps [Hz], NaN where a mode does not vibrate
 * @param {number} explicit how many of the lowest */
export function drawSplit(canvas, frequencies, stepped, explicit) {
  const { pen, width, height } = prepare(canvas);
  const most = Math.log1p(frequencies.at(-1));
  const pitch = width / frequencies.length;
  const high = (frequency) => Math.max(2, (Math.log1p(frequency) / most) * height);
  frequencies.forEach((frequency, n) => {
    const bar = high(frequency);
    pen.fillStyle = n < explicit ? '#2a78c2' : '#e0a458';
    pen.fillRect(n * pitch + 0.5, height - bar, Math.max(1, pitch - 1.5), bar);
    if (Number.isNaN(stepped[n])) return;
    pen.fillStyle = cssColour('var(--ink)');
    pen.fillRect(n * pitch + 0.5, height - high(stepped[n]), Math.max(1, pitch - 1.5), 1.5);
  });
  canvas.title = frequencies.map((frequency, n) =>
    `${n + 1}: ${frequency.toPrecision(4)} Hz, stepped ${stepped[n].toPrecision(4)} Hz`).join('\n');
}
