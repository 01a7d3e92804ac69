// Pulling with a mouse or fingers: a spring from the vertex under the pointer to the pointer, in
// the plane through that vertex that faces the camera. Each finger pulls its own.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';
import { quantityText } from './numbers.js';

const COLOUR = 0xc0281f;
const TAP = 200; // a shorter pull is a strike [ms]
const FOLLOWS = 80; // per cent below which the page says that the model cannot show a pull
const CONE = new THREE.ConeGeometry(0.35, 1);

/** @param {import('./world.js').World} world
 * @param {(action: () => void) => void} guard says on the page what an action is refused for
 * @param {(body: number, vertex: number, direction: number[]) => void} struck hears of a tap
 * @returns {() => void} what draws the springs in each frame */
export function pullWithPointers(world, guard, struck) {
  const { stage } = world;
  const canvas = stage.renderer.domElement;
  /** @type {Map<number, {plane: THREE.Plane, line: THREE.Line, head: THREE.Mesh, label: HTMLElement}>} */
  const held = new Map();

  function release(event) {
    const pull = held.get(event.pointerId);
    if (!pull) return;
    if (event.type === 'pointerup' && performance.now() - pull.since < TAP) pull.strike();
    stage.scene.remove(pull.line, pull.head);
    pull.line.geometry.dispose();
    pull.label.remove();
    held.delete(event.pointerId);
    if (world.pulls.has(event.pointerId)) world.endPull(event.pointerId);
    stage.controls.enabled = held.size === 0;
    canvas.classList.toggle('pulling', held.size > 0);
    if (held.size === 0) sayFollows(undefined);
  }

  function press(event) {
    document.getElementById('hint').hidden = true;
    if (event.button !== 0 || world.plays) return;
    const ray = stage.ray(event.clientX, event.clientY);
    const pick = world.engine.pick(ray.origin.toArray(), ray.direction.toArray());
    if (!pick || pick.vertex < 0) return;
    const at = new THREE.Vector3(...world.engine.position(pick.body, pick.vertex));
    const facing = stage.camera.getWorldDirection(new THREE.Vector3());
    const plane = new THREE.Plane().setFromNormalAndCoplanarPoint(facing, at);
    held.set(event.pointerId, { plane, line: addLine(stage.scene), head: addHead(stage.scene),
      label: addLabel(), since: performance.now(),
      strike: () => struck(pick.body, pick.vertex, facing.toArray()) });
    stage.controls.enabled = false;
    canvas.classList.add('pulling');
    canvas.setPointerCapture(event.pointerId);
    sayFollows(world.follows(pick.body, pick.vertex), world.hasFollowers(pick.body));
    guard(() => world.startPull(event.pointerId, pick.body, pick.vertex, at.toArray()));
    event.stopImmediatePropagation();
  }

  function move(event) {
    const pull = held.get(event.pointerId);
    const spring = world.pulls.get(event.pointerId);
    if (!pull || !spring) return;
    const target = stage.ray(event.clientX, event.clientY)
      .intersectPlane(pull.plane, new THREE.Vector3());
    if (target) guard(() => world.movePull(event.pointerId, target.toArray()));
    event.stopImmediatePropagation();
  }

  // before the camera's own, which listen on the same canvas
  canvas.addEventListener('pointerdown', press, { capture: true });
  canvas.addEventListener('pointermove', move, { capture: true });
  for (const end of ['pointerup', 'pointercancel', 'lostpointercapture'])
    canvas.addEventListener(end, release, { capture: true });

  return function drawSprings() {
    for (const [id, { line, head, label }] of held) {
      const spring = world.pulls.get(id);
      line.visible = head.visible = spring !== undefined;
      label.hidden = !spring;
      if (!spring) continue;
      const from = new THREE.Vector3(...world.engine.position(spring.body, spring.vertex));
      const to = new THREE.Vector3(...spring.target);
      const ends = line.geometry.attributes.position;
      ends.setXYZ(0, ...from);
      ends.setXYZ(1, ...to);
      ends.needsUpdate = true;
      placeHead(head, from, to, stage.camera);

      // the number beside the pointer
      label.textContent = quantityText(world.pullForce(id), 'N');
      const { x, y } = stage.project(spring.target);
      label.style.left = `${x + 50}px`;
      label.style.top = `${y - 12}px`;
    }
  };
}

/** Says in the place of the hint that the model cannot show the pull, and what to do.
 * @param {number|undefined} follows per cent; undefined: nothing to say
 * @param {boolean} [followers] shapes that are not stepped follow pulls already */
function sayFollows(follows, followers) {
  const hint = document.getElementById('hint');
  hint.hidden = !(follows < FOLLOWS);
  if (!hint.hidden)
    hint.textContent = `Here the model gives ${follows} % of what its mesh gives. `
      + (followers ? 'Name this place with --handles of thrum precompute to have it follow better.'
        : 'A model made with thrum precompute --touch follows better.');
}

/** The head of an arrow, of the same size on the page wherever it is. */
function placeHead(head, from, to, camera) {
  const along = to.clone().sub(from);
  const size = 0.02 * to.distanceTo(camera.position);
  head.visible = along.length() > size;
  head.scale.setScalar(size);
  head.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), along.normalize());
  head.position.copy(to).addScaledVector(along, -0.5 * size);
}

function addHead(scene) {
  const head = new THREE.Mesh(CONE, new THREE.MeshBasicMaterial({ color: COLOUR, depthTest: false }));
  head.renderOrder = 1;
  scene.add(head);
  return head;
}

function addLabel() {
  const label = document.createElement('span');
  label.className = 'force';
  document.getElementById('forces').append(label);
  return label;
}

function addLine(scene) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(6), 3));
  const line = new THREE.Line(geometry,
    new THREE.LineBasicMaterial({ color: COLOUR, depthTest: false }));
  line.renderOrder = 1;
  line.frustumCulled = false;
  const ends = new THREE.Points(geometry,
    new THREE.PointsMaterial({
      color: COLOUR, size: 8, sizeAttenuation: false, depthTest: false,
    }));
  ends.frustumCulled = false;
  ends.renderOrder = 1;
  line.add(ends);
  scene.add(line);
  return line;
}
