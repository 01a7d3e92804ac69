// What the page says to a person: a text, and ways out of it as buttons.
// SPDX-License-Identifier: Apache-2.0

const find = (id) => document.getElementById(id);

/** @param {string} text @param {[string, () => void][]} ways names of buttons, and what they do */
export function showNotice(text, ways = []) {
  find('notice-text').textContent = text;
  find('ways').replaceChildren(...ways.map(([name, action]) => {
    const button = document.createElement('button');
    button.textContent = name;
    button.addEventListener('click', action);
    return button;
  }));
  find('ways').hidden = ways.length === 0;
  find('notice').hidden = false;
}

export function hideNotice() {
  find('notice').hidden = true;
}
