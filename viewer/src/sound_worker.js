// A thread of its own in which a struck body is stepped once a sample (sound.js), so that pictures go
// on. It takes a strike, and answers with what it steps and then with samples, piece by piece.
// SPDX-License-Identifier: Apache-2.0
import { Engine } from './engine.js';
import { StruckSound } from './sound.js';
import { SECONDS } from './strike.js';

const PIECE = 0.05; // of sound [s]
let last = 0;

onmessage = async ({ data: { id, module, strike } }) => {
  last = id;
  try {
    const sound = new StruckSound(await Engine.of(module), strike);
    const { rank, step } = sound.fit();
    postMessage({ id, rank, step, faster: sound.faster });
    const count = Math.round(PIECE * strike.rate);
    for (let made = 0; rank > 0 && made < SECONDS * strike.rate; made += count) {
      const samples = sound.next(count);
      postMessage({ id, samples }, [samples.buffer]);
      await new Promise((done) => { setTimeout(done); }); // another strike may have come
      if (id !== last) return;
    }
  } catch (error) {
    postMessage({ id, failed: error.message });
  }
};
