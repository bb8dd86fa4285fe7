// SPDX-License-Identifier: Apache-2.0
// The line to the server: a stream that comes back by itself, and requests that carry the token.
// Rule: the token travels in a header alone, never in an address.

const OPENS_MS = 10000, SILENT_MS = 2500, FIRST_MS = 150, LONGEST_MS = 2000;
const ANSWERS_MS = 2000, LASTING = ["e_stop", "cancel"];
const UNREACHED = "the run does not answer";

class Line {
  /** @param token text  @param listener {message(kind, data), line(word, why)} */
  constructor(token, listener) {
    Object.assign(this, { token, listener, last: "", wait: FIRST_MS, over: false, clock: null });
  }

  headers(more) {
    return { "X-Mission-Token": this.token, ...more };
  }

  async get(path) {
    try {
      return await fetch(path,
        { headers: this.headers(), cache: "no-store", redirect: "error", signal: AbortSignal.timeout(OPENS_MS) });
    } catch {
      throw new Error(UNREACHED);
    }
  }

  /** Posts a body, JSON where no header names another type: the status, and what the server reports. */
  async post(path, body, { signal = null, headers = {} } = {}) {
    const answer = await fetch(path,
      { method: "POST", headers: this.headers({ "Content-Type": "application/json", ...headers }), body, signal,
        cache: "no-store", redirect: "error" });
    return [answer.status, await answer.json()];
  }

  /** When an order is given, by the server's clock as of its last message. */
  sent() {
    return this.clock ? { "X-Mission-Sent": String(this.clock.sent + (performance.now() - this.clock.received) / 1000) }
      : {};
  }

  /** Gives an order; its fate is done, refused, waiting, unanswered or undelivered. `late` is called once where no
   *  answer has
   *  come in time: a stop and a cancel then keep trying to get through,
   and any other order is taken back if it can be. */
  async order(order, late) {
    const cut = new AbortController();
    let isLate = false;
    const timer = setTimeout(() => {
      isLate = true;
      late();
      if (!LASTING.includes(order.command)) cut.abort();
    }, ANSWERS_MS);
    try {
      const [status, { success, why }] =
        await this.post("/orders", JSON.stringify(order), { signal: cut.signal, headers: this.sent() });
      return { fate: success ? "done" : status === 202 ? "waiting" : "refused", why };
    } catch {
      return { fate: isLate ? "unanswered" : "undelivered", why: "" };
    } finally {
      clearTimeout(timer);
    }
  }

  /** Writes a sentence to the robot: whether it was taken, and why not. */
  talk(text, by) {
    return this.give("/talk", JSON.stringify({ text, by }));
  }

  /** A piece of sound for the run's recognisers: whether it was taken, and why not. */
  sound(piece, key, by, last) {
    return this.give(`/sound?${new URLSearchParams({ key, by, ...(last ? { last: "1" } : {}) })}`, piece,
      { "Content-Type": "audio/l16" });
  }

  async give(path, body, headers = {}) {
    try {
      const [, { success, why }] = await this.post(path, body, { signal: AbortSignal.timeout(OPENS_MS), headers });
      return { sent: success, why };
    } catch {
      return { sent: false, why: "the run cannot be reached; use the robot's own stop" };
    }
  }

  async run() {
    while (!this.over) {
      try {
        await this.once();
        if (!this.over) this.listener.line("away", "the line is down; trying again");
      } catch {
        this.listener.line("away", "the line is down; trying again");
      }
      if (this.over) break;
      await new Promise((done) => setTimeout(done, this.wait * (0.75 + Math.random() / 2)));
      this.wait = Math.min(LONGEST_MS, this.wait * 2);
    }
  }

  async once() {
    const cut = new AbortController();
    this.cut = cut;
    let watch = 0;
    const expectWithin = (most = SILENT_MS) => {
      clearTimeout(watch);
      watch = setTimeout(() => cut.abort(), most);
    };
    expectWithin(OPENS_MS);
    try {
      const answer = await fetch("/events",
        { headers: this.headers(this.last ? { "Last-Event-ID": this.last } : {}), cache: "no-store", signal: cut.signal,
          redirect: "error" });
      if (!answer.ok) return await this.refused(answer);
      expectWithin();
      this.listener.line("live", "");
      this.wait = FIRST_MS;
      await this.read(answer.body.pipeThrough(new TextDecoderStream()).getReader(), expectWithin);
    } finally {
      clearTimeout(watch);
    }
  }

  async refused(answer) {
    const why = (await answer.json().catch(() => ({}))).why || `the server answered ${answer.status}`;
    this.over = answer.status === 401 || answer.status === 403;
    this.listener.line(this.over ? "refused" : "away", why);
  }

  async read(reader, expectWithin) {
    let text = "";
    for (;;) {
      const { done, value } = await reader.read();
      if (done) return;
      expectWithin();
      text += value;
      let end;
      while ((end = text.indexOf("\n\n")) >= 0) {
        this.message(text.slice(0, end));
        text = text.slice(end + 2);
      }
    }
  }

  message(block) {
    const fields = Object.fromEntries(
      block.split("\n").map((each) => [each.slice(0, each.indexOf(": ")), each.slice(each.indexOf(": ") + 2)]));
    const kind = fields.event, data = JSON.parse(fields.data);
    if (typeof data.sent === "number") this.clock = { sent: data.sent, received: performance.now() };
    this.listener.message(kind, data);
    if (fields.id) this.last = fields.id;
    if (kind === "end") this.over = true;
  }
}
