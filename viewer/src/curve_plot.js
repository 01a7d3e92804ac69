// The drawing of a curve of periodic motions: the largest displacement over the frequency, stable motions in full and unstable
// ones dashed, special points marked, and the one that is shown. A press on it picks another.
// SPDX-License-Identifier: Apache-2.0
import { quantityText } from './numbers.js';
import { dashed, line, prepare } from './plot.js';
import { cssColour } from './theme.js';

const EDGE = 18; // room for numbers above and below [px]
const SIDE = 8; // and beside the curve [px]
const DASH = [5, 4];

const STABLE = { name: 'stable', colour: 'var(--kinetic)', dash: [] };
const UNSTABLE = { name: 'unstable', colour: 'var(--links)', dash: DASH };

/** How special points are marked. */
const MARKS = {
  fold: { colour: 'var(--ink)', corners: 0 }, 'period doubling': { colour: 'var(--contact)', corners: 3 },
  'Neimark-Sacker': { colour: 'var(--gravity)', corners: 4 }, 'branch point': { colour: 'var(--strain)', corners: 4 },
};

/** A disc, or a triangle or square, about a place. */
function mark(pen, [x, y], size, corners) {
  pen.beginPath();
  if (corners === 0) pen.arc(x, y, size, 0, 2 * Math.PI);
  for (let n = 0; n < corners; n++) {
    const turn = 2 * Math.PI * (n + (corners === 4 ? 0.5 : 0)) / corners;
    pen.lineTo(x + 1.3 * size * Math.sin(turn), y - 1.3 * size * Math.cos(turn));
  }
  pen.closePath();
}

/** The stretches of a curve on which motions are stable, or unstable; neighbours share a point.
 * @param {Int32Array} unstable @returns {{first: number, last: number, isUnstable: boolean}[]} */
export function stretchesOf(unstable) {
  const stretches = [];
  let first = 0;
  for (let n = 1; n <= unstable.length; n++) {
    const isUnstable = unstable[n - 1] > 0;
    if (n < unstable.length && unstable[n] > 0 === isUnstable) continue;
    stretches.push({ first, last: Math.min(n, unstable.length - 1), isUnstable });
    first = n;
  }
  return stretches;
}

export class CurvePlot {
  /** @param {HTMLCanvasElement} canvas @param {HTMLElement} legend @param {(row: number) => void} picked */
  constructor(canvas, legend, picked) {
    Object.assign(this, { canvas, legend, orbit: undefined });
    const pick = (event) => this.orbit && event.buttons === 1 && picked(this.nearest(event.offsetX, event.offsetY));
    canvas.addEventListener('pointerdown', pick);
    canvas.addEventListener('pointermove', pick);
  }

  /** @param {import('./orbit.js').Orbit} orbit; undefined: no curve is shown, and nothing picked */
  begin(orbit) {
    this.orbit = orbit;
    this.canvas.classList.toggle('curve', orbit !== undefined);
    if (!orbit) return;
    const { kinds, arrays: { frequency, peak, unstable, kind } } = orbit.curve;
    const bounds = (values) => [values.reduce((a, b) => Math.min(a, b)), values.reduce((a, b) => Math.max(a, b))];
    [this.left, this.right] = bounds(frequency);
    this.top = bounds(peak)[1];
    this.stretches = stretchesOf(unstable);
    this.special = [...kind.keys()].filter((row) => MARKS[kinds[kind[row]]]);

    // what is on this curve
    const present = [STABLE, UNSTABLE].filter((of) => unstable.some((count) => (count > 0) === (of === UNSTABLE)));
    const marked = new Set(this.special.map((row) => kinds[kind[row]]));
    this.legend.replaceChildren(...present.map(({ name, colour, dash }) => entry(name, dashed(colour, dash))),
      ...[...marked].map((name) => entry(name, MARKS[name].colour, MARKS[name].corners)));
  }

  /** Where a motion is on the drawing [px]. */
  place(row) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const { frequency, peak } = this.orbit.curve.arrays;
    return [SIDE + (width - 2 * SIDE) * (frequency[row] - this.left) / (this.right - this.left || 1),
      height - EDGE - (height - 2 * EDGE) * peak[row] / (this.top || 1)];
  }

  /** The motion that is drawn the nearest to a place [px]. */
  nearest(x, y) {
    let [best, least] = [0, Infinity];
    for (let row = 0; row < this.orbit.count; row++) {
      const [u, v] = this.place(row);
      const away = Math.hypot(u - x, v - y);
      if (away < least) [best, least] = [row, away];
    }
    return best;
  }

  draw() {
    const { pen, width, height } = prepare(this.canvas);
    const { kinds, arrays: { kind } } = this.orbit.curve;
    pen.strokeStyle = cssColour('var(--line)');
    pen.lineWidth = 1;
    pen.strokeRect(0.5, 0.5, width - 1, height - 1);
    line(pen, [[0, height - EDGE], [width, height - EDGE]]);

    // the curve, then what is on it
    pen.lineWidth = 1.8;
    for (const { first, last, isUnstable } of this.stretches) {
      const { colour, dash } = isUnstable ? UNSTABLE : STABLE;
      pen.strokeStyle = cssColour(colour);
      pen.setLineDash(dash);
      line(pen, Array.from({ length: last - first + 1 }, (_, n) => this.place(first + n)));
    }
    pen.setLineDash([]);
    for (const row of this.special) {
      const { colour, corners } = MARKS[kinds[kind[row]]];
      pen.fillStyle = cssColour(colour);
      mark(pen, this.place(row), 3.5, corners);
      pen.fill();
    }
    pen.strokeStyle = cssColour('var(--ink)');
    pen.lineWidth = 2;
    mark(pen, this.place(this.orbit.row), 6, 0);
    pen.stroke();

    // the ends of both axes
    pen.fillStyle = cssColour('var(--soft)');
    pen.font = '11px system-ui, sans-serif';
    pen.fillText(`${quantityText(this.top, 'm')} at ${this.orbit.curve.target}`, 5, 12);
    pen.fillText(`${this.left.toPrecision(4)} Hz`, 5, height - 5);
    pen.textAlign = 'right';
    pen.fillText(`${this.right.toPrecision(4)} Hz`, width - 5, height - 5);
    pen.textAlign = 'left';
  }
}

/** A line of the legend: a stroke, or a mark. */
function entry(name, background, corners) {
  const span = document.createElement('span');
  const key = document.createElement('i');
  key.style.background = background;
  if (corners !== undefined) key.className = ['disc', '', '', 'triangle', 'square'][corners];
  span.append(key, name);
  return span;
}

/** "point 80 of 129: 263.4 Hz, 1.90 mm, unstable, fold". @param {import('./orbit.js').Orbit} orbit */
export function pointText({ row, count, curve: { kinds, arrays: { frequency, peak, unstable, kind } } }) {
  const stability = unstable[row] < 0 ? '' : `, ${unstable[row] > 0 ? 'unstable' : 'stable'}`;
  const special = MARKS[kinds[kind[row]]] ? `, ${kinds[kind[row]]}` : '';
  return `point ${row + 1} of ${count}: ${frequency[row].toPrecision(6)} Hz, ${quantityText(peak[row], 'm')}${stability}${special}`;
}
