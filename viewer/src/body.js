// One body as the page shows it: rest shape, modes and materials. The shape itself is made in
// shader.js from q.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';
import { SurfaceValues } from './colours.js';
import { displace, modesTexture, normalsTexture } from './shader.js';
import { smooth } from './smooth.js';

/** Geometry and modes of a model, shared by its bodies. */
const shapes = new WeakMap();

/** @param {import('./pack.js').Model} model @param {number} rows of textures at most */
function shapeOf(model, rows) {
  let shape = shapes.get(model);
  if (!shape) {
    const split = smooth(model);
    const { source, index, normals, normalModes } = split;
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
    shape = { geometry, split, modes: modesTexture(model, rows),
      normalModes: normalsTexture(normalModes, rows) };
    shapes.set(model, shape);
  }
  return shape;
}

/** The same surface with values of its own, for one body. @param {THREE.BufferGeometry} shared */
function ownGeometry(shared) {
  const geometry = new THREE.BufferGeometry();
  for (const [name, attribute] of Object.entries(shared.attributes))
    geometry.setAttribute(name, attribute);
  geometry.setIndex(shared.index);
  geometry.boundingBox = shared.boundingBox;
  geometry.boundingSphere = shared.boundingSphere;
  return geometry;
}

const HELD_SHARE = 0.03; // of the diagonal of a body, the size of a mark where it is held

export class Body {
  /** @param {import('./pack.js').Model} model @param {{name: string, colour: string}} from
   * @param {number} row in the texture of coordinates @param {THREE.Texture} coordinates
   * @param {number} rows of textures at most */
  constructor(model, from, row, coordinates, rows) {
    const { geometry: shared, split, modes, normalModes } = shapeOf(model, rows);
    const geometry = ownGeometry(shared);
    this.split = split;
    this.scale = from.scale;
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

  /** Finds the quantity at all vertices. @param {string} quantity @param {Float32Array} q
   * @param {number} stiffness factor of Young's modulus @returns {number} the largest value */
  measure(quantity, q, stiffness) {
    this.values ??= new SurfaceValues(this.model, this.split);
    const most = this.values.read(quantity, q, this.scale, stiffness);
    const { geometry } = this.mesh;
    if (!geometry.hasAttribute('value'))
      geometry.setAttribute('value', new THREE.BufferAttribute(this.values.values, 1));
    geometry.attributes.value.needsUpdate = true;
    return most;
  }

  /** Colours by what was measured. @param {number} top of the scale; 0: its own colour */
  colourUpTo(top) {
    this.uniforms.fullScale.value = top;
  }

  /** Draws the edges of the triangles over the surface, or not. @param {boolean} on */
  showEdges(on) {
    if (on && !this.edges) {
      const material = new THREE.MeshBasicMaterial({ color: 0x101820, wireframe: true,
        transparent: true, opacity: 0.35, depthWrite: false });
      this.edges = this.#overlay(new THREE.Mesh(this.mesh.geometry, material));
    }
    if (this.edges) this.edges.visible = on;
  }

  /** Its diagonal at rest [m]. */
  get size() {
    const { min, max } = this.mesh.geometry.boundingBox;
    return this.scale * min.distanceTo(max);
  }

  /** Marks the vertices that are held, or not. @param {boolean} on @param {THREE.Color} colour which is followed */
  showHeld(on, colour) {
    if (on && !this.held) {
      const held = [];
      this.split.source.forEach((vertex, n) => {
        if (this.model.arrays.fixed[vertex] !== 0) held.push(n);
      });
      const geometry = ownGeometry(this.mesh.geometry);
      geometry.setIndex(held);

      // as large as 3 % of the body, so that they do not cover one that is far away
      const material = new THREE.PointsMaterial({ size: HELD_SHARE * this.size });
      material.color = colour;
      this.held = this.#overlay(new THREE.Points(geometry, material));
    }
    if (this.held) this.held.visible = on;
  }

  // drawn with the body, and deformed as it is
  #overlay(object) {
    displace(object.material, { ...this.uniforms, fullScale: { value: 0 } });
    object.material.polygonOffset = true;
    object.material.polygonOffsetFactor = -1;
    object.frustumCulled = false;
    this.mesh.add(object);
    return object;
  }

  dispose() {
    for (const { material, geometry } of [this.mesh, ...this.mesh.children]) {
      material.dispose();
      geometry.dispose();
    }
    this.mesh.customDepthMaterial.dispose();
  }
}
