// SPDX-License-Identifier: Apache-2.0
// The microphone of the page: opened and shut by its button, never by itself; its sound goes to the run's recognisers.
// Rule: where it cannot be used, the reason is shown in its place.

const RATE_HZ = 16000;
const MOST_BEHIND = 12; // pieces of 128 ms that may be under way; more are dropped

class Speak {
  /** @param line Line
   *  @param listener {notify(words, kind), who()}
   *  @param deaf why the run recognises nothing, or "" */
  constructor(line, listener, deaf) {
    Object.assign(this, { line, listener, behind: 0, key: "" });
    this.button = byId("talk-speak");
    const why = deaf || Speak.why();
    this.button.hidden = Boolean(why);
    byId("talk-deaf").textContent = shown(why ? `No microphone: ${why}` : "");
    this.button.addEventListener("click", () => (this.key ? this.shut() : this.open()));
  }

  static why() {
    if (!window.isSecureContext) return "a browser gives one to https and to localhost only";
    if (!navigator.mediaDevices || !window.AudioWorkletNode) return "this browser gives none to pages";
    return "";
  }

  static end(stream) {
    for (const track of stream.getTracks()) track.stop();
  }

  async open() {
    const key = (this.key = String(Math.random()).slice(2));
    this.show();
    try {
      const stream = await navigator.mediaDevices.getUserMedia(
        { audio: { channelCount: 1, echoCancellation: true, noiseSuppression: false, autoGainControl: true } });
      if (key !== this.key) return Speak.end(stream); // shut before it was allowed
      this.stream = stream;
      this.sound = new AudioContext({ sampleRate: RATE_HZ });
      await this.sound.audioWorklet.addModule("/microphone.js");
      if (key !== this.key) return;
      this.pieces = new AudioWorkletNode(this.sound, "pieces", { numberOfOutputs: 0 });
      this.pieces.port.onmessage = ({ data }) => this.send(data, key);
      this.sound.createMediaStreamSource(this.stream).connect(this.pieces);
    } catch (fault) {
      if (key !== this.key) return;
      this.release();
      this.listener.notify(`no microphone: ${fault.message || fault.name}`, "bad");
    }
  }

  async send(piece, key, last = false) {
    if ((key !== this.key && !last) || this.behind >= MOST_BEHIND) return;
    this.behind += 1;
    const { sent, why } = await this.line.sound(piece, key, this.listener.who(), last);
    this.behind -= 1;
    if (sent || last || key !== this.key) return;
    this.release();
    this.listener.notify(`not taken: ${why}`, "bad");
  }

  shut() {
    const key = this.key;
    this.release();
    this.send(new ArrayBuffer(0), key, true);
  }

  release() {
    this.key = "";
    if (this.stream) Speak.end(this.stream);
    if (this.sound) this.sound.close();
    this.stream = this.sound = this.pieces = null;
    this.show();
  }

  show() {
    this.button.setAttribute("aria-pressed", String(Boolean(this.key)));
    this.button.textContent = this.key ? "listening" : "speak";
  }
}
