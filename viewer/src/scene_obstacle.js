// Obstacles of a scene file that is dropped, as the pack has them. SPDX-License-Identifier: Apache-2.0
import { keysOf, withFallbacks } from './scene_keys.js';

const DEGREE = Math.PI / 180;
const SHORT_TURN = 120; // degrees of a part of a path: below 180 the direction is clear
const PARALLEL = 1e-9; // sine of the angle up to which two axes are one

/** A rotation as a quaternion of length 1. */
export function quaternionOf(given) {
  let turned = given;
  if (given.axis) {
    const half = (DEGREE * given.angle) / 2;
    const along = Math.sin(half) / Math.hypot(...given.axis);
    turned = [Math.cos(half), ...given.axis.map((x) => x * along)];
  }
  const length = Math.hypot(...turned);
  return turned.map((x) => x / length);
}

export function colourOf(given) {
  if (typeof given === 'string') return given;
  const part = (x) => Math.round(255 * x).toString(16).padStart(2, '0');
  return `#${given.map(part).join('')}`;
}

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** How far a path turns from one place to the next about one axis [degrees], or null where it has none in common: a quaternion
 * does not know of whole turns. @returns {{axis: number[], from: number, by: number}|null} */
function turnBetween(a, b) {
  const [before, after] = [a, b].map(({ rotation = { axis: [0, 0, 1], angle: 0 } }) => rotation);
  if (!before.axis || !after.axis) return null;
  if (after.angle === 0) return { axis: before.axis, from: before.angle, by: -before.angle };
  if (before.angle === 0) return { axis: after.axis, from: 0, by: after.angle };

  // two rotations about one axis, which may be named from either end
  const along = dot(before.axis, after.axis);
  const size = dot(before.axis, before.axis) * dot(after.axis, after.axis);
  if (size - along * along > PARALLEL * PARALLEL * size) return null;
  const from = along < 0 ? -before.angle : before.angle;
  return { axis: after.axis, from, by: after.angle - from };
}

/** The way of an obstacle: its times, and a place each of seven numbers, with places between where it turns far. */
function wayOf(path) {
  const times = [];
  const places = [];
  const add = (time, centre, rotation) => {
    times.push(time);
    places.push(...centre, ...quaternionOf(rotation));
  };
  path.forEach((point, n) => {
    const before = path[n - 1];
    const turn = before && turnBetween(before, point);
    const parts = turn ? Math.max(Math.ceil(Math.abs(turn.by) / SHORT_TURN), 1) : 1;
    for (let k = 1; k < parts; k++) {
      const between = (x, y) => x + (k / parts) * (y - x);
      add(between(before.time, point.time), point.centre.map((x, axis) => between(before.centre[axis], x)),
        { axis: turn.axis, angle: turn.from + (k / parts) * turn.by });
    }
    add(point.time, point.centre, point.rotation ?? [1, 0, 0, 0]);
  });
  return { times, places };
}

/** An obstacle as `thrum view` packs it. @param {object} given by the scene file, checked
 * @param {import('./engine.js').Engine} engine with a scene of its own, which makes surfaces */
export function obstacleOf(given, engine) {
  const { shape, centre, normal, radius, size, inside, velocity, friction, restitution, stiffness = 0, damping, ...rest } =
    withFallbacks(keysOf(engine.memory), given, 'obstacles');
  const all = { centre, velocity, friction, restitution, colour: colourOf(rest.colour) };
  const rotation = quaternionOf(rest.rotation);
  if (shape === 'plane') return { kind: shape, ...all, normal, inside, stiffness, damping };
  if (shape === 'sphere') return { kind: shape, ...all, radius, inside, stiffness, damping };
  if (shape === 'box' && inside) return { kind: shape, ...all, size, rotation, inside, stiffness, damping };
  return { kind: 'solid', ...all, rotation, ...engine.solidSurface(shape, given), ...wayOf(given.path ?? []) };
}
