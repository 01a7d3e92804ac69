// Which bodies stand where: the scene of the pack, one model alone, or three copies of it side by
// side. All are of the pack's form (docs/viewer.md).
// SPDX-License-Identifier: Apache-2.0

/** Integrators that are compared, and their colours. */
export const COMPARED = [['imexv', '#2a78c2'], ['newmark', '#dd7a22'], ['energy', '#35995a']];
const SPACING = 1.25; // of copies, in widths of the body

/** Is the scene of the pack more than one body by itself? A recording is.
 * @param {import('./pack.js').Pack} pack */
export function isComposed({ scene, recording }) {
  return recording !== undefined || scene.bodies.length > 1 || scene.obstacles.length > 0;
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
    ...pack.scene, obstacles: [], collisions: undefined, bodies: [{ ...body, position: [0, 0, 0] }],
  };
}

/** Least and largest x of a body's model at rest, in its scale. */
function widthOf(model, scale) {
  const x = model.arrays.positions;
  let least = Infinity;
  let most = -Infinity;
  for (let v = 0; v < x.length; v += 3) {
    least = Math.min(least, x[v]);
    most = Math.max(most, x[v]);
  }
  return scale * (most - least);
}

/** The first body of a scene three times, each with its integrator; planes stay,
 * and the copies pass through each other.
 * @param {import('./pack.js').Pack} pack @param {object} scene */
export function comparedScene(pack, scene) {
  const body = scene.bodies[0];
  const way = SPACING * widthOf(pack.models[body.model], body.scale);
  const [x, y, z] = body.position;
  return {
    ...scene,
    collisions: undefined,
    obstacles: scene.obstacles.filter(({ kind }) => kind === 'plane'),
    bodies: COMPARED.map(([integrator, colour], n) => ({
      ...body, name: integrator, integrator, colour, position: [x + (n - 1) * way, y, z],
    })),
  };
}
