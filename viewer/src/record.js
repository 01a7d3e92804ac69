// Records the canvas as a video that the browser then saves.
// SPDX-License-Identifier: Apache-2.0

export class Recorder {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    /** @type {Blob[]} of the video, as they come */
    this.chunks = [];
  }

  /** What was recorded so far [bytes]. */
  get size() {
    return this.chunks.reduce((sum, chunk) => sum + chunk.size, 0);
  }

  get recording() {
    return this.media?.state === 'recording';
  }

  start() {
    this.chunks = [];
    this.media = new MediaRecorder(this.canvas.captureStream(60));
    this.media.ondataavailable = (event) => this.chunks.push(event.data);
    this.media.start(200);
  }

  /** Ends the video and has the browser save it. */
  async stop() {
    const stopped = new Promise((done) => { this.media.onstop = done; });
    this.media.stop();
    await stopped;
    this.media.stream.getTracks().forEach((track) => track.stop());
    save(new Blob(this.chunks, { type: 'video/webm' }), 'thrum.webm');
  }
}

/** Has the browser save something. @param {Blob} blob @param {string} name */
export function save(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
