// SPDX-License-Identifier: Apache-2.0
// What a screen reader speaks: questions, pauses and ends, each once.
// Rule: no part of the page that counts on, such as the time left, is in a region that is read aloud.

const MOST_SPOKEN = 4;

class Announcer {
  constructor(polite, urgent) {
    Object.assign(this, { polite, urgent, spoken: new Set() });
  }

  /** Has words read aloud, once for a key. An urgent one interrupts what is being read. */
  once(key, words, { urgent = false } = {}) {
    if (this.spoken.has(key)) return;
    this.spoken.add(key);
    const host = urgent ? this.urgent : this.polite;
    host.append(make("p", {}, words)); // next to what is being read, which it does not replace
    while (host.childElementCount > MOST_SPOKEN) host.firstElementChild.remove();
  }
}
