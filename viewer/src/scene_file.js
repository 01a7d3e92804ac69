// A scene file that is dropped with the models that it names (.npz): the pack that `thrum view` would make of it. What
// links and coupled bodies take of whole meshes is taken from those files here. A scene that is wrong is refused as the
// program refuses it, and one that says what the page does not read (scene_keys.js) with the command that shows it.
// SPDX-License-Identifier: Apache-2.0
import { pick } from '../../javascript/src/fields.js';
import { readModelFile } from './model_file.js';
import { checkScene, keysOf, nameOf, withFallbacks } from './scene_keys.js';
import { colourOf, obstacleOf, quaternionOf } from './scene_obstacle.js';
import { baseMotionOf, startOf } from './scene_texts.js';

const DEGREE = Math.PI / 180;
const ROOM = { each: 1024, first: 64, beyond: 128 }; // for touches, a body: of the first so many, and of those beyond
const OVERLAP = 5e-3; // of a body's diagonal: it may begin that deep in something
const TURNS = 0.02; // of its lowest frequency: a body that begins to turn so fast is coupled
const MESH = /[:@]|\.(veg|msh|mesh|vtk|vtu|inp|node|ele|obj|stl)$/i; // made by the program, or files of one

/** What the program shows and the page does not. */
class BeyondPage extends Error {}

/** The models that bodies name: from the files that came along, or of the page as it is.
 * @returns {{models: object[], files: (Uint8Array|undefined)[], of: number[]}} of: each body's model */
function findModels(bodies, files, shown, engine) {
  const models = [];
  const found = [];
  const names = [];
  const of = bodies.map(({ model }, n) => {
    if (names.includes(model)) return names.indexOf(model);
    const base = model.replace(/^.*[/\\]/, '');
    const file = files.get(base) ?? files.get(`${base}.npz`);
    const known = shown.find(({ name, title }) => [model, base].includes(name) || title === model);
    if (!file && !known) {
      if (/\.npz$/i.test(base)) throw new Error(`drop ${base} with it`);
      const why = MESH.test(model) ? 'is a mesh, which the program precomputes' : 'is not in this page';
      throw new BeyondPage(`bodies[${n}].model: "${model}" ${why}`);
    }
    models.push(file ? readModelFile(engine, file, base) : known);
    found.push(file);
    return names.push(model) - 1;
  });
  return { models, files: found, of };
}

/** How a body starts that its modes displace; the scale and the density of a body change the mass that its modes are of.
 * @param {import('./pack.js').Model} model */
function startsOf(texts, { rank, arrays: { basis } }, { scale, density }, at) {
  const q = new Array(rank).fill(0);
  for (const text of texts) {
    const start = startOf(text);
    if (!start) throw new BeyondPage(`${at}.start: this page does not read "${text}"`);
    const { mode, amplitude } = start;
    if (mode >= rank) throw new Error(`${at}.start: the model has modes 1 to ${rank}, there is no mode ${mode + 1}`);
    let extent = 0;
    for (let row = 0; row < basis.length; row += 3 * rank)
      extent = Math.max(extent, Math.hypot(basis[row + mode], basis[row + rank + mode], basis[row + 2 * rank + mode]));
    q[mode] += (amplitude / extent) * Math.sqrt(density * scale ** 3);
  }
  return { q, p: new Array(rank).fill(0) };
}

const textsOf = (given) => (typeof given === 'string' ? [given] : given);

/** α of Rayleigh damping, of a number or a pair. */
const alphaOf = (damping) => (Array.isArray(damping) ? damping[0] : damping);

/** Is a body coupled of which the file does not say so (driver/scene/scene_run_couple.c)? @param {boolean} whole its mesh came along */
function couples({ free, spin, stiffness, density, scale, error, budget, condense }, { masters, arrays: { omega2, c4 } }, integrator, whole) {
  const lowest = Math.sqrt((omega2.find((w2) => w2 > 0) ?? Infinity) * (stiffness / density)) / scale;
  return free && whole && integrator === 'energy' && !masters && Boolean(c4) && !(condense || error || budget)
    && DEGREE * Math.hypot(...spin) >= TURNS * lowest;
}

/** A body as `thrum view` packs it. @param {import('./engine.js').Engine} engine */
function bodyOf(engine, given, n, models, of, scene, collide, whole) {
  const model = models[of[n]];
  const { rank, masters } = model;
  const at = `bodies[${n}]`;
  if (masters && given.rank !== undefined && given.rank !== rank)
    throw new Error(`${at}.rank: coordinates of ${given.model} follow others and cannot be left out; ` +
      `give "condense" of 1 to ${masters}`);
  const body = withFallbacks(keysOf(engine.memory), given, 'bodies');
  const coupled = given.coupled ?? couples(body, model, given.integrator ?? scene.integrator, whole);
  const starts = textsOf(body.start);

  // the rows of the library, some of which a scene file has in its own way
  return { ...pick(engine.memory, 'body', body), name: nameOf(given, n), model: of[n], rotation: quaternionOf(body.rotation),
    rank: given.condense ?? given.rank ?? rank, condense: body.condense ?? 0, colour: colourOf(body.colour), coupled,
    collide: collide && body.collide, spin: body.spin.map((x) => DEGREE * x),
    integrator: given.integrator ?? scene.integrator, damping: alphaOf(given.damping ?? scene.damping), loads: [],
    ...(starts.length > 0 && startsOf(starts, model, body, at)) };
}

/** The scene of the file, but for its obstacles and links. */
function sceneOf(engine, file, models, of, found) {
  const keys = keysOf(engine.memory);
  const { bodies, ...given } = withFallbacks(keys, file, 'scene');
  const { title, gravity, dt, integrator } = given;
  const collide = file.collide ?? bodies.some(({ free }) => free);
  const base_motion = textsOf(given.base_motion).map((text) => {
    const motion = baseMotionOf(text);
    if (!motion) throw new BeyondPage(`base_motion: this page does not read "${text}"`);
    return motion;
  });
  const scene = { title, dt, own_dt: true, integrator, gravity, damping: alphaOf(given.damping), base_motion, obstacles: [] };
  scene.bodies = bodies.map((body, n) => bodyOf(engine, body, n, models, of, scene, collide, found[of[n]] !== undefined));
  if (file.wind) scene.wind = withFallbacks(keys, file.wind, 'wind');
  if ((collide && bodies.length > 1) || bodies.some((body) => body.self_contact)) {
    const first = Math.min(bodies.length, ROOM.first);
    scene.collisions = { thickness: 0, ...withFallbacks(keys, file.collisions ?? {}, 'collisions'),
      touches: ROOM.each * first + ROOM.beyond * (bodies.length - first) };
  }
  return scene;
}

/** Refuses a body that begins inside an obstacle or another body. @param {import('./engine.js').Engine} trial with the scene */
function checkStart({ bodies, obstacles }, given, trial) {
  const { body, other, obstacle, solid, depth, diagonal } = trial.overlap();
  if (body < 0 || depth <= OVERLAP * diagonal) return;
  const isSolid = solid >= 0;
  const index = obstacles.map((_, n) => n).filter((n) => (obstacles[n].kind === 'solid') === isSolid)[isSolid ? solid : obstacle];
  const named = given[index]?.name ? `obstacle "${given[index].name}"` : `obstacles[${index}]`;
  const within = other >= 0 ? `body "${bodies[other].name}"` : named;
  const far = `${Number(depth.toPrecision(3))} m deep into ${within}`;
  throw new Error(`bodies[${body}].position: puts "${bodies[body].name}" ${far}: move it out`);
}

/** Links of the whole meshes that came along. @param {import('./engine.js').Engine} whole with the scene, of whole meshes */
function linksOf(given, scene, files, whole) {
  const bodyNumber = (name) => {
    const n = scene.bodies.findIndex((body) => body.name === name);
    if (!files[scene.bodies[n].model])
      throw new BeyondPage(`the page has only the surface of "${name}", which is linked: drop its model with it`);
    return n;
  };
  return given.map((link) => {
    const { kind, path = [], until, stiffness, damping, name, axis } = withFallbacks(keysOf(whole.memory), link, 'links');
    const body = bodyNumber(link.body);
    const other = link.other === undefined ? undefined : bodyNumber(link.other);
    const made = whole.weighLink({ kind, body, other, vertices: targetOf(link.at, scene.bodies[body], whole),
      other_vertices: other === undefined ? undefined : targetOf(link.other_at, scene.bodies[other], whole),
      place: link.place, other_place: link.other_place, axis, stiffness, length: link.length });
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
    const [unread] = checkScene(keysOf(engine.memory), file);
    const { models, files: found, of } = findModels(file.bodies, files, shown.models, engine);
    if (unread) throw new BeyondPage(`${unread}: this page does not read it`);
    const scene = sceneOf(engine, file, models, of, found);

    // what links and coupled bodies need is made in an engine that has the whole meshes
    const whole = await engine.another();
    models.forEach((model, n) => (found[n] ? whole.addWholeModel(found[n]) : whole.addModel(model)));
    const coupled = scene.bodies.filter((body) => body.coupled).map(({ model }) => model);
    const without = coupled.find((model) => !found[model]);
    if (without !== undefined)
      throw new BeyondPage(`the page has only the surface of "${models[without].name}", whose spin and shape are coupled: ` +
        'drop its model with it');
    // bodies of whole meshes have no surface, and need none
    const bodies = scene.bodies.map((body) => ({ ...body, self_contact: false }));
    whole.build({ ...scene, bodies, collisions: undefined, wind: undefined });
    scene.links = linksOf(file.links ?? [], scene, found, whole);
    scene.obstacles = (file.obstacles ?? []).map((obstacle) => obstacleOf(obstacle, whole));
    const packed = models.map((model, n) => (coupled.includes(n)
      ? { ...model, arrays: { ...model.arrays, inertia: whole.inertia(n) } } : model));

    // the library has the last word on what the page is to show
    const trial = await engine.another();
    packed.forEach((model) => trial.addModel(model));
    trial.build(scene);
    checkStart(scene, file.obstacles ?? [], trial);
    return { scene, models: packed };
  } catch (error) {
    const page = name.replace(/\.json$/i, '.html');
    const way = error instanceof BeyondPage ? `. The program shows it: thrum view ${name} -o ${page}, then drop ${page} here` : '';
    throw new Error(`${name}: ${error.message}${way}`);
  }
}
