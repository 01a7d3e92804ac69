// How much of the world the picture is to hold: obstacles, bodies where they stand, and where they get to by joints that they swing
// on, or in a run that is played. SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';

const MOMENTS = 200; // of a run, at which bodies are looked at

/** Of a thing to be seen whole; empty for planes and for rooms. @param {object} obstacle */
export function boundsOfObstacle({ kind, centre, rotation, radius, size, inside, vertices }) {
  if (kind === 'plane' || inside) return new THREE.Box3();
  if (kind === 'solid') {
    const [w, x, y, z] = rotation ?? [1, 0, 0, 0];
    const place = new THREE.Matrix4().compose(new THREE.Vector3(...centre),
      new THREE.Quaternion(x, y, z, w), new THREE.Vector3(1, 1, 1));
    return new THREE.Box3().setFromArray(vertices).applyMatrix4(place);
  }
  const extent = kind === 'sphere' ? [2 * radius, 2 * radius, 2 * radius] : size;
  return new THREE.Box3().setFromCenterAndSize(new THREE.Vector3(...centre),
    new THREE.Vector3(...extent));
}

/** From a point to the farthest corner of a box. */
const farthest = (point, { min, max }) => Math.hypot(...['x', 'y', 'z'].map((axis) =>
  Math.max(Math.abs(point[axis] - min[axis]), Math.abs(point[axis] - max[axis]))));

/** How far each body that hangs on a joint of the world gets from it: along the bodies between them.
 * @returns {Map<number, number>} by bodies [m] */
function reaches(root, bodies, joints) {
  const lengths = new Map([[root.body, { length: 0, place: root.place }]]);
  for (const [at, { length, place }] of lengths) // which grows on the way
    for (const joint of joints) {
      const next = joint.body === at ? joint.other : joint.other === at ? joint.body : undefined;
      if (next === undefined || !bodies[next].free || lengths.has(next)) continue;
      lengths.set(next, { length: length + place.distanceTo(joint.place), place: joint.place });
    }
  return new Map([...lengths].map(([n, { length, place }]) => [n, length + farthest(place, bodies[n].box)]));
}

/** The room that bodies have which hang on joints and swing, no higher than the highest of all stands where they weigh anything. A body
 * that hangs on several joints has the room that each of them leaves. Turns about a hinge stay across its axis.
 * @param {{box: THREE.Box3, free: boolean}[]} bodies where they stand
 * @param {{kind: string, body: number, other: number|undefined, place: THREE.Vector3, axis: THREE.Vector3|undefined}[]} joints
 * @param {THREE.Vector3} gravity @returns {THREE.Box3[]} of each body, at least its own */
export function boundsOfSwings(bodies, joints, gravity) {
  const rooms = bodies.map(() => undefined);
  const isHeld = (n) => n === undefined || !bodies[n].free;
  for (const { kind, body, other, place, axis } of joints) {
    // one side of it is in the world, or of a body that is held there
    const hung = isHeld(other) ? body : isHeld(body) ? other : undefined;
    if (hung === undefined || isHeld(hung) || kind === 'weld') continue;
    for (const [n, reach] of reaches({ body: hung, place }, bodies, joints)) {
      const across = new THREE.Vector3(1, 1, 1);
      if (axis) across.set(...axis.toArray().map((x) => Math.sqrt(Math.max(0, 1 - x * x))));
      const room = new THREE.Box3(place.clone().addScaledVector(across, -reach), place.clone().addScaledVector(across, reach));
      rooms[n] = rooms[n] ? rooms[n].intersect(room) : room;
    }
  }

  // what weighs nothing swings to all sides
  const all = bodies.reduce((sum, { box }) => sum.union(box), new THREE.Box3());
  const steepest = ['x', 'y', 'z'].find((name) => Math.abs(gravity[name]) > 0.7 * gravity.length());
  return bodies.map(({ box }, n) => {
    const room = rooms[n];
    if (room && steepest && gravity[steepest] < 0) room.max[steepest] = Math.min(room.max[steepest], all.max[steepest]);
    if (room && steepest && gravity[steepest] > 0) room.min[steepest] = Math.max(room.min[steepest], all.min[steepest]);
    return room ? room.union(box) : box.clone();
  });
}

/** Where a body gets to in a run, but no farther from where all stood than these bounds are wide: what falls forever leaves the picture.
 * @param {import('./recording.js').Recording} recording @param {number} body @param {THREE.Box3} own in its own axes
 * @param {THREE.Box3} all at the start @returns {THREE.Box3} */
export function boundsOfMotion(recording, body, own, all) {
  const { time } = recording;
  const bounds = new THREE.Box3();
  for (let n = 0; n <= MOMENTS; n++) {
    recording.seek(recording.begin + (n / MOMENTS) * (recording.end - recording.begin));
    bounds.union(own.clone().applyMatrix4(new THREE.Matrix4().fromArray(recording.matrix(body))));
  }
  recording.seek(time);
  return bounds.intersect(all.clone().expandByScalar(Math.max(...all.getSize(new THREE.Vector3()).toArray())));
}
