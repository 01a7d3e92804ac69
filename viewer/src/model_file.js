// A model file as a model of the page: what `thrum view` makes of one, for a file that is dropped.
// SPDX-License-Identifier: Apache-2.0
import { mostStepped } from './pack.js';
import { outerTriangles } from '../../javascript/src/outer_triangles.js';

const KEPT = ['omega2', 'c3', 'c4', 'point_weights', 'point_moduli', 'point_gradients', 'point_law',
  'point_region', 'region_law', 'axis_mass', 'slave_map', 'condensed_c3', 'condensed_c4'];

/** The inertia of a body that nothing holds: corners of its first tetrahedron, and the rigid modes
 * there. */
function rigidOf({ vertices, rigid, tets }) {
  const corners = Array.from(tets.subarray(0, 4));
  const rows = (array, width) =>
    Float64Array.from(corners.flatMap((v) => Array.from(array.subarray(width * v, width * (v + 1)))));
  return { tet: rows(vertices, 3), tet_rigid: rows(rigid, 18) };
}

/** Rows of an array of all vertices, of those that are shown. */
const shownRows = (array, width, vertices, Type) => {
  const out = new Type(width * vertices.length);
  vertices.forEach((v, n) => out.set(array.subarray(width * v, width * (v + 1)), width * n));
  return out;
};

/** @param {import('./engine.js').Engine} engine @param {Uint8Array} bytes of the file
 * @param {string} name of the file @returns {import('./pack.js').Model} */
export function readModelFile(engine, bytes, name) {
  const { counts, unitEnergy, arrays: all } = engine.openModel(bytes);
  const { rank, regions, masters } = counts;
  const triangles = outerTriangles(all.tets);
  const vertices = [...new Set(triangles)].sort((a, b) => a - b);
  const place = new Map(vertices.map((v, n) => [v, n]));
  const arrays = Object.fromEntries(KEPT.filter((key) => all[key]).map((key) => [key, all[key]]));
  return {
    name, title: name.replace(/\.npz$/, ''), rank, regions,
    ...(masters > 0 && { masters }),
    vertex_count: vertices.length, triangle_count: triangles.length / 3,
    // the first rigid mode is a shift by one over the root of the mass
    mass: all.rigid ? 1 / all.rigid[0] ** 2 : 0, young: all.material[0], poisson: all.material[1],
    unit_energy: unitEnergy,
    arrays: {
      ...arrays,
      ...(all.rigid && rigidOf(all)),
      positions: shownRows(all.vertices, 3, vertices, Float32Array),
      basis: shownRows(all.basis, 3 * rank, vertices, Float32Array),
      triangles: triangles.map((v) => place.get(v)),
      fixed: shownRows(all.fixed, 1, vertices, Uint8Array),
    },
  };
}

/** Models by themselves, the first one held as its mesh says and without gravity, as `thrum view` shows
 * them. @param {import('./pack.js').Model[]} models @returns {import('./pack.js').Pack} */
export function packOfModels(models) {
  const [first] = models;
  return {
    models,
    scene: { dt: 0.003, integrator: 'energy', gravity: [0, 0, 0], damping: 0, obstacles: [],
      bodies: [{ name: first.name, model: 0, position: [0, 0, 0], rotation: [1, 0, 0, 0], scale: 1,
        stiffness: 1, density: 1, rank: mostStepped(first), colour: '#4a86c5', free: false }] },
  };
}
