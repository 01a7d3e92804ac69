// The surface of a mesh of tetrahedra. SPDX-License-Identifier: Apache-2.0

const FACES = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];

/** Faces that belong to one tetrahedron alone, counter-clockwise from outside.
 * @param {Int32Array} tets four corners each @returns {Int32Array} three corners each */
export function outerTriangles(tets) {
  const seen = new Map();
  for (let tet = 0; tet < tets.length; tet += 4)
    for (const face of FACES) {
      const corners = face.map((corner) => tets[tet + corner]);
      const key = [...corners].sort((a, b) => a - b).join();
      // a face that a second tetrahedron has too lies inside
      if (seen.has(key)) seen.delete(key);
      else seen.set(key, corners);
    }
  return Int32Array.from([...seen.values()].flat());
}
