// The keys of a scene file: what the page reads of them, what holds without them, and the lines that refuse them. Those of bodies,
// obstacles and links that the library has are its rows (thrum/fields.h); a test compares all of them with what the program reads.
// SPDX-License-Identifier: Apache-2.0
import { fieldsOf } from '../../javascript/src/fields.js';
import { INTEGRATORS, LINKS } from './engine.js';

const isNumber = (value) => typeof value === 'number' && Number.isFinite(value);
const isVector = (length, is = isNumber) => (value) => Array.isArray(value) && value.length === length && value.every(is);
const isAny = (names) => (value) => names.includes(value);
const isObject = (value) => typeof value === 'object' && value !== null && !Array.isArray(value);

const UPRIGHT = [1, 0, 0, 0];

/** Kinds of values: what is one, and how it is called. */
const number = { fits: isNumber, wants: 'a number' };
const above = { fits: (value) => isNumber(value) && value > 0, wants: 'a number above 0', exclusiveMinimum: 0 };
const positive = { fits: (value) => isNumber(value) && value >= 0, wants: 'a number of at least 0', minimum: 0 };
const share = { fits: (value) => isNumber(value) && value >= 0 && value <= 1, wants: 'a number from 0 to 1', minimum: 0, maximum: 1 };
const count = { fits: (value) => Number.isInteger(value) && value >= 1 && value <= 512, wants: 'a whole number from 1 to 512', minimum: 1,
  maximum: 512 };
const vector = { fits: isVector(3), wants: 'a list of three numbers' };
const sides = { fits: isVector(3, above.fits), wants: 'a list of three numbers above 0' };
const hasLength = (value) => isVector(3)(value) && Math.hypot(...value) > 0;
const text = { fits: (value) => typeof value === 'string', wants: 'a text' };
const texts = { fits: (value) => text.fits(value) || (Array.isArray(value) && value.every(text.fits)),
  wants: 'a text, or a list of texts' };
const flag = { fits: (value) => typeof value === 'boolean', wants: 'true or false' };
const list = { fits: Array.isArray, wants: 'a list' };
const object = { fits: isObject, wants: 'an object' };
const names = (of) => ({ fits: isAny(of), wants: of.join(', ').replace(/, ([^,]*)$/, ' or $1'), names: of });
const rotation = { fits: (value) => (isVector(4)(value) && Math.hypot(...value) > 0) || (hasLength(value?.axis) && isNumber(value.angle)),
  wants: '{"axis": [X, Y, Z], "angle": DEGREES} or a quaternion [W, X, Y, Z], not zero' };
const colour = { fits: (value) => /^#[0-9a-f]{6}$/i.test(value) || isVector(3, share.fits)(value),
  wants: '"#rrggbb", or [red, green, blue] from 0 to 1' };
const rows = { fits: (value) => Array.isArray(value) && value.length >= 2
    && value.every((row) => Array.isArray(row) && row.length >= 2 && row.length === value[0].length && row.every(isNumber)),
  wants: 'a list of two rows of numbers or more, all as long as the first' };
const damping = { fits: (value) => positive.fits(value) || (isVector(2, positive.fits)(value) && value[1] === 0),
  wants: 'a number of at least 0 that this page damps by; it leaves out damping that grows with stiffness' };
const integrator = names(Object.keys(INTEGRATORS));
const anything = { fits: () => true };

/** A key that may be left out, and what then holds. */
const may = (is, fallback) => ({ is, fallback });
const must = (is) => ({ is, needed: true });

/** A key that the program reads and the page does not. */
const left = { unread: true };

const solver = Object.fromEntries(['damping_form', 'split', 'safety', 'split_form', 'adaptive', 'fallback', 'frequency_matching', 'newmark',
  'solver', 'tolerance', 'iterations', 'untrained_flow'].map((key) => [key, left]));

/** Shapes of obstacles: what each needs and may have beside what all have. */
export const SHAPES = {
  plane: { needs: [], takes: ['normal', 'stiffness', 'damping'] },
  sphere: { needs: ['radius'], takes: ['inside', 'stiffness', 'damping'] },
  box: { needs: ['size'], takes: ['rotation', 'inside', 'path', 'stiffness', 'damping'] },
  cylinder: { needs: ['radius', 'height'], takes: ['rotation', 'path'] },
  capsule: { needs: ['radius', 'height'], takes: ['rotation', 'path'] },
  height_field: { needs: ['heights', 'spacing'], takes: ['rotation', 'path'] },
  mesh: { needs: ['file'], takes: ['scale', 'rotation', 'path'] },
};
const OF_ONE_SHAPE = [...new Set(Object.values(SHAPES).flatMap(({ needs, takes }) => [...needs, ...takes]))];

/** The value that words are, as of what holds without a key: `[0, 0, 0]`; undefined: they explain. */
function valueOf(words) {
  try {
    return JSON.parse(words);
  } catch {
    return undefined;
  }
}

/** The kind of a row of the library. */
function kindOf({ kind, width, least, most, above: over }) {
  if (kind === 'flag') return flag;
  if (kind === 'float') return colour;
  if (kind === 'int64') return count;
  if (width === 4) return rotation;
  if (width === 3) return vector;
  if (most === 1) return share;
  if (least === 0) return over ? above : positive;
  return number;
}

/** The rows of a record that are keys. @param {import('../../javascript/src/memory.js').Memory} memory */
const rowsOf = (memory, record) => Object.fromEntries(fieldsOf(memory, record).filter(({ key }) => key)
  .map((field) => [field.name, may(kindOf(field), field.width === 4 ? UPRIGHT : valueOf(field.otherwise))]));

const found = new WeakMap();

/** All keys, by where they stand. @param {import('../../javascript/src/memory.js').Memory} memory of an engine */
export function keysOf(memory) {
  if (!found.has(memory)) found.set(memory, makeKeys(memory));
  return found.get(memory);
}

const makeKeys = (memory) => ({
  scene: { bodies: must(list), title: may(text), dt: may(above, 0.003), gravity: may(vector, [0, 0, 0]), base_motion: may(texts, []),
    wind: may(object), collide: may(flag), collisions: may(object), obstacles: may(list), links: may(list),
    integrator: may(integrator, 'energy'), damping: may(damping, 0), eye: left, eye_velocity: left, ...solver,
    // of the program's runs and of editors, for which the page has no use
    time: may(anything), probes: may(anything), outputs: may(anything), $schema: may(anything) },
  bodies: { ...rowsOf(memory, 'body'), name: may(text), model: must(text), start: may(texts, []), integrator: may(integrator),
    damping: may(damping),
    // the page steps all coordinates where these would have a body step fewer
    error: may(anything), budget: may(anything),
    fix: left, order: left, surface: left, material: left, detail: left, loads: left, actuate: left, touch: left, ...solver },
  obstacles: { ...rowsOf(memory, 'obstacle'), name: may(text), shape: must(names(Object.keys(SHAPES))), height: may(positive),
    size: may(sides), file: left, scale: may(above, 1), heights: may(rows), spacing: may(above), rotation: may(rotation, UPRIGHT),
    path: may(list), colour: may(colour, '#808080') },
  'obstacles.path': { time: must(number), centre: must(vector), rotation: may(rotation, UPRIGHT) },
  links: { ...rowsOf(memory, 'link'), name: may(text), kind: must(names(Object.keys(LINKS))), body: must(text), at: may(text),
    other: may(text), other_at: may(text), path: may(list), file: left },
  'links.path': { time: must(number), place: must(vector) },
  wind: { ...rowsOf(memory, 'wind'), velocity: must(vector) },
  collisions: rowsOf(memory, 'pairs'),
});

/** What holds of an object whose keys were checked: its own values, and what they have without. @param {object} keys of keysOf
 * @param {string} where */
export function withFallbacks(keys, given, where) {
  const fallbacks = Object.entries(keys[where]).filter(([, { fallback }]) => fallback !== undefined);
  return { ...Object.fromEntries(fallbacks.map(([key, { fallback }]) => [key, fallback])), ...given };
}

const TOLD = 60; // letters of a value that a line shows
const told = (value) => JSON.stringify(value).replace(new RegExp(`^(.{${TOLD}}).+`), '$1...');

/** Refuses what is no such object. @param {object} keys of keysOf @param {string} where @param {string} at how messages call it, as those of the program
 * do: obstacles[0] @param {string[]} left gets the keys that the page does not read */
function checkKeys(keys, given, where, at, left) {
  const of = (key) => (at === '' ? key : `${at}.${key}`);
  if (!isObject(given)) throw new Error(`${at || 'a scene'} wants an object with its keys in { }`);
  for (const [key, value] of Object.entries(given)) {
    if (!Object.hasOwn(keys[where], key)) throw new Error(`${at || 'the file'} has no key "${key}"`);
    const { is, unread } = keys[where][key];
    if (unread) left.push(of(key));
    else if (!is.fits(value)) throw new Error(`${of(key)}: wants ${is.wants}, not ${told(value)}`);
  }
  const missing = Object.keys(keys[where]).find((key) => keys[where][key].needed && given[key] === undefined);
  if (missing) throw new Error(`${at && `${at}: `}the key "${missing}" is missing`);
}

/** Places over time come one after the other. */
function checkPath(keys, path, where, at, left) {
  path.forEach((point, n) => {
    checkKeys(keys, point, where, `${at}.path[${n}]`, left);
    if (n > 0 && !(point.time > path[n - 1].time))
      throw new Error(`${at}.path[${n}].time: must be after the ${path[n - 1].time} s before it`);
  });
}

/** Of what shapes a key is, as a text. A solid box has the law of bodies that touch, and may go along a path. */
function shapesOf(key) {
  if (key === 'stiffness' || key === 'damping') return 'plane, a sphere or a room';
  const of = Object.keys(SHAPES).filter((shape) => [...SHAPES[shape].needs, ...SHAPES[shape].takes].includes(key))
    .map((shape) => (shape === 'box' && key === 'path' ? 'box that is solid' : shape.replace('_', ' ')));
  return of.join(', ').replace(/, ([^,]*)$/, ' or $1');
}

function checkObstacle(keys, given, at, left) {
  checkKeys(keys, given, 'obstacles', at, left);
  const { needs, takes } = SHAPES[given.shape];
  const missing = needs.find((key) => given[key] === undefined);
  if (missing) throw new Error(`${at}: a ${given.shape} needs "${missing}"`);
  const notOfBox = given.inside ? ['path'] : ['stiffness', 'damping'];
  const has = [...needs, ...takes].filter((key) => given.shape !== 'box' || !notOfBox.includes(key));
  const other = OF_ONE_SHAPE.find((key) => given[key] !== undefined && !has.includes(key));
  if (other) throw new Error(`${at}.${other}: is of a ${shapesOf(other)}`);
  if (given.normal && !hasLength(given.normal)) throw new Error(`${at}.normal: has no length`);
  if (given.shape === 'cylinder' && !(given.height > 0)) throw new Error(`${at}.height: a cylinder needs a height above 0 m`);
  if (given.path && given.velocity) throw new Error(`${at}.velocity: is there already by the path`);
  checkPath(keys, given.path ?? [], 'obstacles.path', at, left);
}

function checkBody(keys, given, at, left) {
  checkKeys(keys, given, 'bodies', at, left);
  const ofFree = ['velocity', 'spin', 'coupled'].find((key) => !given.free && given[key] !== undefined);
  if (ofFree) throw new Error(`${at}.${ofFree}: is of a body that is free`);
}

const ofSpring = ({ kind }) => kind === 'spring';
const ofWorld = ({ other }) => other === undefined;

/** Keys of some links alone: which, and how those are called. */
const OF_LINKS = [...['stiffness', 'damping', 'length', 'other_place'].map((key) => [key, ofSpring, 'a spring']),
  ['axis', ({ kind }) => kind === 'hinge', 'a hinge'], ['other_at', (link) => !ofWorld(link), 'another body'],
  ['path', ofWorld, 'a link with the world']];

/** Links tie bodies that are there. @param {string[]} bodies their names */
function checkLink(keys, given, at, left, bodies) {
  checkKeys(keys, given, 'links', at, left);
  for (const key of ['body', 'other'])
    if (given[key] !== undefined && !bodies.includes(given[key])) throw new Error(`${at}.${key}: there is no body "${given[key]}"`);
  if (given.other === given.body) throw new Error(`${at}.other: is the same body; leave it out for the world`);
  if (given.at === undefined && given.place === undefined) throw new Error(`${at}: a link needs "at" or "place"`);
  const wrong = OF_LINKS.find(([key, fits]) => given[key] !== undefined && !fits(given));
  if (wrong) throw new Error(`${at}.${wrong[0]}: is of ${wrong[2]}`);
  if (given.axis && !hasLength(given.axis)) throw new Error(`${at}.axis: has no length`);
  if (given.kind === 'spring' && !given.stiffness && !given.damping) throw new Error(`${at}: a spring needs "stiffness" or "damping"`);
  checkPath(keys, given.path ?? [], 'links.path', at, left);
}

/** The name of a body. */
export const nameOf = ({ name }, n) => name ?? `body${n + 1}`;

/** Refuses a scene file that is wrong. @param {object} keys of keysOf @returns {string[]} the keys in it that the page does not read */
export function checkScene(keys, file) {
  const left = [];
  checkKeys(keys, file, 'scene', '', left);
  if (file.bodies.length === 0) throw new Error('bodies: a scene needs a body');
  file.bodies.forEach((body, n) => checkBody(keys, body, `bodies[${n}]`, left));
  const bodies = file.bodies.map(nameOf);
  const twice = bodies.findIndex((name, n) => bodies.indexOf(name) < n);
  if (twice >= 0) throw new Error(`bodies[${twice}].name: "${bodies[twice]}" is there twice`);
  for (const where of ['wind', 'collisions']) if (file[where]) checkKeys(keys, file[where], where, where, left);
  (file.obstacles ?? []).forEach((obstacle, n) => checkObstacle(keys, obstacle, `obstacles[${n}]`, left));
  (file.links ?? []).forEach((link, n) => checkLink(keys, link, `links[${n}]`, left, bodies));
  return left;
}
