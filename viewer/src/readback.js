// What the vertex shader makes of q, read back from the GPU: for tests of displacement().
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';
import { DISPLACEMENT } from './shader.js';

const WIDTH = 256;

/** Displaced positions of a body in its own frame, vertex_count x 4 floats, the last one unused.
 * @param {THREE.WebGLRenderer} renderer @param {import('./body.js').Body} body */
export function displacedPositions(renderer, body) {
  const count = body.model.vertex_count;
  const height = Math.ceil(count / WIDTH);
  const target = new THREE.WebGLRenderTarget(WIDTH, height, {
    type: THREE.FloatType, format: THREE.RGBAFormat, depthBuffer: false,
    minFilter: THREE.NearestFilter, magFilter: THREE.NearestFilter,
  });
  const material = new THREE.RawShaderMaterial({
    glslVersion: THREE.GLSL3,
    uniforms: body.uniforms,
    vertexShader: `precision highp float; precision highp int;
      in vec3 position; out vec3 displaced;
      ${DISPLACEMENT}
      void main() {
        displaced = position + displacement(gl_VertexID);
        vec2 pixel = vec2(gl_VertexID % ${WIDTH}, gl_VertexID / ${WIDTH}) + 0.5;
        gl_Position = vec4(2.0 * pixel / vec2(${WIDTH}.0, ${height}.0) - 1.0, 0.0, 1.0);
        gl_PointSize = 1.0;
      }`,
    fragmentShader: `precision highp float;
      in vec3 displaced; out vec4 texel;
      void main() { texel = vec4(displaced, 1.0); }`,
  });
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(body.model.arrays.positions, 3));
  const points = new THREE.Points(geometry, material);
  points.frustumCulled = false;
  const scene = new THREE.Scene();
  scene.add(points);
  const before = renderer.getRenderTarget();
  renderer.setRenderTarget(target);
  renderer.render(scene, new THREE.Camera());
  const texels = new Float32Array(4 * WIDTH * height);
  renderer.readRenderTargetPixels(target, 0, 0, WIDTH, height, texels);
  renderer.setRenderTarget(before);
  geometry.dispose();
  material.dispose();
  target.dispose();
  return texels.subarray(0, 4 * count);
}
