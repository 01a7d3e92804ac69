// Displacements on the GPU: u_v = sum_i U_vi q_i, with U in one texture (a texel per vertex and
// mode) and q of every body in another (a row per body). Normals likewise, see smooth.js.
// SPDX-License-Identifier: Apache-2.0
import * as THREE from 'three';
import { COLOUR_OF } from './colours.js';

const WIDTH = 2048; // what every WebGL 2 has at least

/** The function displacement(), for vertex shaders. `source` is the vertex of the model. */
export const DISPLACEMENT = /* glsl */ `
  uniform highp sampler2D modes;
  uniform highp sampler2D coordinates;
  uniform int rank;
  uniform int row;
  vec3 alongModes(highp sampler2D texels, int place) {
    vec3 sum = vec3(0.0);
    int texel = place * rank;
    for (int i = 0; i < rank; i++, texel++) {
      float q = texelFetch(coordinates, ivec2(i, row), 0).r;
      sum += q * texelFetch(texels, ivec2(texel % ${WIDTH}, texel / ${WIDTH}), 0).xyz;
    }
    return sum;
  }
  vec3 displacement(int source) { return alongModes(modes, source); }`;

const POINT_SIZE = 'gl_PointSize = clamp(gl_PointSize, 1.0, 6.0);'; // [px]

/** A texture whose number `texel` has the three numbers of at(texel).
 * @param {number} texels @param {number} rows the most that this GPU takes
 * @param {(texel: number, axis: number) => number} at */
function vectorsTexture(texels, rows, at) {
  const height = Math.max(1, Math.ceil(texels / WIDTH));
  if (height > rows) throw new Error('this GPU has no room for so many vertices at this rank');
  const data = new Float32Array(4 * WIDTH * height);
  for (let n = 0; n < texels; n++)
    for (let axis = 0; axis < 3; axis++) data[4 * n + axis] = at(n, axis);
  const texture = new THREE.DataTexture(data, WIDTH, height, THREE.RGBAFormat, THREE.FloatType);
  texture.needsUpdate = true;
  return texture;
}

/** U: texel v rank + i holds the three axes of mode i at vertex v.
 * @param {import('./pack.js').Model} model @param {number} rows the most that this GPU takes */
export function modesTexture({ rank, vertex_count: vertices, arrays }, rows) {
  return vectorsTexture(vertices * rank, rows, (texel, axis) => {
    const mode = texel % rank;
    return arrays.basis[(3 * ((texel - mode) / rank) + axis) * rank + mode];
  });
}

/** dN: as U, of split vertices. @param {Float32Array} normalModes @param {number} rows */
export const normalsTexture = (normalModes, rows) =>
  vectorsTexture(normalModes.length / 3, rows, (texel, axis) => normalModes[3 * texel + axis]);

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
      .replace('#include <common>', `#include <common>\n${DISPLACEMENT}
        uniform highp sampler2D normalModes;
        attribute int source;
        attribute float value;
        varying float shown;`)
      .replace('#include <beginnormal_vertex>', `
        vec3 objectNormal = normalize(normal + alongModes(normalModes, gl_VertexID));`)
      .replace('#include <begin_vertex>', `
        shown = value;
        vec3 transformed = position + displacement(source);`)
      // of points alone: what is near has marks no larger than these pixels
      .replace('#include <logdepthbuf_vertex>', `${material.isPointsMaterial ? POINT_SIZE : ''}
        #include <logdepthbuf_vertex>`);
    shader.fragmentShader = shader.fragmentShader
      .replace('#include <common>', `#include <common>\n${TINT}`)
      .replace('#include <color_fragment>', 'tint(diffuseColor.rgb);');
  };
  material.customProgramCacheKey = () => `thrum ${material.isPointsMaterial ?? false}`;
}

// the value of each vertex by its share of the scale; scale 0: the body's own colour
const TINT = /* glsl */ `
  uniform float fullScale;
  varying float shown;
  ${COLOUR_OF}
  void tint(inout vec3 colour) {
    if (fullScale > 0.0) colour = colourOf(shown / fullScale);
  }`;
