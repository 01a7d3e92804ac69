// A scene file that is dropped with the models that it names (.npz): the pack that `thrum view` would make of it. What
// links and coupled bodies take of whole meshes is taken from those files here. The page reads the keys below;
// a scene that says more is refused with the command that shows it. SPDX-License-Identifier: Apache-2.0
import { INTEGRATORS, LINKS } from './engine.js';
import { readModelFile } from './model_file.js';

const DEGREE = Math.PI / 180;
const ROOM = { each: 1024, first: 64, beyond: 128 }; // for touches, a body: of the first so many, and of those beyond

const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);
const isVector = (length) => (value) => Array.isArray(value) && value.length === length && value.every(isNumber);
const isOneOf = (names) => (value) => names.includes(value);

/** Kinds of values: what is one, and how it is called. */
const number = [isNumber, 'a number'];
const vector = [isVector(3), 'a list of three numbers'];
const text = [(value) => typeof value === 'string', 'a text'];
const flag = [(value) => typeof value === 'boolean', 'true or false'];
const list = [Array.isArray, 'a list'];
const object = [(value) => typeof value === 'object' && value !== null && !Array.isArray(value), 'an object'];
const rotation = [(value) => isVector(4)(value) || (isVector(3)(value?.axis) && isNumber(value.angle)),
  '{"axis": [X, Y, Z], "angle": DEGREES} or a quaternion [W, X, Y, Z]'];
const colour = [(value) => /^#[0-9a-f]{6}$/i.test(value) || isVector(3)(value), '"#rrggbb" or a list of three numbers'];
const integrator = [isOneOf(Object.keys(INTEGRATORS)), 'an integrator'];
const anything = [() => true, ''];

/** Keys that are read, by where they stand. */
const KEYS = {
  scene: { title: text, dt: number, gravity: vector, wind: object, collide: flag, collisions: object, integrator,
    damping: number, bodies: list, obstacles: list, links: list,
    // of the program's runs, for which the page has no use
    time: anything, probes: anything, outputs: anything },
  bodies: { name: text, model: text, position: vector, rotation, scale: number, stiffness: number, density: number,
    rank: number, condense: number, colour, free: flag, velocity: vector, spin: vector, coupled: flag, collide: flag,
    self_contact: flag, integrator, damping: number },
  obstacles: { name: text, shape: [isOneOf(['plane', 'sphere', 'box']), 'a plane, sphere or box'], centre: vector,
    normal: vector, radius: number, size: vector, rotation, inside: flag, velocity: vector, friction: number,
    restitution: number, stiffness: number, damping: number, colour },
  links: { name: text, kind: [isOneOf(Object.keys(LINKS)), 'spring, ball, hinge or weld'], body: text, at: text,
    place: vector, other: text, other_at: text, other_place: vector, axis: vector, stiffness: number, damping: number,
    length: number, path: list, until: number },
  path: { time: number, place: vector },
  wind: { velocity: vector, density: number, drag: number },
  collisions: { thickness: number, friction: number, restitution: number },
};
const MUST = { scene: ['bodies'], bodies: ['model'], obstacles: ['shape'], links: ['kind', 'body'], path: ['time', 'place'],
  wind: ['velocity'], collisions: [] };

/** Refuses what is no such object, and keys that the page does not read. @param {keyof KEYS} where */
function check(given, where) {
  if (!object[0](given)) throw new Error(`"${where}": an object with its keys in { } is needed`);
  for (const [key, value] of Object.entries(given)) {
    if (!Object.hasOwn(KEYS[where], key)) throw new Error(`this page does not read the key "${key}" of ${where}`);
    const [fits, what] = KEYS[where][key];
    if (!fits(value)) throw new Error(`"${key}" of ${where} is not ${what} that this page reads`);
  }
  const missing = MUST[where].find((key) => given[key] === undefined);
  if (missing) throw new Error(`"${missing}" of ${where} is missing`);
}

/** A rotation as a quaternion of length 1. */
function quaternionOf(given = [1, 0, 0, 0]) {
  let turned = given;
  if (given.axis) {
    const half = (DEGREE * given.angle) / 2;
    const along = Math.sin(half) / Math.hypot(...given.axis);
    turned = [Math.cos(half), ...given.axis.map((x) => x * along)];
  }
  const length = Math.hypot(...turned);
  return turned.map((x) => x / length);
}

function colourOf(given, grey) {
  if (given === undefined) return grey;
  if (typeof given === 'string') return given;
  const part = (x) => Math.round(255 * Math.min(Math.max(x, 0), 1)).toString(16).padStart(2, '0');
  return `#${given.map(part).join('')}`;
}

/** The models that bodies name: from the files that came along, or of the page as it is.
 * @returns {{models: object[], files: (Uint8Array|undefined)[], of: number[]}} of: each body's model */
function findModels(bodies, files, shown, engine) {
  const models = [];
  const found = [];
  const names = [];
  const of = bodies.map(({ model }) => {
    if (names.includes(model)) return names.indexOf(model);
    const base = model.replace(/^.*[/\\]/, '');
    const file = files.get(base);
    const known = shown.find(({ name, title }) => [model, base].includes(name) || title === model);
    if (!file && !known)
      throw new Error(/\.npz$/i.test(base) ? `drop ${base} with it` : `its body of "${model}" has to be meshed and precomputed first`);
    models.push(file ? readModelFile(engine, file, base) : known);
    found.push(file);
    return names.push(model) - 1;
  });
  return { models, files: found, of };
}

function bodyOf(given, n, models, of, scene, collide) {
  const { rank, masters } = models[of[n]];
  if (masters && given.rank !== undefined && given.rank !== rank)
    throw new Error(`"rank": coordinates of ${given.model} follow others and cannot be left out; give "condense" of 1 to ${masters}`);
  return { name: given.name ?? `body${n + 1}`, model: of[n], position: given.position ?? [0, 0, 0],
    rotation: quaternionOf(given.rotation), scale: given.scale ?? 1, stiffness: given.stiffness ?? 1,
    density: given.density ?? 1, rank: given.condense ?? given.rank ?? rank, condense: given.condense ?? 0,
    colour: colourOf(given.colour, '#bfbfbf'), free: given.free ?? false, coupled: given.coupled ?? false,
    collide: collide && (given.collide ?? true), self_contact: given.self_contact ?? false,
    velocity: given.velocity ?? [0, 0, 0], spin: (given.spin ?? [0, 0, 0]).map((x) => DEGREE * x),
    integrator: given.integrator ?? scene.integrator, damping: given.damping ?? scene.damping, loads: [] };
}

function obstacleOf({ shape, ...given }) {
  return { centre: [0, 0, 0], inside: false, velocity: [0, 0, 0], friction: 0.5, restitution: 0.5, stiffness: 0, damping: 0,
    ...given, kind: shape, ...(given.rotation && { rotation: quaternionOf(given.rotation) }),
    colour: colourOf(given.colour, '#808080') };
}

/** The scene of the file, but for its links. */
function sceneOf(file, models, of) {
  const { bodies, gravity = [0, 0, 0], dt = 0.003, integrator: by = 'energy', damping = 0 } = file;
  const collide = file.collide ?? bodies.some(({ free }) => free);
  const scene = { title: file.title, dt, integrator: by, gravity, damping, base_motion: [],
    obstacles: (file.obstacles ?? []).map(obstacleOf) };
  scene.bodies = bodies.map((body, n) => bodyOf(body, n, models, of, scene, collide));
  if (file.wind) scene.wind = { density: 1.2, drag: 1, ...file.wind };
  if ((collide && bodies.length > 1) || bodies.some((body) => body.self_contact)) {
    const first = Math.min(bodies.length, ROOM.first);
    scene.collisions = { thickness: 0, friction: 0.5, restitution: 0.5, ...file.collisions,
      touches: ROOM.each * first + ROOM.beyond * (bodies.length - first) };
  }
  return scene;
}

/** Links of the whole meshes that came along. @param {import('./engine.js').Engine} whole with the scene, of whole meshes */
function linksOf(given, scene, files, whole) {
  const bodyNumber = (name) => {
    const n = scene.bodies.findIndex((body) => body.name === name);
    if (n < 0) throw new Error(`a link names "${name}", and no body is called so`);
    if (!files[scene.bodies[n].model])
      throw new Error(`the page has only the surface of "${name}", which is linked: drop its model with it`);
    return n;
  };
  return given.map((link) => {
    const { kind, path = [], until, stiffness = 0, damping = 0, name } = link;
    path.forEach((place) => check(place, 'path'));
    const body = bodyNumber(link.body);
    const other = link.other === undefined ? undefined : bodyNumber(link.other);
    const made = whole.weighLink({ kind, body, other, vertices: targetOf(link.at, scene.bodies[body], whole),
      other_vertices: other === undefined ? undefined : targetOf(link.other_at, scene.bodies[other], whole),
      place: link.place, other_place: link.other_place, axis: link.axis, stiffness, length: link.length });
    return { name, kind, body, ...(other !== undefined && { other }), ...made, stiffness, damping, until,
      ...(path.length > 0 && { times: path.map(({ time }) => time), places: path.flatMap(({ place }) => place) }) };
  });
}

/** The vertices that a link is `at`: a group, vertex=N from 1, or all. */
function targetOf(at, { model }, whole) {
  if (at === undefined) return undefined;
  const one = /^vertex=(\d+)$/.exec(at);
  if (one) return [Number(one[1]) - 1];
  return at === 'all' ? whole.allVertices(model) : whole.group(model, at);
}

/** @param {{name: string, bytes: Uint8Array}} file the scene @param {Map<string, Uint8Array>} files models that came along,
 * by their names @param {import('./pack.js').Pack} shown the page as it is @param {import('./engine.js').Engine} engine
 * without models @returns {Promise<import('./pack.js').Pack>} */
export async function packOfScene({ name, bytes }, files, shown, engine) {
  try {
    const file = JSON.parse(new TextDecoder().decode(bytes));
    check(file, 'scene');
    for (const where of ['bodies', 'obstacles', 'links']) (file[where] ?? []).forEach((part) => check(part, where));
    if (file.bodies.length === 0) throw new Error('"bodies" is empty');
    for (const where of ['wind', 'collisions']) if (file[where]) check(file[where], where);
    const { models, files: found, of } = findModels(file.bodies, files, shown.models, engine);
    const scene = sceneOf(file, models, of);

    // what links and coupled bodies need is made in an engine that has the whole meshes
    const whole = await engine.another();
    models.forEach((model, n) => (found[n] ? whole.addWholeModel(found[n]) : whole.addModel(model)));
    const coupled = scene.bodies.filter((body) => body.coupled).map(({ model }) => model);
    const without = coupled.find((model) => !found[model]);
    if (without !== undefined)
      throw new Error(`the page has only the surface of "${models[without].name}", whose spin and shape are coupled: drop its model with it`);
    // bodies of whole meshes have no surface, and need none
    const bodies = scene.bodies.map((body) => ({ ...body, self_contact: false }));
    whole.build({ ...scene, bodies, collisions: undefined, obstacles: [], wind: undefined });
    scene.links = linksOf(file.links ?? [], scene, found, whole);
    return { scene, models: models.map((model, n) => (coupled.includes(n)
      ? { ...model, arrays: { ...model.arrays, inertia: whole.inertia(n) } } : model)) };
  } catch (error) {
    throw new Error(`${name}: ${error.message}. The program shows it with all that it names: thrum view ${name}`);
  }
}
