// Numbers for a person.
// SPDX-License-Identifier: Apache-2.0

const PREFIXES = [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ']];

/** A number for a person: three digits, a prefix and the unit. @param {number} value */
export function quantityText(value, unit) {
  const size = Math.abs(value);
  const [factor, prefix] = PREFIXES.find(([least]) => size >= least * (1 - 5e-4)) ?? [1, ''];
  const scaled = value / factor;
  if (size > 0 && (size < 1e-6 * (1 - 5e-4) || Math.abs(scaled) >= 999.5)) return `${value.toExponential(1)} ${unit}`;
  return `${scaled.toPrecision(3)} ${prefix}${unit}`;
}
