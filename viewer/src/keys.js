// Keys that act wherever the focus is, but for those that the control in focus uses itself.
// SPDX-License-Identifier: Apache-2.0

const ARROWS = ['ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown', 'Home', 'End'];

/** Does the control use the key? A button or a list that was clicked keeps the focus, and is not
 * what a person then means; one that was reached by the keyboard is.
 * @param {HTMLElement} control @param {string} key */
function isUsedBy(control, key) {
  if (control.tagName === 'INPUT' && control.type === 'range') return ARROWS.includes(key);
  if (!control.matches(':focus-visible')) return false;
  if (control.tagName === 'SELECT') return true;
  return ['BUTTON', 'INPUT'].includes(control.tagName) && key === ' ';
}

/** @param {Object<string, () => void>} actions of the keys, by KeyboardEvent.key */
export function listenToKeys(actions) {
  const meant = (event) => {
    const action = actions[event.key.length === 1 ? event.key.toLowerCase() : event.key];
    const { ctrlKey, altKey, metaKey, target } = event;
    return ctrlKey || altKey || metaKey || isUsedBy(target, event.key) ? undefined : action;
  };
  addEventListener('keydown', (event) => {
    const action = meant(event);
    if (!action) return;
    event.preventDefault();
    if (event.key === ' ' && event.repeat) return;
    action();
  });

  // some browsers click a button as its Space comes up
  addEventListener('keyup', (event) => {
    if (event.key === ' ' && meant(event)) event.preventDefault();
  });
}
