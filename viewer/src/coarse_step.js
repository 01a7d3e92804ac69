// A time step that is coarse against the first mode of a body, as `thrum simulate` says it (driver/coarse_step.c).
// SPDX-License-Identifier: Apache-2.0
import { quantityText } from './numbers.js';

const WOULD_DO = 20; // steps a period that a model by itself is shown with
const WOULD_DO_LOW = 60; // the same of integrators that make a period longer as the trapezoidal rule does

/** Steps a period from which an integrator shows a mode, 8 for all others. */
const NEEDED = { energy: 2 * Math.PI, 'fox-goodwin': 5, rk4: 5 };

/** Without more than two digits, and not above it. */
function roundDown(value) {
  const unit = 10 ** (Math.floor(Math.log10(value)) - 1);
  return Number((unit * Math.floor((value / unit) * (1 + 1e-12))).toPrecision(2));
}

/** The step [s], or a shorter one where the first mode of a model asks for it.
 * @param {{arrays: {omega2: ArrayLike<number>}}} model @param {number} dt @returns {number} */
export function fittingStep({ arrays: { omega2 } }, dt) {
  const first = Array.from(omega2).find((w2) => w2 > 0);
  const most = (2 * Math.PI) / (WOULD_DO * Math.sqrt(first ?? 0));
  return dt <= most ? dt : roundDown(most);
}

/** Says that a step is coarse against the first frequency [Hz], and which one would do; '' where it is not.
 * @param {number | undefined} first @param {{dt: number, integrator: string}} settings @returns {string} */
export function coarseText(first, { dt, integrator }) {
  const steps = 1 / (first * dt);
  if (!(steps < (NEEDED[integrator] ?? 8))) return '';
  const would = roundDown(1 / ((integrator === 'energy' ? WOULD_DO : WOULD_DO_LOW) * first));
  return `; a period of mode 1 has only ${steps.toPrecision(2)} steps: lower the time step, to ` +
    `${quantityText(would, 's')} say`;
}
