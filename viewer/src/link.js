// The settings in the address of the page, behind its #, so that a link shows what one sees.
// SPDX-License-Identifier: Apache-2.0

const NUMBERS = ['dt', 'rank', 'gravity', 'damping', 'stiffness', 'pull', 'magnify'];
const TEXTS = ['integrator', 'colour', 'quality'];
const FLAGS = ['edges', 'held', 'touches', 'links'];

/** @param {object} settings @param {{choice: number, compared: boolean, point?: number}} shown @returns {string} */
export function hashOf(settings, { choice, compared, point }) {
  const all = new URLSearchParams({ choice, compared: Number(compared) });
  for (const name of [...NUMBERS, ...TEXTS, ...FLAGS]) all.set(name, settings[name]);
  if (point !== undefined) all.set('point', point);
  return `#${all}`;
}

/** What an address says; what it does not name, or names wrongly, is left out.
 * @param {string} hash @returns {{choice?: number, compared?: boolean, point?: number, settings: object}} */
export function readHash(hash) {
  const all = new URLSearchParams(hash.replace(/^#/, ''));
  const settings = {};
  for (const name of NUMBERS)
    if (all.has(name) && Number.isFinite(Number(all.get(name)))) settings[name] = Number(all.get(name));
  for (const name of TEXTS) if (all.has(name)) settings[name] = all.get(name);
  for (const name of FLAGS) if (all.has(name)) settings[name] = all.get(name) === 'true';
  const point = Number(all.get('point'));
  return { settings, ...(point > 0 && { point }), ...(all.has('choice') && { choice: Number(all.get('choice')) }),
    ...(all.has('compared') && { compared: all.get('compared') === '1' }) };
}
