// Which quality is chosen by how long drawing takes.
// SPDX-License-Identifier: Apache-2.0
import assert from 'node:assert/strict';
import { test } from 'node:test';
import { QualityChooser } from '../src/quality.js';

/** Draws so often on a machine that takes so long for each level. */
function run(chooser, times, count) {
  for (let n = 0; n < count; n++) chooser.add(times[chooser.level]);
  return chooser.level;
}

test('the finest level that is quick enough is found, and one slow drawing changes nothing', () => {
  const quick = { full: 5, plain: 4, half: 3, coarse: 2 };
  const chooser = new QualityChooser();
  assert.equal(run(chooser, quick, 9), 'full');
  chooser.add(500);
  assert.equal(run(chooser, quick, 9), 'full');
  assert.equal(run(new QualityChooser(), { full: 300, plain: 90, half: 30, coarse: 12 }, 30), 'half');
  assert.equal(run(new QualityChooser(), { full: 900, plain: 400, half: 200, coarse: 90 }, 30), 'coarse');
});

test('a machine that becomes quick is drawn finely again, and a level that was too slow rests', () => {
  const chooser = new QualityChooser();
  run(chooser, { full: 300, plain: 90, half: 30, coarse: 12 }, 12);
  assert.equal(run(chooser, { full: 5, plain: 4, half: 3, coarse: 2 }, 60), 'full');

  // half is quick enough to try the next one, which is not: it is tried seldom
  const between = { full: 300, plain: 90, half: 5, coarse: 4 };
  const other = new QualityChooser();
  let tried = 0;
  for (let n = 0; n < 200; n++) {
    if (other.level === 'plain') tried++;
    other.add(between[other.level]);
  }
  assert.ok(tried < 30, `${tried} of 200`);
});
