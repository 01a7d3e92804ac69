// Light and dark, as the system asks for: style.css has the colours of the page, these are those of
// the picture.
// SPDX-License-Identifier: Apache-2.0

const THEMES = {
  light: { background: 0xe9eef3, ground: 0xeef2f6, held: 0x20303f },
  dark: { background: 0x161c23, ground: 0x2b343e, held: 0xd5dde5 },
};

/** A colour of style.css, such as 'var(--ink)', as what a canvas takes. @param {string} colour */
export function cssColour(colour) {
  const [, name] = /^var\((--\w+)\)$/.exec(colour) ?? [];
  return name ? getComputedStyle(document.documentElement).getPropertyValue(name).trim() : colour;
}

/** Paints now, and whenever the system changes. @param {(theme: object) => void} paint */
export function followTheme(paint) {
  const dark = matchMedia('(prefers-color-scheme: dark)');
  const now = () => paint(THEMES[dark.matches ? 'dark' : 'light']);
  dark.addEventListener('change', now);
  now();
}
