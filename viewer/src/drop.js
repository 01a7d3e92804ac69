// Files that are dropped on the page, or opened: models and pages of `thrum view` are shown; for
// anything else the page says why not, and the command that makes something of it.
// SPDX-License-Identifier: Apache-2.0
import { packOfModels, readModelFile } from './model_file.js';
import { packOfPage, readPack } from './pack.js';
import { packOfScene } from './scene_file.js';

const MESHES = /\.(veg|msh|mesh|vtk|vtu|inp|node|ele)$/i;
const SURFACES = /\.(obj|stl)$/i;

/** Why a file is not shown, and what to do. @param {string} name */
function reason(name) {
  const model = `${name.replace(/\.[^.]*$/, '')}.npz`;
  if (MESHES.test(name))
    return `${name} is a mesh. Its modes take a sparse solver that this page does not have: ` +
      `thrum precompute ${name} -o ${model}, then drop ${model} here`;
  if (SURFACES.test(name))
    return `${name} is a surface without an inside: thrum mesh ${name} -o filled.msh, ` +
      `thrum precompute filled.msh -o ${model}, then drop ${model} here`;
  if (/\.(glb|gltf)$/i.test(name))
    return `${name} says how something looks, and not what it is made of. A run is played by ` +
      'thrum view RUN; of a surface write an .obj or .stl, and begin with thrum mesh';
  return `${name} is no model (.npz) and no page of thrum view`;
}

/** What some files hold, as a pack. Throws what the page says of files that it cannot show.
 * @param {File[]} files @param {import('./engine.js').Engine} engine without models
 * @param {import('./pack.js').Pack} shown the page as it is, with all models that scenes may name @returns {Promise<object>} */
export async function packOfFiles(files, engine, shown) {
  const refused = files.find(({ name }) => !/\.(npz|html?|json)$/i.test(name));
  if (refused) throw new Error(reason(refused.name));
  const bytes = await Promise.all(files.map(async (file) => new Uint8Array(await file.arrayBuffer())));
  const scene = files.findIndex(({ name }) => /\.json$/i.test(name));
  if (scene >= 0) {
    const beside = files.map(({ name }, n) => [name, bytes[n]]).filter((_, n) => n !== scene);
    if (beside.some(([name]) => !/\.npz$/i.test(name))) throw new Error('one scene at a time, with models (.npz) beside it');
    return packOfScene({ name: files[scene].name, bytes: bytes[scene] }, new Map(beside), shown, engine);
  }
  const page = files.findIndex(({ name }) => !/\.npz$/i.test(name));
  if (page >= 0) {
    if (files.length > 1) throw new Error('one page at a time, and no models beside it');
    return readPack(await packOfPage(new TextDecoder().decode(bytes[page])));
  }
  return packOfModels(files.map(({ name }, n) => {
    try {
      return readModelFile(engine, bytes[n], name);
    } catch (error) {
      throw new Error(`${name}: ${error.message}`);
    }
  }));
}

/** @param {HTMLInputElement} chooser @param {(files: File[]) => void} open */
export function listenToFiles(chooser, open) {
  const withFiles = (event) => event.dataTransfer?.types.includes('Files');
  addEventListener('dragover', (event) => { if (withFiles(event)) event.preventDefault(); });
  addEventListener('drop', (event) => {
    if (!withFiles(event)) return;
    event.preventDefault();
    open([...event.dataTransfer.files]);
  });
  chooser.addEventListener('change', () => {
    if (chooser.files.length > 0) open([...chooser.files]);
    chooser.value = '';
  });
}
