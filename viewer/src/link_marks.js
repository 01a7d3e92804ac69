// Links in the picture: springs as lines, joints as points, and what became of them.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';

const LINKS_MAX = 1024; // of a scene, of the engine

/** Beyond this a joint has come open [m], as thrum simulate says it too. */
export const OPEN = 1e-8;

const COLOURS = { spring: 0x2a9d8f, joint: 0x7a3fb0, open: 0xe01b24, released: 0x9a9996 }; // by state

/** @param {{kind: string}} link of the scene @param {{holds: boolean, drift: number}} now of the engine
 * @returns {keyof COLOURS} */
export function stateOf({ kind }, { holds, drift }) {
  if (!holds) return 'released';
  if (kind === 'spring') return 'spring';
  return drift > OPEN ? 'open' : 'joint';
}

/** Points at the ends of links and lines between them, over everything else. What has let go keeps a pale
 * point at each of its two places, and no line. */
export class LinkMarks {
  /** @param {THREE.Scene} scene */
  constructor(scene) {
    const geometry = new THREE.BufferGeometry();
    this.places = new THREE.BufferAttribute(new Float32Array(6 * LINKS_MAX), 3);
    this.colours = new THREE.BufferAttribute(new Float32Array(6 * LINKS_MAX), 3);
    geometry.setAttribute('position', this.places);
    geometry.setAttribute('color', this.colours);
    const look = { vertexColors: true, depthTest: false };
    this.points = new THREE.Points(geometry, new THREE.PointsMaterial({ size: 9, sizeAttenuation: false, ...look }));
    this.lines = new THREE.LineSegments(geometry.clone(), new THREE.LineBasicMaterial(look));
    this.lines.geometry.setAttribute('position', this.places);
    this.lines.geometry.setAttribute('color', this.colours);
    this.lines.geometry.setIndex(new THREE.BufferAttribute(new Uint16Array(2 * LINKS_MAX), 1));
    for (const part of [this.points, this.lines]) {
      part.frustumCulled = false;
      part.renderOrder = 1;
      scene.add(part);
    }
    this.show([]);
  }

  /** How many are drawn. @returns {{points: number, lines: number}} */
  get counts() {
    return { points: this.points.geometry.drawRange.count, lines: this.lines.geometry.drawRange.count / 2 };
  }

  /** @param {{state: keyof COLOURS, places: number[]}[]} links the two places of each, six numbers [m] */
  show(links) {
    const shown = links.slice(0, LINKS_MAX);
    const index = this.lines.geometry.index;
    let joined = 0;
    shown.forEach(({ state, places }, n) => {
      const colour = new THREE.Color(COLOURS[state]);
      this.places.array.set(places, 6 * n);
      this.colours.array.set([...colour, ...colour], 6 * n);
      if (state !== 'released') index.array.set([2 * n, 2 * n + 1], 2 * joined++);
    });
    for (const buffer of [this.places, this.colours, index]) buffer.needsUpdate = true;
    this.points.geometry.setDrawRange(0, 2 * shown.length);
    this.lines.geometry.setDrawRange(0, 2 * joined);
    this.points.visible = shown.length > 0;
    this.lines.visible = joined > 0;
  }
}
