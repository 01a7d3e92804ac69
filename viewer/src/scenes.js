// Which bodies stand where: the scene of the pack, one model alone, or three copies of it side by
// side. All are of the pack's form (docs/viewer.md).
// SPDX-License-Identifier: Apache-2.0

/** Integrators that are compared, and their colours. */
export const COMPARED = [['imexv', '#2a78c2'], ['newmark', '#dd7a22'], ['energy', '#35995a']];
const SPACING = 1.25; // of copies, in widths of the body

/** Is the scene of the pack more than one body by itself? A recording is.
 * @param {import('./pack.js').Pack} pack */
export function isComposed({ scene, recording }) {
  return recording !== undefined || scene.bodies.length > 1 || scene.obstacles.length > 0 || scene.links?.length > 0;
}

/** One model by itself, under the pack's gravity, step and damping.
 * @param {import('./pack.js').Pack} pack @param {number} model */
export function aloneScene(pack, model) {
  const given = pack.scene.bodies.find((body) => body.model === model);
  const body = {
    name: pack.models[model].name, model, position: [0, 0, 0], rotation: [1, 0, 0, 0], scale: 1,
    stiffness: 1, density: 1, colour: '#4a86c5', ...given,
  };
  return {
    ...pack.scene, obstacles: [], collisions: undefined, links: [], bodies: [{ ...body, position: [0, 0, 0] }],
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

/** A scene three times, side by side, each with its integrator. Planes are shared. Copies of
 * several bodies are so far apart that they do not meet; the copies of one body pass through each other.
 * Bodies whose spin and shape are coupled are stepped by energy in each copy.
 * @param {import('./pack.js').Pack} pack @param {object} scene */
export function comparedScene(pack, scene) {
  if (scene.obstacles.some(({ inside }) => inside))
    throw new Error('bodies inside an obstacle cannot be compared: there is no room for three beside each other');
  if (scene.bodies.every((body) => body.coupled))
    throw new Error(`${scene.bodies[0].name}: a body whose spin and shape are coupled is stepped by energy alone, so there is nothing to compare`);
  const way = SPACING * widthOf(pack, scene);
  const whole = scene.bodies.length > 1;
  const shifts = COMPARED.map((_, n) => (n - 1) * way);
  return {
    ...scene,
    collisions: whole && scene.collisions
      ? { ...scene.collisions, touches: COMPARED.length * scene.collisions.touches } : undefined,
    obstacles: [...scene.obstacles.filter((obstacle) => !isCopied(obstacle)),
      ...shifts.flatMap((shift) => scene.obstacles.filter(isCopied).map((obstacle) => shifted(obstacle, shift)))],
    links: shifts.flatMap((shift, n) =>
      (scene.links ?? []).map((link) => shiftedLink(link, shift, n * scene.bodies.length))),
    bodies: COMPARED.flatMap(([integrator, colour], n) => scene.bodies.map((body) => {
      const [x, y, z] = body.position;
      const own = body.coupled ? 'energy' : integrator; // the only one that steps such bodies
      return { ...body, name: whole ? `${body.name} by ${own}` : integrator, integrator: own,
        colour: whole ? body.colour : colour, position: [x + shifts[n], y, z] };
    })),
  };
}
