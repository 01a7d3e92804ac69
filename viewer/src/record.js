// Records the canvas as a video that the browser then saves.
// SPDX-License-Identifier: Apache-2.0

export class Recorder {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    /** @type {Blob|null} the last video */
    this.video = null;
  }

  get recording() {
    return this.media?.state === 'recording';
  }

  start() {
    const chunks = [];
    this.media = new MediaRecorder(this.canvas.captureStream(60));
    this.media.ondataavailable = (event) => chunks.push(event.data);
    this.media.start(200);
    this.chunks = chunks;
  }

  /** @returns {Promise<Blob>} the video, which is also offered for download */
  async stop() {
    const stopped = new Promise((done) => { this.media.onstop = done; });
    this.media.stop();
    await stopped;
    this.media.stream.getTracks().forEach((track) => track.stop());
    this.video = new Blob(this.chunks, { type: 'video/webm' });
    save(this.video, 'thrum.webm');
    return this.video;
  }
}

function save(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}
