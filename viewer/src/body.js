// One body as the page shows it: rest shape, modes and materials. The shape itself is made in
// shader.js from q.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';
import { displace, modesTexture, normalsTexture } from './shader.js';
import { smooth } from './smooth.js';

/** Geometry and modes of a model, shared by its bodies. */
const shapes = new WeakMap();

/** @param {import('./pack.js').Model} model @param {number} rows of textures at most */
function shapeOf(model, rows) {
  let shape = shapes.get(model);
  if (!shape) {
    const { source, index, normals, normalModes } = smooth(model);
    const geometry = new THREE.BufferGeometry();
    const from = model.arrays.positions;
    const positions = Float32Array.from({ length: 3 * source.length },
      (_, n) => from[3 * source[Math.trunc(n / 3)] + (n % 3)]);
    const sources = new THREE.BufferAttribute(source, 1);
    sources.gpuType = THREE.IntType;
    geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
    geometry.setAttribute('normal', new THREE.BufferAttribute(normals, 3));
    geometry.setAttribute('source', sources);
    geometry.setIndex(new THREE.BufferAttribute(index, 1));
    geometry.computeBoundingBox();
    geometry.computeBoundingSphere();
    shape = { geometry, modes: modesTexture(model, rows),
      normalModes: normalsTexture(normalModes, rows) };
    shapes.set(model, shape);
  }
  return shape;
}

export class Body {
  /** @param {import('./pack.js').Model} model @param {{name: string, colour: string}} from
   * @param {number} row in the texture of coordinates @param {THREE.Texture} coordinates
   * @param {number} rows of textures at most */
  constructor(model, from, row, coordinates, rows) {
    const { geometry, modes, normalModes } = shapeOf(model, rows);
    this.model = model;
    this.name = from.name;
    this.uniforms = {
      modes: { value: modes }, normalModes: { value: normalModes },
      coordinates: { value: coordinates },
      rank: { value: model.rank }, row: { value: row }, fullScale: { value: 0 },
    };
    const material = new THREE.MeshStandardMaterial({
      color: from.colour, roughness: 0.55, metalness: 0.05,
      side: THREE.DoubleSide, shadowSide: THREE.BackSide,
    });
    const depth = new THREE.MeshDepthMaterial({ depthPacking: THREE.RGBADepthPacking });
    displace(material, this.uniforms);
    displace(depth, this.uniforms);
    this.mesh = new THREE.Mesh(geometry, material);
    this.mesh.customDepthMaterial = depth;
    this.mesh.castShadow = this.mesh.receiveShadow = true;
    this.mesh.frustumCulled = false; // its bounds are those at rest
  }

  /** Is it held where it is lowest? Such a body stands on the floor. */
  get stands() {
    const { positions, fixed } = this.model.arrays;
    const { min, max } = this.mesh.geometry.boundingBox;
    const low = min.z + 0.01 * (max.z - min.z);
    let [held, all] = [0, 0];
    fixed.forEach((bits, v) => {
      if (positions[3 * v + 2] > low) return;
      all++;
      if (bits !== 0) held++;
    });
    return 2 * held > all;
  }

  /** Colours by displacement, or not. @param {boolean} on */
  colourByDisplacement(on) {
    const size = this.mesh.geometry.boundingSphere.radius;
    this.uniforms.fullScale.value = on ? 0.5 * size : 0;
  }

  dispose() {
    this.mesh.material.dispose();
    this.mesh.customDepthMaterial.dispose();
  }
}
