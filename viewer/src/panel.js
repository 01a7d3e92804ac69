// The controls: what each slider means, and what the page says about time and modes.
// SPDX-License-Identifier: Apache-2.0
import { INTEGRATOR_NAMES } from './engine.js';
import { GRADIENT, QUANTITIES, quantitiesOf } from './colours.js';
import { coarseText } from './coarse_step.js';
import { quantityText } from './numbers.js';
import { isComposed } from './scenes.js';
import { drawSplit } from './plot.js';
import { fewestStepped, mostStepped } from './pack.js';
import { QUALITIES } from './quality.js';

const ERRORS_MOST = 8;
const find = (id) => document.getElementById(id);
const power = (base) => ({ read: (x) => base ** x, write: (y) => Math.log(y) / Math.log(base) });
const plain = { read: (x) => x, write: (y) => y };

/** What may be marked in the picture: edges of triangles, held vertices, touches, links. */
const MARKS = ['edges', 'held', 'touches', 'links'];

/** Range of each slider, its scale, and how its value reads. */
const SLIDERS = {
  dt: {
    min: -4, max: -1.6, step: 'any', ...power(10), text: (v) => `${(1e3 * v).toPrecision(3)} ms`,
  },
  rank: { min: 1, max: 1, step: 1, ...plain, text: (v) => `${v}` },
  gravity: { min: 0, max: 30, step: 0.01, ...plain, text: (v) => `${v.toFixed(2)} m/s²` },
  damping: { min: 0, max: 5, step: 0.01, ...plain, text: (v) => `${v.toFixed(2)} 1/s` },
  stiffness: { min: -4, max: 4, step: 0.05, ...power(2), text: (v) => `× ${v.toPrecision(3)}` },
  pull: { min: -1, max: 2, step: 0.05, ...power(10), text: (v) => `× ${v < 99.5 ? v.toPrecision(2) : v.toFixed(0)}` },
  magnify: { min: 0, max: 5, step: 'any', ...power(10), text: (v) => `× ${v < 999.5 ? v.toPrecision(3) : v.toFixed(0)}` },
};

export class Panel {
  /** @param {import('./world.js').World} world
   * @param {{set: (name: string, value: *) => void, choose: (choice: number) => void,
   *   toggled: () => void}} actions */
  constructor(world, actions) {
    this.world = world;
    for (const [name, slider] of Object.entries(SLIDERS)) {
      Object.assign(find(name), { min: slider.min, max: slider.max, step: slider.step });
      find(name).addEventListener('input', () => {
        actions.set(name, slider.read(find(name).valueAsNumber));
        this.refresh();
      });
    }
    fill(find('integrator'), INTEGRATOR_NAMES.map((name) => [name, name]));
    find('integrator').addEventListener('change', () => {
      actions.set('integrator', find('integrator').value);
      this.refresh(); // one that is refused is not shown
    });
    find('colour').addEventListener('change', () => actions.set('colour', find('colour').value));
    find('sound').addEventListener('change', () => actions.set('sound', find('sound').checked));
    fill(find('quality'), QUALITIES.map((name) => [name, name]));
    find('quality').addEventListener('change', () => actions.set('quality', find('quality').value));
    find('scale').querySelector('i').style.background = GRADIENT;
    for (const name of MARKS)
      find(name).addEventListener('change', () => actions.set(name, find(name).checked));
    this.listModels();
    find('model').addEventListener('change', () => actions.choose(Number(find('model').value)));
    find('menu').addEventListener('click', () => {
      this.toggle();
      actions.toggled();
    });
    if (innerWidth <= 720 || innerHeight <= 420) this.toggle();
  }

  /** What may be chosen of the pack. */
  listModels() {
    const { pack, recording } = this.world;
    const models = pack.models.map((model, n) => [n, model.title ?? model.name]);
    const whole = isComposed(pack) ? [[-1, recording?.title ?? 'the scene']] : [];
    fill(find('model'), [...whole, ...models]);

    fill(find('colour'), quantitiesOf(pack).map((name) => [name, QUANTITIES[name].title]));
  }

  /** Opens and closes the settings. */
  toggle() {
    find('panel').hidden = !find('panel').hidden;
    find('menu').setAttribute('aria-pressed', String(!find('panel').hidden));
  }

  /** Shows the settings as they are. */
  refresh() {
    const { settings, bodies, choice, compared, plays, recording, orbit } = this.world;
    find('model').value = choice;
    find('colour').value = settings.colour;
    find('quality').value = settings.quality;
    for (const name of MARKS) find(name).checked = settings[name];

    // nothing acts on what was recorded
    document.querySelectorAll('.live').forEach((part) => { part.hidden = plays; });
    find('compare').hidden = plays;
    find('scrub').hidden = !plays;
    document.querySelectorAll('.orbit').forEach((part) => { part.hidden = !orbit; });
    find('hint').textContent = orbit ? 'Press on the curve, or ← and →, to pick a motion; its period is shown in 2 s'
      : plays ? 'Drag to look around' : 'Drag a body to pull it, drag beside it to look around';
    this.showErrors();
    if (plays) {
      Object.assign(find('scrub'), recording.slider);
      this.#showSlider('magnify');
      return;
    }
    find('rank').min = Math.min(...bodies.map(({ model }) => fewestStepped(model)));
    find('rank').max = Math.max(...bodies.map(({ model }) => mostStepped(model)));
    Object.keys(SLIDERS).forEach((name) => this.#showSlider(name));
    find('integrator').value = settings.integrator;
    find('sound').checked = settings.sound;
    find('integrator').disabled = compared;
  }

  #showSlider(name) {
    const value = this.world.settings[name];
    find(name).value = SLIDERS[name].write(value);
    document.querySelector(`output[for=${name}]`).textContent = SLIDERS[name].text(value);
  }

  /** What a run says that the bases of its bodies have wrong, a line for each of the first few. */
  showErrors() {
    const { pack, plays } = this.world;
    const told = plays ? pack.scene.bodies.filter(({ error }) => error) : [];
    const lines = told.slice(0, ERRORS_MOST).map(({ name, error }) => told.length > 1 ? `${name}: ${error}` : error);
    find('errors').textContent = lines.join('\n');
    find('errors').hidden = lines.length === 0;
  }

  /** Modes of the first body: how many are stepped explicitly, how fast they are and how fast they are
   * stepped; whether it has switched to the energy integrator or gained energy by itself, and how many
   * of its steps needed more than quasi-Newton; and of a coarse step what `thrum simulate` says. */
  showSplit() {
    const { engine, settings } = this.world;
    const { explicit, implicit, fallbacks, switched, firstSwitch, grown } = engine.report(0);
    const by = switched ? `, switched to energy after step ${firstSwitch}` : '';
    const lost = grown > 0 ? ', lost: its energy grew by itself' : '';
    const helped = fallbacks > 0 ? `, ${fallbacks} steps fell back` : '';
    const frequencies = engine.frequencies(0);
    const coarse = coarseText(frequencies.find((f) => f > 0), settings);
    find('split-text').textContent = `${explicit} explicit, ${implicit} implicit${by}${lost}${helped}${coarse}`;
    drawSplit(find('split'), frequencies, engine.steppedFrequencies(0), explicit);
  }

  /** What the colours stand for, up to the largest value since the beginning. */
  showScale() {
    const { settings, top } = this.world;
    const { unit } = QUANTITIES[settings.colour];
    find('scale').hidden = unit === undefined;
    find('scale-top').textContent = unit ? quantityText(top, unit) : '';
  }

  /** @param {Object<string, import('./clock.js').Meter>} meters step, upload, draw, frame */
  showTimes(meters) {
    const text = (ms) => (ms < 1 ? `${(1e3 * ms).toFixed(0)} µs` : `${ms.toFixed(1)} ms`);
    for (const [name, meter] of Object.entries(meters))
      find(`time-${name}`).textContent = meter.count === 0 ? '' : text(meter.mean);
    find('level').textContent = this.world.level;
  }
}

function fill(select, options) {
  select.replaceChildren(...options.map(([value, text]) => new Option(text, value)));
}
