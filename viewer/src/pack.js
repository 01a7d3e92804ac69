// The pack: one scene and the models it needs, as docs/viewer.md lays it out.
// SPDX-License-Identifier: Apache-2.0
import { LINKS } from './engine.js';

/**
 * @typedef {object} Model
 * @property {string} name
 * @property {string} title
 * @property {number} rank
 * @property {number} [masters] the first coordinates, which are stepped, where the others follow
 * @property {number} vertex_count shown vertices
 * @property {number} triangle_count
 * @property {number} mass [kg]
 * @property {Object<string, ArrayBufferView>} arrays
 */

/** `recording`: of a finished run, one for each body of the scene; `recordedLinks`: what ties them, row by row; `curve`: the
 * periodic motions of its one body.
 * @typedef {{scene: object, models: Model[], recording?: object[], recordedLinks?: object, curve?: object}} Pack */

/** Numbers of a recorded link in a row: 1 while it holds or 0, how far it is open [m], and its two places [m]. */
export const LINK_NUMBERS = 8;

const MAGIC = 'THRUMPK1';
const HEADER_BYTES = 16;
const TYPES = { f8: Float64Array, f4: Float32Array, i4: Int32Array, u1: Uint8Array };

/** @param {string} text base64 @returns {Uint8Array} */
export function bytesOfBase64(text) {
  const binary = atob(text);
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

/** Inflates what gzip made. @param {Uint8Array} bytes @returns {Promise<Uint8Array>} */
async function inflate(bytes) {
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The bytes inside an element of the page, or null when it is empty.
 * @param {HTMLElement} element @returns {Promise<Uint8Array|null>} */
export async function bytesOfElement(element) {
  const text = element.textContent.trim();
  if (text === '') return null;
  const bytes = bytesOfBase64(text);
  return element.dataset.encoding === 'gzip' ? inflate(bytes) : bytes;
}

/** The pack in the text of a page that `thrum view` wrote. @param {string} text @returns {Promise<Uint8Array>} */
export async function packOfPage(text) {
  const element = new DOMParser().parseFromString(text, 'text/html').getElementById('thrum-pack');
  const bytes = element && await bytesOfElement(element);
  if (!bytes) throw new Error('this page has no models: is it one that thrum view wrote?');
  return bytes;
}

/** @param {ArrayBuffer} data @param {number} start @param {[number, number, string]} entry */
function arrayAt(data, start, [offset, count, type]) {
  const Type = TYPES[type];
  if (!Type) throw new Error(`the pack holds an array of unknown type '${type}'`);
  const end = start + offset + count * Type.BYTES_PER_ELEMENT;
  if (offset < 0 || count < 0 || offset % 8 !== 0 || end > data.byteLength)
    throw new Error('the pack ends inside an array; write it again with thrum view');
  return new Type(data, start + offset, count);
}

/** The most coordinates of a model that can be stepped. @param {Model} model */
export const mostStepped = (model) => model.masters || model.rank;

/** How few: the others follow, which those of a model with cubature points cannot. @param {Model} model */
export const fewestStepped = (model) => (model.arrays.point_weights?.length ? model.rank : 1);

const cubicCount = (r) => (r * (r + 1) * (r + 2)) / 6;
const quarticCount = (r) => (cubicCount(r) * (r + 3)) / 4;

/** Entries of the energy's arrays. @param {Model} model */
function energyCounts({ rank: r, masters: k, arrays }) {
  const points = arrays.point_weights?.length;
  if (k) return { slave_map: ((r - k) * k * (k + 1)) / 2, condensed_c3: cubicCount(k), condensed_c4: quarticCount(k) };
  return points ? { point_moduli: 2 * points, point_gradients: 9 * points * r }
    : { c3: cubicCount(r), c4: quarticCount(r) };
}

/** Laws of materials at cubature points, as in a model file: each name is ended by one 0. */
const LAWS = ['stvk\0', 'corotational\0', 'neo-hookean\0'];

/** Refuses arrays that do not fit together. @param {Model} model */
function check(model) {
  const { rank: r, vertex_count: vertices, triangle_count: triangles, arrays } = model;
  if (model.masters && !(model.masters < r))
    throw new Error(`model '${model.name}': nothing follows ${model.masters} of ${r} coordinates`);
  const counts = {
    omega2: r,
    ...energyCounts(model),
    axis_mass: 3 * r, positions: 3 * vertices, basis: 3 * vertices * r, triangles: 3 * triangles,
    fixed: vertices,
    ...(arrays.tet && { tet: 12, tet_rigid: 72 }),
    ...(arrays.region_law && { point_region: arrays.point_weights?.length ?? 0 }),
    ...(arrays.follows && { follows: vertices }),
    ...(arrays.inertia && { inertia: 9 + 9 * r * (r + 1) }),
  };
  for (const [name, count] of Object.entries(counts))
    if (arrays[name]?.length !== count)
      throw new Error(`model '${model.name}': array '${name}' has not ${count} entries`);
  if (arrays.point_law && !LAWS.includes(String.fromCharCode(...arrays.point_law)))
    throw new Error(`model '${model.name}': array 'point_law' names no law that is known`);
  for (const [name, Type] of [['point_region', Int32Array], ['region_law', Uint8Array]])
    if (arrays[name] && !(arrays[name] instanceof Type))
      throw new Error(`model '${model.name}': array '${name}' is of another type`);
  if (arrays.region_law?.some((law) => law >= LAWS.length))
    throw new Error(`model '${model.name}': array 'region_law' names no law that is known`);
  if (arrays.point_region?.some((region) => !(region >= 0 && region < (arrays.region_law?.length ?? 0))))
    throw new Error(`model '${model.name}': array 'point_region' names a region that is not there`);
  if (arrays.triangles.some((vertex) => vertex < 0 || vertex >= vertices))
    throw new Error(`model '${model.name}': a triangle names a vertex that is not there`);
}

/** Refuses a recording whose arrays do not fit together. @param {object} rows of a body
 * @param {number} count of rows */
function checkRows({ rank, arrays }, count) {
  const counts = { times: count, energies: 2 * count, q: rank * count,
    ...(arrays.places && { places: 7 * count }) };
  for (const [name, entries] of Object.entries(counts))
    if (count < 1 || arrays[name]?.length !== entries)
      throw new Error(`the recording: array '${name}' has not ${entries} entries`);
}

/** Refuses a link whose kind is not known or whose numbers do not go together. @param {object} link
 * @param {number} n of it */
function checkLink(link, n) {
  const { kind, times = [], places = [], rows, other_rows: otherRows } = link;
  if (!Object.hasOwn(LINKS, kind)) throw new Error(`link ${n + 1}: '${kind}' is no kind of link`);
  const counts = { place: 3, other_place: 3, rest: 12, other_rest: 12 };
  for (const [name, count] of Object.entries(counts))
    if (link[name]?.length !== count) throw new Error(`link ${n + 1}: '${name}' has not ${count} numbers`);
  if (places.length !== 3 * times.length || [rows, otherRows].some((list) => list && list.length % 12 !== 0))
    throw new Error(`link ${n + 1}: its path has three numbers a time, and its rows twelve a coordinate`);
}

/** Refuses recorded links of unknown kinds, or whose rows are not those of the recording.
 * @param {{links: object[], arrays: object}} recorded @param {number} count of rows */
function checkRecordedLinks({ links, arrays }, count) {
  const wrong = links.find(({ kind }) => !Object.hasOwn(LINKS, kind));
  if (wrong) throw new Error(`the recording: '${wrong.kind}' is no kind of link`);
  if (arrays.links?.length !== count * links.length * LINK_NUMBERS)
    throw new Error(`the recording: array 'links' has not ${count * links.length * LINK_NUMBERS} entries`);
}

/** Refuses a curve whose arrays do not fit together. @param {object} curve @param {Model} model that moves */
function checkCurve({ harmonics, kinds, arrays }, { rank }) {
  const rows = arrays.frequency?.length ?? 0;
  const counts = { frequency: rows, peak: rows, unstable: rows, kind: rows, motion: rows * (2 * harmonics + 1) * rank };
  for (const [name, count] of Object.entries(counts))
    if (rows < 1 || arrays[name]?.length !== count) throw new Error(`the curve: array '${name}' has not ${count} entries`);
  if (arrays.kind.some((kind) => !(kind in kinds))) throw new Error('the curve: a point is of no kind that is known');
}

/** @param {Uint8Array} bytes @returns {Pack} */
export function readPack(bytes) {
  const data = new Uint8Array(bytes).buffer; // a copy, aligned whatever it was cut from
  const magic = String.fromCharCode(...new Uint8Array(data, 0, Math.min(8, data.byteLength)));
  if (magic !== MAGIC || data.byteLength < HEADER_BYTES)
    throw new Error('this is no pack of thrum view');
  const length = new DataView(data).getUint32(8, true);
  const start = HEADER_BYTES + length;
  if (start > data.byteLength) throw new Error('the pack ends inside its header');
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, HEADER_BYTES, length)));
  if (header.format !== 1)
    throw new Error(`the pack has format ${header.format}, this page reads 1`);
  const withArrays = (from) => ({
    ...from,
    arrays: Object.fromEntries(
      Object.entries(from.arrays).map(([name, entry]) => [name, arrayAt(data, start, entry)])),
  });
  const models = header.models.map(withArrays);
  models.forEach(check);
  header.scene.links?.forEach(checkLink);
  const recording = header.recording?.map(withArrays);
  recording?.forEach((rows) => checkRows(rows, recording[0].arrays.times.length));
  const recordedLinks = header.recorded_links && withArrays(header.recorded_links);
  if (recordedLinks) checkRecordedLinks(recordedLinks, recording?.[0]?.arrays.times.length ?? 0);
  const curve = header.curve && withArrays(header.curve);
  if (curve) checkCurve(curve, models[header.scene.bodies[0].model]);
  return { scene: header.scene, models, recording, recordedLinks, curve };
}

/** The pack in the page, or the one served beside it. @returns {Promise<Pack>} */
export async function loadPack() {
  const inside = await bytesOfElement(document.getElementById('thrum-pack'));
  if (inside) return readPack(inside);
  const answer = await fetch('pack');
  if (!answer.ok) throw new Error(`the server has no pack: ${answer.status}`);
  return readPack(new Uint8Array(await answer.arrayBuffer()));
}
