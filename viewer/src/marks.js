// Marks over the picture: where bodies touch.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';

const MARKS_MAX = 1024;

/** Points that lie over everything else. */
export class Marks {
  /** @param {THREE.Scene} scene @param {number} color */
  constructor(scene, color) {
    const geometry = new THREE.BufferGeometry();
    this.places = new THREE.BufferAttribute(new Float32Array(3 * MARKS_MAX), 3);
    geometry.setAttribute('position', this.places);
    this.points = new THREE.Points(geometry,
      new THREE.PointsMaterial({ color, size: 4, sizeAttenuation: false, depthTest: false }));
    this.points.frustumCulled = false;
    this.points.renderOrder = 1;
    scene.add(this.points);
    this.show(new Float32Array(0));
  }

  /** @param {Float32Array} places x, y, z of each [m] */
  show(places) {
    const shown = places.subarray(0, 3 * MARKS_MAX);
    this.places.array.set(shown);
    this.places.needsUpdate = true;
    this.points.geometry.setDrawRange(0, shown.length / 3);
    this.points.visible = shown.length > 0;
  }
}
