// What sounds have of a frequency. SPDX-License-Identifier: Apache-2.0

/** The part of a frequency in samples at a rate. @param {number} rate [1/s] */
export const partOf = (rate) => (samples, frequency) => {
  let [re, im] = [0, 0];
  samples.forEach((x, n) => {
    const angle = (2 * Math.PI * frequency * n) / rate;
    re += x * Math.cos(angle);
    im += x * Math.sin(angle);
  });
  return Math.hypot(re, im);
};
