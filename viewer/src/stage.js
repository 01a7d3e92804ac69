// Camera, light, ground and obstacles: all of the picture but the bodies. z is up.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';
import { drawsInSoftware } from './quality.js';

const MARGIN = 1.35; // around the bodies: they move
const UP = new THREE.Vector3(0, 0, 1);

export class Stage {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: !drawsInSoftware() });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.pixel = new Uint8Array(4);
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color();
    this.scene.fog = new THREE.Fog(0);
    this.groundColour = new THREE.Color(); // shared by all grounds
    this.heldColour = new THREE.Color(); // and by the marks of what is held
    this.camera = new THREE.PerspectiveCamera(40, 1, 0.01, 1000);
    this.camera.up.copy(UP);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.addEventListener('change', () => this.touch());
    this.version = 0;
    this.sun = new THREE.DirectionalLight(0xffffff, 1.9);
    this.sun.castShadow = true;
    this.sun.shadow.mapSize.set(1024, 1024);
    this.sun.shadow.bias = -0.001;
    this.scene.add(this.sun, this.sun.target, new THREE.HemisphereLight(0xffffff, 0xaab6c2, 1.9));
    this.props = new THREE.Group(); // ground and obstacles
    this.scene.add(this.props);
  }

  /** Takes the colours of a theme. @param {{background: number, ground: number}} theme */
  paint({ background, ground: colour, held }) {
    this.scene.background.set(background);
    this.scene.fog.color.set(background);
    this.groundColour.set(colour);
    this.heldColour.set(held);
    this.touch();
  }

  /** Fits the drawing to the window, with room for what lies over it.
   * @param {{top: number, right: number, bottom: number}} room [px] */
  fit(room) {
    const { clientWidth: width, clientHeight: height } = this.renderer.domElement;
    this.room = room;
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.touch();
    this.camera.setViewOffset(width, height, room.right / 2, (room.bottom - room.top) / 2,
      width, height);
    this.#keepWhole();
  }

  // what was seen whole before a window or a phone was turned still is
  #keepWhole() {
    if (!this.bounds) return;
    const before = this.distance;
    this.distance = this.#distanceTo(this.bounds);
    const { camera, controls: { target } } = this;
    camera.position.sub(target).multiplyScalar(this.distance / before).add(target);
    this.controls.update();
  }

  // from where the camera sees the bounds whole, beside what lies over the picture
  #distanceTo(bounds) {
    const { clientWidth: width, clientHeight: height } = this.renderer.domElement;
    const { top, right, bottom } = this.room;
    const size = bounds.getSize(new THREE.Vector3());
    const half = Math.tan((this.camera.fov * Math.PI) / 360); // of the height, at distance 1
    const extent = Math.max((size.z + 0.4 * size.y) / (1 - (top + bottom) / height),
      (0.95 * size.x + 0.35 * size.y) / ((width - right) / height));
    return (MARGIN * extent) / (2 * half) + 0.5 * size.y;
  }

  /** Ground and obstacles of a scene whose bodies lie in `bounds`.
   * @param {object[]} obstacles as in the pack @param {THREE.Box3} bounds
   * @param {number} floor its height, where no obstacle is a plane */
  furnish(obstacles, bounds, floor) {
    this.props.clear();
    this.touch();
    const size = bounds.getSize(new THREE.Vector3()).length();
    for (const obstacle of obstacles)
      this.props.add(shapeOfObstacle(obstacle, size, this.groundColour));
    if (!obstacles.some(({ kind }) => kind === 'plane'))
      this.props.add(ground(new THREE.Vector3(0, 0, floor), UP, size, this.groundColour));
    this.#light(bounds, size);
  }

  /** @param {number} number of the scene's obstacle @param {number[]} centre */
  moveObstacle(number, centre) {
    this.props.children[number].position.fromArray(centre);
  }

  /** @param {number} number of the scene's obstacle @param {number[]} matrix 4 x 4 by columns */
  placeObstacle(number, matrix) {
    const mesh = this.props.children[number];
    mesh.matrix.fromArray(matrix).decompose(mesh.position, mesh.quaternion, mesh.scale);
  }

  #light(bounds, size) {
    const centre = bounds.getCenter(new THREE.Vector3());
    this.sun.target.position.copy(centre);
    this.sun.position.copy(centre).add(new THREE.Vector3(0.5, -0.7, 1.3).multiplyScalar(size));
    const box = this.sun.shadow.camera;
    box.left = box.bottom = -size;
    box.right = box.top = size;
    box.near = 0.1 * size;
    box.far = 4 * size;
    box.updateProjectionMatrix();
  }

  /** Turns the camera to where it sees the bounds whole. @param {THREE.Box3} bounds */
  look(bounds) {
    const centre = bounds.getCenter(new THREE.Vector3());
    const distance = this.#distanceTo(bounds);
    Object.assign(this, { bounds, distance });
    this.controls.target.copy(centre);
    this.camera.position.copy(centre)
      .add(new THREE.Vector3(0.3, -0.88, 0.34).normalize().multiplyScalar(distance));
    this.camera.near = distance / 200;
    this.camera.far = distance * 50;
    this.camera.updateProjectionMatrix();
    Object.assign(this.scene.fog, { near: 1.5 * distance, far: 5 * distance });
    this.controls.update();
  }

  /** Something of the picture has changed, so that it is to be drawn again. */
  touch() {
    this.version++;
  }

  /** Draws as finely as a level says. @param {{ratio: number, shadows: boolean}} level */
  refine({ ratio, shadows }) {
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, ratio));
    this.sun.castShadow = shadows;
    this.touch();
  }

  /** Waits until everything is drawn: a pixel that is read is there. */
  finish() {
    const gl = this.renderer.getContext();
    gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, this.pixel);
  }

  draw() {
    this.renderer.render(this.scene, this.camera);
  }

  /** The ray under a place of the page. @returns {THREE.Ray} */
  ray(clientX, clientY) {
    const box = this.renderer.domElement.getBoundingClientRect();
    const at = new THREE.Vector2(((clientX - box.left) / box.width) * 2 - 1,
      1 - ((clientY - box.top) / box.height) * 2);
    const caster = new THREE.Raycaster();
    caster.setFromCamera(at, this.camera);
    return caster.ray;
  }

  /** Where on the page a point of the world is. @param {number[]} point */
  project(point) {
    const box = this.renderer.domElement.getBoundingClientRect();
    const seen = new THREE.Vector3(...point).project(this.camera);
    return {
      x: box.left + ((seen.x + 1) / 2) * box.width,
      y: box.top + ((1 - seen.y) / 2) * box.height,
    };
  }
}

/** A plane with lines every `cell` metres, facing along `normal`. */
function ground(point, normal, size, colour) {
  const cell = 10 ** Math.round(Math.log10(size / 4));
  const material = new THREE.MeshLambertMaterial();
  material.color = colour;
  material.onBeforeCompile = (shader) => {
    shader.uniforms.cell = { value: cell };
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', '#include <common>\nvarying vec2 place;')
      .replace('#include <begin_vertex>', '#include <begin_vertex>\nplace = position.xy;');
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', `#include <common>\n${GRID}`)
      .replace('#include <color_fragment>', 'drawGrid(diffuseColor.rgb);');
  };
  const floor = new THREE.Mesh(new THREE.PlaneGeometry(80 * size, 80 * size), material);
  floor.receiveShadow = true;
  floor.position.copy(point);
  floor.quaternion.setFromUnitVectors(UP, normal);
  return floor;
}

// lines one pixel wide, which fade where they would be closer than a few pixels
const GRID = /* glsl */ `
  uniform float cell;
  varying vec2 place;
  void drawGrid(inout vec3 colour) {
    vec2 at = place / cell;
    vec2 wide = fwidth(at);
    vec2 away = abs(fract(at - 0.5) - 0.5) / wide;
    float line = 1.0 - min(min(away.x, away.y), 1.0);
    line *= 1.0 - smoothstep(0.05, 0.4, max(wide.x, wide.y));
    colour = mix(colour, vec3(0.45, 0.55, 0.65), 0.55 * max(0.3, colour.g) * line); // faint on dark ground
  }`;

/** @param {object} obstacle of the pack, no plane */
function geometryOfObstacle({ kind, radius, size, vertices, triangles }) {
  if (kind === 'sphere') return new THREE.SphereGeometry(radius, 48, 32);
  if (kind === 'box') return new THREE.BoxGeometry(...size);
  const shared = new THREE.BufferGeometry();
  shared.setAttribute('position', new THREE.Float32BufferAttribute(vertices, 3));
  shared.setIndex(triangles);
  const geometry = shared.toNonIndexed(); // each face has its own normal
  geometry.computeVertexNormals();
  return geometry;
}

/** @param {object} obstacle of the pack */
function shapeOfObstacle(obstacle, size, groundColour) {
  const vector = (v) => new THREE.Vector3(...v);
  if (obstacle.kind === 'plane')
    return ground(vector(obstacle.centre), vector(obstacle.normal).normalize(), size, groundColour);
  const geometry = geometryOfObstacle(obstacle);
  // one looks into a room through its near walls
  const mesh = new THREE.Mesh(geometry, new THREE.MeshStandardMaterial({
    color: obstacle.colour ?? 0x9fb0c0, roughness: 0.8,
    side: obstacle.inside ? THREE.BackSide
      : obstacle.kind === 'solid' ? THREE.DoubleSide : THREE.FrontSide,
  }));
  mesh.position.copy(vector(obstacle.centre));
  if (obstacle.rotation) {
    // three.js has w last
    const [w, x, y, z] = obstacle.rotation;
    mesh.quaternion.set(x, y, z, w);
  }
  mesh.castShadow = !obstacle.inside;
  mesh.receiveShadow = true;
  return mesh;
}
