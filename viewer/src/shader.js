// Displacements on the GPU: u_v = sum_i U_vi q_i, with U in one texture (a texel per vertex and
// mode) and q of every body in another (a row per body).
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';

const WIDTH = 2048; // what every WebGL 2 has at least

/** The function displacement(), for vertex shaders. */
export const DISPLACEMENT = /* glsl */ `
  uniform highp sampler2D modes;
  uniform highp sampler2D coordinates;
  uniform int rank;
  uniform int row;
  vec3 displacement() {
    vec3 u = vec3(0.0);
    int texel = gl_VertexID * rank;
    for (int i = 0; i < rank; i++, texel++) {
      float q = texelFetch(coordinates, ivec2(i, row), 0).r;
      u += q * texelFetch(modes, ivec2(texel % ${WIDTH}, texel / ${WIDTH}), 0).xyz;
    }
    return u;
  }`;

/** U as a texture of rows 3 v + axis by rank: texel v rank + i holds the three axes of mode i.
 * @param {import('./pack.js').Model} model @returns {THREE.DataTexture} */
export function modesTexture(model) {
  const { rank, vertex_count: vertices } = model;
  const basis = model.arrays.basis;
  const height = Math.max(1, Math.ceil((vertices * rank) / WIDTH));
  const texels = new Float32Array(4 * WIDTH * height);
  for (let v = 0; v < vertices; v++)
    for (let axis = 0; axis < 3; axis++)
      for (let i = 0; i < rank; i++)
        texels[4 * (v * rank + i) + axis] = basis[(3 * v + axis) * rank + i];
  const texture = new THREE.DataTexture(texels, WIDTH, height, THREE.RGBAFormat, THREE.FloatType);
  texture.needsUpdate = true;
  return texture;
}

/** q of all bodies; `texture.image.data` is filled row by row and uploaded once a frame.
 * @param {number} width the largest rank @param {number} rows @returns {THREE.DataTexture} */
export function coordinatesTexture(width, rows) {
  const data = new Float32Array(width * rows);
  return new THREE.DataTexture(data, width, rows, THREE.RedFormat, THREE.FloatType);
}

/** Makes a material of three.js displace its vertices.
 * @param {THREE.Material} material @param {Object<string, {value: *}>} uniforms */
export function displace(material, uniforms) {
  material.onBeforeCompile = (shader) => {
    Object.assign(shader.uniforms, uniforms);
    shader.vertexShader = shader.vertexShader
      .replace('#include <common>', `#include <common>\n${DISPLACEMENT}\nvarying float moved;`)
      .replace('#include <begin_vertex>', `
        vec3 shift = displacement();
        moved = length(shift);
        vec3 transformed = position + shift;`);
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', `#include <common>\n${TINT}`)
      .replace('#include <color_fragment>', 'tint(diffuseColor.rgb);');
  };
  material.customProgramCacheKey = () => 'thrum';
}

// from the body's colour through yellow to red, where the displacement reaches its full scale
const TINT = /* glsl */ `
  uniform float fullScale;
  varying float moved;
  void tint(inout vec3 colour) {
    if (fullScale <= 0.0) return;
    float s = clamp(moved / fullScale, 0.0, 1.0);
    vec3 hot = mix(vec3(0.95, 0.70, 0.10), vec3(0.75, 0.05, 0.03), smoothstep(0.5, 1.0, s));
    colour = mix(colour, hot, smoothstep(0.0, 0.5, s));
  }`;
