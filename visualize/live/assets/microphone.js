// SPDX-License-Identifier: Apache-2.0
// On the browser's thread of sound: what the microphone picks up, as 16-bit samples, in pieces of 128 ms.

const PIECE = 2048;

class Pieces extends AudioWorkletProcessor {
  constructor() {
    super();
    this.held = new Int16Array(PIECE);
    this.count = 0;
  }

  process([[samples]]) {
    for (const sample of samples || []) {
      this.held[this.count++] = Math.max(-32768, Math.min(32767, Math.round(sample * 32767)));
      if (this.count < PIECE) continue;
      this.port.postMessage(this.held.buffer, [this.held.buffer]);
      this.held = new Int16Array(PIECE);
      this.count = 0;
    }
    return true;
  }
}

registerProcessor("pieces", Pieces);
