// Which bodies stand where: the scene of the pack, one model alone, or copies of it side by
// side. All are of the pack's form (docs/viewer.md).
// SPDX-License-Identifier: Apache-2.0
import { fittingStep } from './coarse_step.js';

/** What copies of a scene are stepped by, and how their curves are drawn, so that they are told apart in grey, too.
 * @typedef {{name: string, colour: string, dash: number[], change: (body: object) => object}} Copy */

/** The integrators that are compared. Bodies whose spin and shape are coupled are stepped by energy in each copy.
 * @type {Copy[]} */
const BY_INTEGRATOR = [['imexv', '#2a78c2', []], ['newmark', '#dd7a22', [7, 3]], ['energy', '#35995a', [2, 2]]]
  .map(([name, colour, dash]) => ({ name, colour, dash, change: ({ coupled }) => ({ integrator: coupled ? 'energy' : name }) }));

/** Of a scene that energy alone steps: what the coupling does. @type {Copy[]} */
const BY_COUPLING = [['coupled', '#2a78c2', [], true], ['not coupled', '#dd7a22', [7, 3], false]]
  .map(([name, colour, dash, coupled]) => ({ name, colour, dash, change: () => ({ integrator: 'energy', coupled }) }));

const SPACING = 1.25; // of copies, in widths of the body

/** Is the scene of the pack more than one body by itself? A recording is, and a curve.
 * @param {import('./pack.js').Pack} pack */
export function isComposed({ scene, recording, curve }) {
  return recording !== undefined || curve !== undefined || scene.bodies.length > 1 || scene.obstacles.length > 0 || scene.links?.length > 0;
}

/** One model by itself, under the pack's gravity and damping, and with its step, which is made to fit where no scene file gave it.
 * @param {import('./pack.js').Pack} pack @param {number} model */
export function aloneScene(pack, model) {
  const given = pack.scene.bodies.find((body) => body.model === model);
  const body = {
    name: pack.models[model].name, model, position: [0, 0, 0], rotation: [1, 0, 0, 0], scale: 1,
    stiffness: 1, density: 1, colour: '#4a86c5', ...given,
  };
  const dt = pack.scene.own_dt ? pack.scene.dt : fittingStep(pack.models[model], pack.scene.dt);
  return {
    ...pack.scene, dt, obstacles: [], collisions: undefined, links: [], bodies: [{ ...body, position: [0, 0, 0] }],
  };
}

/** How far a scene reaches along x: its bodies at rest, however they are turned, and its obstacles
 * but for planes. @param {import('./pack.js').Pack} pack @param {object} scene */
function widthOf(pack, scene) {
  const ends = scene.bodies.flatMap(({ model, position: [x], scale }) => {
    const { positions } = pack.models[model].arrays;
    if (scene.bodies.length === 1) {
      const along = positions.filter((_, n) => n % 3 === 0);
      return [x + scale * along.reduce((a, b) => Math.min(a, b)), x + scale * along.reduce((a, b) => Math.max(a, b))];
    }
    let reach = 0;
    for (let n = 0; n < positions.length; n += 3)
      reach = Math.max(reach, Math.hypot(positions[n], positions[n + 1], positions[n + 2]));
    return [x - scale * reach, x + scale * reach];
  });
  for (const obstacle of scene.obstacles.filter(isCopied)) {
    const { centre: [x], radius = 0, size = [0, 0, 0], vertices = [] } = obstacle;
    const reach = Math.max(radius, Math.hypot(...size) / 2, ...vertices.map(Math.abs));
    ends.push(x - reach, x + reach);
  }
  return Math.max(...ends) - Math.min(...ends);
}

const isCopied = ({ kind }) => kind !== 'plane'; // a plane is everywhere

/** An obstacle beside itself, with its path. */
function shifted(obstacle, way) {
  const [x, y, z] = obstacle.centre;
  const places = obstacle.places?.map((value, n) => (n % 7 === 0 ? value + way : value));
  return { ...obstacle, centre: [x + way, y, z], ...(places && { places }) };
}

/** A link beside itself, of the bodies of a copy. */
function shiftedLink(link, way, bodies) {
  const along = ([x, y, z]) => [x + way, y, z];
  return { ...link, body: link.body + bodies, place: along(link.place), other_place: along(link.other_place),
    ...(link.other !== undefined && { other: link.other + bodies }) };
}

/** A scene two or three times, side by side, as the integrators step it; a scene of bodies whose spin and shape are all
 * coupled, as they move with that and without. Planes are shared. Copies of several bodies are so far apart that they do not
 * meet; the copies of one body pass through each other.
 * @param {import('./pack.js').Pack} pack @param {object} scene
 * @returns {object} a scene that has its `copies`, and whether they are `ofCoupling` */
export function comparedScene(pack, scene) {
  if (scene.obstacles.some(({ inside }) => inside))
    throw new Error('bodies inside an obstacle cannot be compared: there is no room for them beside each other');
  const ofCoupling = scene.bodies.every((body) => body.coupled);
  const copies = ofCoupling ? BY_COUPLING : BY_INTEGRATOR;
  const way = SPACING * widthOf(pack, scene);
  const whole = scene.bodies.length > 1;
  const shifts = copies.map((_, n) => (n - (copies.length - 1) / 2) * way);
  return {
    ...scene, copies, ofCoupling,
    collisions: whole && scene.collisions
      ? { ...scene.collisions, touches: copies.length * scene.collisions.touches } : undefined,
    obstacles: [...scene.obstacles.filter((obstacle) => !isCopied(obstacle)),
      ...shifts.flatMap((shift) => scene.obstacles.filter(isCopied).map((obstacle) => shifted(obstacle, shift)))],
    links: shifts.flatMap((shift, n) =>
      (scene.links ?? []).map((link) => shiftedLink(link, shift, n * scene.bodies.length))),
    bodies: copies.flatMap(({ name, colour, change }, n) => scene.bodies.map((body) => {
      const [x, y, z] = body.position;
      const own = change(body);
      return { ...body, ...own, name: whole ? `${body.name} ${ofCoupling ? name : `by ${own.integrator}`}` : name,
        colour: whole ? body.colour : colour, position: [x + shifts[n], y, z] };
    })),
  };
}
